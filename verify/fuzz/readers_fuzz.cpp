// Feeds arbitrary bytes to the readers of cases, references, ledger, settings, tables, LAMMPS data and
// results. The first byte chooses the reader. What they refuse, they refuse with an InputError; anything else
// is a finding.
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "engine/audit.hpp"
#include "engine/case.hpp"
#include "engine/difference.hpp"
#include "engine/ledger.hpp"
#include "engine/reference.hpp"
#include "engine/stored_result.hpp"
#include "io/csv.hpp"
#include "io/hdf5.hpp"
#include "io/lammps_data.hpp"
#include "measures/drivers.hpp"
#include "scene/lammps_network.hpp"
#include "studies/studies.hpp"

using namespace veriflex;

namespace {

/// A file in memory where there is one, of this process.
void put(const std::filesystem::path& path, const char* bytes, std::size_t size) {
  std::ofstream(path, std::ios::binary).write(bytes, static_cast<std::streamsize>(size));
}

void read_stored(const std::filesystem::path& path) {
  const engine::StoredResult result = engine::read_result(path);
  engine::audit(std::vector{result}, std::vector{result});
  engine::difference(result, result);
}

std::vector<std::string> split(const std::string& line, char separator) {
  std::vector<std::string> words;
  std::istringstream rest(line);
  for (std::string word; std::getline(rest, word, separator);) words.push_back(word);
  return words;
}

template <class Number>
std::vector<Number> numbers_of(const std::vector<std::string>& words, std::size_t from) {
  std::vector<Number> numbers;
  for (std::size_t i = from; i < words.size(); ++i) {
    Number number{};
    std::from_chars(words[i].data(), words[i].data() + words[i].size(), number);
    numbers.push_back(number);
  }
  return numbers;
}

/// A file with its checksum and sound HDF5 in it, which may hold anything else. A line for each thing: `g` a
/// group, `t` texts, `n` numbers, `i` integers; `T`, `N`, `I` attributes; the path, for these the name, and
/// the values, with tabs between.
void write_described(const std::filesystem::path& path, const std::string& text) {
  io::Hdf5Image image;
  for (const std::string& line : split(text, '\n')) {
    const std::vector<std::string> words = split(line, '\t');
    if (words.size() < 2 || words[0].size() != 1) continue;
    const bool is_attribute = words[0] == "T" || words[0] == "N" || words[0] == "I";
    if (is_attribute && words.size() < 3) continue;
    const std::size_t first = is_attribute ? 3 : 2;
    const std::vector<std::string> values(words.begin() + static_cast<std::ptrdiff_t>(first), words.end());
    const std::vector<double> numbers = numbers_of<double>(words, first);
    const std::vector<std::int64_t> integers = numbers_of<std::int64_t>(words, first);
    try {
      switch (words[0][0]) {
        case 'g':
          image.group(words[1]);
          break;
        case 't':
          image.texts(words[1], values);
          break;
        case 'n':
          image.numbers(words[1], numbers);
          break;
        case 'i':
          image.array(words[1], std::span(integers), {integers.size()});
          break;
        case 'T':
          if (values.size() == 1) image.attribute(words[1], words[2], values[0]);
          if (values.size() != 1) image.attribute(words[1], words[2], values);
          break;
        case 'N':
          image.attribute(words[1], words[2], std::span(numbers));
          break;
        case 'I':
          if (integers.size() == 1) image.attribute(words[1], words[2], integers[0]);
          if (integers.size() != 1) image.attribute(words[1], words[2], std::span(integers));
          break;
        default:
          break;
      }
    } catch (const std::runtime_error&) {  // a path that the library does not take
    }
  }
  const std::vector<char> bytes = image.bytes();
  put(path, bytes.data(), bytes.size());
}

void read(char reader, const std::string& text) {
  if (reader == 't') {
    io::parse_csv(text, "fuzz.csv");
  } else if (reader == 'r') {
    engine::read_reference(io::parse_document(text, "fuzz.toml"), "/nowhere/fuzz.toml");
  } else if (reader == 'l') {
    engine::read_ledger(io::parse_document(text, "fuzz.toml"));
  } else if (reader == 'd') {
    scene::network_of(io::parse_lammps_data(text, "fuzz.data"), {2});
  } else if (reader == 'h' || reader == 'e') {
    static const std::filesystem::path path =
        (std::filesystem::exists("/dev/shm") ? "/dev/shm" : std::filesystem::temp_directory_path()) /
        ("veriflex-fuzz-" + std::to_string(getpid()) + ".h5");
    if (reader == 'h') {
      put(path, text.data(), text.size());
    } else {
      write_described(path, text);
    }
    read_stored(path);
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

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

/// Of what describes a file, whole lines and values are changed, too: bytes alone leave little of it that
/// gets past the first thing that is missing.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  std::minstd_rand random(seed);
  if (size < 2 || data[0] != 'e' || random() % 4 == 0) return LLVMFuzzerMutate(data, size, max_size);
  std::vector<std::string> lines = split(std::string(data + 1, data + size), '\n');
  if (lines.empty()) return LLVMFuzzerMutate(data, size, max_size);
  const std::size_t at = random() % lines.size(), other = random() % lines.size();
  std::vector<std::string> words = split(lines[at], '\t');
  switch (random() % 6) {
    case 0:
      lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(at));
      words.clear();
      break;
    case 1:  // another kind of thing
      if (!words.empty()) words[0] = std::string(1, "gtniTNI"[random() % 7]);
      break;
    case 2:
      if (!words.empty()) words.pop_back();
      break;
    case 3:
      words.resize(std::min<std::size_t>(words.size(), 2 + random() % 2));
      break;
    case 4:
      words.emplace_back(
          std::vector<std::string>{"", "0", "-1", "nan", "1e308", "9223372036854775807"}[random() % 6]);
      break;
    default:
      std::swap(lines[at], lines[other]);
      words.clear();
  }
  if (!words.empty()) {
    lines[at].clear();
    for (std::size_t i = 0; i < words.size(); ++i) lines[at] += (i > 0 ? "\t" : "") + words[i];
  }
  std::string text = "e";
  for (const std::string& line : lines) text += line + '\n';
  if (text.size() > max_size) return LLVMFuzzerMutate(data, size, max_size);
  std::copy(text.begin(), text.end(), data);
  return text.size();
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  try {
    read(static_cast<char>(data[0]), std::string(data + 1, data + size));
  } catch (const InputError&) {
  }
  return 0;
}
