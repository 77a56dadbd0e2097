#include "engine/attachments.hpp"

#include <algorithm>
#include <array>

#include "io/file.hpp"

namespace veriflex::engine {

namespace fs = std::filesystem;

fs::path attachments_folder(const std::string& name, const fs::path& folder) {
  return folder / (name + ".snapshots");
}

namespace {

constexpr std::array kinds{".vtu", ".vti", ".pvd", ".hdf", ".series", ".data"};

void remove_earlier(const fs::path& folder) {
  std::error_code none;
  std::vector<fs::path> earlier;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, none)) {
    const fs::path kind = entry.path().extension();
    if (std::find(kinds.begin(), kinds.end(), kind) != kinds.end()) earlier.push_back(entry.path());
  }
  for (const fs::path& file : earlier) fs::remove(file, none);
  fs::remove(folder, none);  // if nothing else is in it
}

}  // namespace

observe::Attach attach_to(const fs::path& folder, EarlierFiles of_earlier) {
  if (of_earlier == EarlierFiles::go) remove_earlier(folder);
  return [folder](const std::string& name, std::string_view bytes) { io::write_file(folder / name, bytes); };
}

}  // namespace veriflex::engine
