#include "measures/data_file.hpp"

#include <fmt/format.h>

#include <initializer_list>
#include <system_error>

#include "repository.hpp"

namespace veriflex::measures {

namespace fs = std::filesystem;

fs::path data_file(const io::Table& table, const std::string& key) {
  const fs::path beside = fs::path(table.place().file).parent_path();
  const std::string name = table.text(key);
  for (const fs::path& folder : {beside, repository::references()}) {
    std::error_code impossible;  // such as a name too long for the file system
    if (fs::is_regular_file(folder / name, impossible)) return folder / name;
  }
  table.fail(key, fmt::format("data file '{}' not found", name),
             fmt::format("searched {} and {}", beside.empty() ? "." : beside.string(),
                         repository::references().string()),
             "Name it relative to one of these");
}

}  // namespace veriflex::measures
