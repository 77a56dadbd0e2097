// Feeds arbitrary bytes to the readers of cases, references, ledger, settings and tables. The first byte
// chooses the reader. What they refuse, they refuse with an InputError; anything else is a finding.
#include <cstddef>
#include <cstdint>
#include <string>

#include "engine/case.hpp"
#include "engine/ledger.hpp"
#include "engine/reference.hpp"
#include "io/csv.hpp"
#include "measures/drivers.hpp"
#include "studies/studies.hpp"

using namespace veriflex;

namespace {

void read(char reader, const std::string& text) {
  if (reader == 't') {
    io::parse_csv(text, "fuzz.csv");
  } else if (reader == 'r') {
    engine::read_reference(io::parse_document(text, "fuzz.toml"), "/nowhere/fuzz.toml");
  } else if (reader == 'l') {
    engine::read_ledger(io::parse_document(text, "fuzz.toml"));
  } else if (reader == 's') {
    const std::size_t line = text.find('\n');
    if (line == std::string::npos) return;
    io::parse_document(text.substr(line + 1), "fuzz.toml", {text.substr(0, line)})
        .shown(text.substr(0, line));
  } else {
    std::vector<InputError> problems;
    const io::Table top = io::parse_document(text, "fuzz.toml");
    engine::read_parts(top, "/nowhere/fuzz.toml", studies::readers(), VERIFLEX_SOURCE_DIR "/reference",
                       problems);
    top.asked();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  try {
    read(static_cast<char>(data[0]), std::string(data + 1, data + size));
  } catch (const InputError&) {
  }
  return 0;
}
