#include "io/hdf5_names.hpp"

#include <fmt/format.h>
#include <hdf5.h>

#include "base/error.hpp"

namespace veriflex::io {

std::vector<std::string> hdf5_names(const std::filesystem::path& path, const std::string& group) {
  std::vector<std::string> names;
  const auto add = [](hid_t, const char* name, const H5L_info_t*, void* all) -> herr_t {
    static_cast<std::vector<std::string>*>(all)->emplace_back(name);
    return 0;
  };
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t opened = file < 0 ? -1 : H5Gopen2(file, group.c_str(), H5P_DEFAULT);
  const herr_t status =
      opened < 0 ? -1 : H5Literate(opened, H5_INDEX_NAME, H5_ITER_INC, nullptr, add, &names);
  if (opened >= 0) H5Gclose(opened);
  if (file >= 0) H5Fclose(file);
  if (status < 0)
    throw InputError({path.string()}, fmt::format("has no group '{}'", group), "a result has",
                     "Run the case again");
  return names;
}

}  // namespace veriflex::io
