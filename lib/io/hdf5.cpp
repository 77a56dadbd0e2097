#include "io/hdf5.hpp"

#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <atomic>
#include <new>
#include <span>
#include <stdexcept>
#include <string_view>

#include "base/error.hpp"
#include "io/file.hpp"

namespace veriflex::io {

namespace {

// What stands before the HDF5 structure: a multiple of 512 bytes that is a power of two, which every HDF5
// library skips ("user block"). The library crashes on some damaged files, so they must not come before it.
constexpr std::size_t seal_size = 512;

// Files in memory that are open at the same time are told apart by name.
std::string new_name() {
  static std::atomic<unsigned> count = 0;
  return fmt::format("in-memory-{}", count++);
}

std::string seal_of(const std::string& name, std::string_view structure) {
  std::string seal = fmt::format("{}\nbytes {}\nsha256 {}\n", name, structure.size(), sha256(structure));
  seal.resize(seal_size, '\n');
  return seal;
}

// Throws what has just made the library refuse: lack of memory, or a mistake of the caller.
[[noreturn]] void refused(const std::string& what) {
  struct Reasons {
    bool lacks_memory = false;
    std::string all;
  } reasons;
  const auto look = [](unsigned, const H5E_error2_t* error, void* to) -> herr_t {
    Reasons& found = *static_cast<Reasons*>(to);
    const hid_t minor = error->min_num;
    if (error->maj_num == H5E_RESOURCE || minor == H5E_NOSPACE || minor == H5E_CANTALLOC)
      found.lacks_memory = true;
    found.all += fmt::format("; {}", error->desc);
    return 0;
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, look, &reasons);
  if (reasons.lacks_memory) throw std::bad_alloc();
  throw std::runtime_error(fmt::format("HDF5 library: cannot {}{}", what, reasons.all));
}

// An HDF5 identifier with the function that closes it.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t), const std::string& what) : id_(id), close_(close) {
    if (id < 0) refused("make " + what);
  }
  ~Handle() { close_(id_); }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

void check(herr_t status, const std::string& what) {
  if (status < 0) refused("write " + what);
}

Handle utf8_text() {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose, "a text type");
  check(H5Tset_size(type, H5T_VARIABLE), "a text type");
  check(H5Tset_cset(type, H5T_CSET_UTF8), "a text type");
  return Handle(H5Tcopy(type), H5Tclose, "a text type");
}

// At least one pointer, even for no values: the library refuses a null buffer for an empty attribute.
std::vector<const char*> pointers(const std::vector<std::string>& values) {
  std::vector<const char*> all;
  for (const std::string& value : values) all.push_back(value.c_str());
  if (all.empty()) all.push_back(nullptr);
  return all;
}

Handle extent(std::size_t count) {
  const hsize_t size = count;
  return Handle(H5Screate_simple(1, &size, nullptr), H5Sclose, "an extent");
}

// Of transfers. Texts are converted in a buffer, of 1 MB twice for each data set unless it is told otherwise:
// clearing these took longer than all else that a small result costs.
class SmallBuffer : public Handle {
 public:
  SmallBuffer() : Handle(H5Pcreate(H5P_DATASET_XFER), H5Pclose, "transfer properties") {
    constexpr std::size_t bytes = std::size_t{1} << 14;
    check(H5Pset_buffer(*this, bytes, nullptr, nullptr), "transfer properties");
  }
};

// `chunk`: of a data set that is compressed, else empty.
void write_dataset(hid_t file, const std::string& path, hid_t file_type, hid_t memory_type, hid_t space,
                   const void* data, const std::vector<hsize_t>& chunk = {}) {
  const Handle links(H5Pcreate(H5P_LINK_CREATE), H5Pclose, "link properties");
  check(H5Pset_create_intermediate_group(links, 1), path);
  const Handle properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "data set properties");
  check(H5Pset_obj_track_times(properties, false), path);
  if (!chunk.empty()) {
    check(H5Pset_chunk(properties, static_cast<int>(chunk.size()), chunk.data()), path);
    check(H5Pset_shuffle(properties), path);
    check(H5Pset_deflate(properties, 1), path);
  }
  const Handle set(H5Dcreate2(file, path.c_str(), file_type, space, links, properties, H5P_DEFAULT), H5Dclose,
                   path);
  check(H5Dwrite(set, memory_type, H5S_ALL, H5S_ALL, SmallBuffer(), data), path);
}

void write_attribute(hid_t file, const std::string& path, const std::string& name, hid_t file_type,
                     hid_t memory_type, hid_t space, const void* data) {
  const Handle object(H5Oopen(file, path.c_str(), H5P_DEFAULT), H5Oclose, path);
  const Handle attribute(H5Acreate2(object, name.c_str(), file_type, space, H5P_DEFAULT, H5P_DEFAULT),
                         H5Aclose, path + "@" + name);
  check(H5Awrite(attribute, memory_type, data), path + "@" + name);
}

// Chunks of some 1 MB, whole in all but the first index.
template <class Value>
void write_array(hid_t file, const std::string& path, hid_t file_type, hid_t memory_type,
                 std::span<const Value> values, const std::vector<std::size_t>& shape) {
  const std::vector<hsize_t> sizes(shape.begin(), shape.end());
  const Handle space(H5Screate_simple(static_cast<int>(sizes.size()), sizes.data(), nullptr), H5Sclose, path);
  std::vector<hsize_t> chunk;
  if (values.size_bytes() >= std::size_t{1} << 16) {
    chunk = sizes;
    const std::size_t row = values.size_bytes() / shape.front();
    chunk.front() = std::clamp<hsize_t>((std::size_t{1} << 20) / row, 1, sizes.front());
  }
  write_dataset(file, path, file_type, memory_type, space, values.data(), chunk);
}

Handle scalar() { return Handle(H5Screate(H5S_SCALAR), H5Sclose, "a scalar"); }

}  // namespace

Hdf5Image::Hdf5Image() {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // errors are thrown, not printed
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "file properties");
  check(H5Pset_fapl_core(access, std::size_t{1} << 20, false), "file properties");
  file_ = H5Fcreate(new_name().c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access);
  if (file_ < 0) refused("make a file in memory");
}

Hdf5Image::~Hdf5Image() { H5Fclose(file_); }

void Hdf5Image::group(const std::string& path) {
  const Handle links(H5Pcreate(H5P_LINK_CREATE), H5Pclose, "link properties");
  check(H5Pset_create_intermediate_group(links, 1), path);
  const Handle made(H5Gcreate2(file_, path.c_str(), links, H5P_DEFAULT, H5P_DEFAULT), H5Gclose, path);
}

void Hdf5Image::text(const std::string& path, const std::string& value) {
  const Handle type = utf8_text();
  const char* data = value.c_str();
  write_dataset(file_, path, type, type, scalar(), &data);
}

void Hdf5Image::texts(const std::string& path, const std::vector<std::string>& values) {
  const Handle type = utf8_text();
  write_dataset(file_, path, type, type, extent(values.size()), pointers(values).data());
}

void Hdf5Image::numbers(const std::string& path, std::span<const double> values) {
  write_dataset(file_, path, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, extent(values.size()), values.data());
}

void Hdf5Image::array(const std::string& path, std::span<const double> values,
                      const std::vector<std::size_t>& shape) {
  write_array(file_, path, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, values, shape);
}

void Hdf5Image::array(const std::string& path, std::span<const std::int64_t> values,
                      const std::vector<std::size_t>& shape) {
  write_array(file_, path, H5T_STD_I64LE, H5T_NATIVE_INT64, values, shape);
}

void Hdf5Image::array(const std::string& path, std::span<const std::uint8_t> values,
                      const std::vector<std::size_t>& shape) {
  write_array(file_, path, H5T_STD_U8LE, H5T_NATIVE_UINT8, values, shape);
}

void Hdf5Image::attribute(const std::string& path, const std::string& name, const std::string& value) {
  const Handle type = utf8_text();
  const char* data = value.c_str();
  write_attribute(file_, path, name, type, type, scalar(), &data);
}

void Hdf5Image::attribute(const std::string& path, const std::string& name, std::int64_t value) {
  write_attribute(file_, path, name, H5T_STD_I64LE, H5T_NATIVE_INT64, scalar(), &value);
}

void Hdf5Image::attribute(const std::string& path, const std::string& name,
                          const std::vector<std::string>& values) {
  const Handle type = utf8_text();
  write_attribute(file_, path, name, type, type, extent(values.size()), pointers(values).data());
}

void Hdf5Image::attribute(const std::string& path, const std::string& name, std::span<const double> values) {
  write_attribute(file_, path, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, extent(values.size()), values.data());
}

void Hdf5Image::attribute(const std::string& path, const std::string& name,
                          std::span<const std::int64_t> values) {
  write_attribute(file_, path, name, H5T_STD_I64LE, H5T_NATIVE_INT64, extent(values.size()), values.data());
}

void Hdf5Image::ascii_attribute(const std::string& path, const std::string& name, const std::string& value) {
  const Handle type(H5Tcopy(H5T_C_S1), H5Tclose, "a text type");
  check(H5Tset_size(type, value.size()), "a text type");
  write_attribute(file_, path, name, type, type, scalar(), value.data());
}

std::vector<char> Hdf5Image::bytes(const std::string& name) const {
  check(H5Fflush(file_, H5F_SCOPE_GLOBAL), "the file");
  const ssize_t size = H5Fget_file_image(file_, nullptr, 0);
  if (size < 0) refused("read back the file made in memory");
  std::vector<char> image(seal_size + static_cast<std::size_t>(size));
  char* const structure = image.data() + seal_size;
  if (H5Fget_file_image(file_, structure, static_cast<std::size_t>(size)) != size) {
    refused("read back the file made in memory");
  }
  const std::string seal = seal_of(name, {structure, static_cast<std::size_t>(size)});
  std::copy(seal.begin(), seal.end(), image.begin());
  return image;
}

namespace {

[[noreturn]] void damaged(const std::string& file, const std::string& what) {
  throw InputError({file}, fmt::format("no readable {} in it", what), "damaged, truncated or no result file",
                   "Run the case again, or remove the file");
}

// Runs `read`, whose failures are those of the file.
template <class Read>
auto reading(const std::string& file, const std::string& what, Read read) {
  try {
    return read();
  } catch (const std::runtime_error&) {
    damaged(file, what);
  }
}

std::size_t size_of(hid_t space) {
  const hssize_t size = H5Sget_simple_extent_npoints(space);
  if (size < 0) throw std::runtime_error("no extent");
  return static_cast<std::size_t>(size);
}

void require_type(hid_t type, H5T_class_t wanted) {
  const bool is_text_as_written = wanted != H5T_STRING || H5Tis_variable_str(type) > 0;
  if (H5Tget_class(type) != wanted || !is_text_as_written) throw std::runtime_error("another type");
}

// Texts that the library has allocated, copied and given back.
std::vector<std::string> taken(std::vector<char*>& raw, hid_t type, hid_t space) {
  std::vector<std::string> values;
  for (const char* text : raw) values.emplace_back(text == nullptr ? "" : text);
  H5Dvlen_reclaim(type, space, H5P_DEFAULT, raw.data());
  return values;
}

}  // namespace

Hdf5File::Hdf5File(const std::filesystem::path& path, const std::string& name) : name_(path.string()) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // errors are thrown, not printed
  const std::string seal = read_start(path, seal_size);
  if (!seal.starts_with(name + '\n')) {
    throw InputError({name_}, "has no checksum in front",
                     fmt::format("no {}, or one of an earlier version", name),
                     "Run the case again, or remove the file");
  }
  // Its size first: what is no result may be too large to be read at all.
  std::error_code unknown;
  const auto size = std::filesystem::file_size(path, unknown);
  const bool has_size = seal.find(fmt::format("\nbytes {}\n", size - seal.size())) != std::string::npos;
  std::string bytes = has_size ? read_file(path) : std::string();
  if (bytes.size() < seal_size || seal != seal_of(name, std::string_view(bytes).substr(seal_size))) {
    throw InputError({name_}, "does not match its checksum", "damaged or truncated",
                     "Run the case again, or remove the file");
  }
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "file properties");
  check(H5Pset_fapl_core(access, std::size_t{1} << 20, false), "file properties");
  check(H5Pset_file_image(access, bytes.data() + seal_size, bytes.size() - seal_size), "file properties");
  file_ = H5Fopen(new_name().c_str(), H5F_ACC_RDONLY, access);
  if (file_ < 0) damaged(name_, "HDF5 structure");
}

Hdf5File::~Hdf5File() { H5Fclose(file_); }

namespace {

// What read(attribute, space) makes of an attribute of one value of that class, or of a list of them.
template <class Read>
auto read_attribute(const std::string& file_name, hid_t file, const std::string& path,
                    const std::string& name, H5T_class_t wanted, bool is_list, Read read) {
  return reading(file_name, fmt::format("attribute '{}' of {}", name, path), [&] {
    const Handle object(H5Oopen(file, path.c_str(), H5P_DEFAULT), H5Oclose, path);
    const Handle attribute(H5Aopen(object, name.c_str(), H5P_DEFAULT), H5Aclose, name);
    const Handle space(H5Aget_space(attribute), H5Sclose, name);
    const Handle stored(H5Aget_type(attribute), H5Tclose, name);
    require_type(stored, wanted);
    if (!is_list && size_of(space) != 1) throw std::runtime_error("not one value");
    return read(attribute, space);
  });
}

std::vector<std::string> read_texts(hid_t attribute, hid_t space) {
  const Handle type = utf8_text();
  std::vector<char*> raw(size_of(space), nullptr);
  if (raw.empty()) return {};  // the library refuses a null buffer
  check(H5Aread(attribute, type, raw.data()), "attribute");
  return taken(raw, type, space);
}

}  // namespace

std::string Hdf5File::attribute(const std::string& path, const std::string& name) const {
  return read_attribute(name_, file_, path, name, H5T_STRING, false, read_texts).front();
}

std::vector<std::string> Hdf5File::attribute_texts(const std::string& path, const std::string& name) const {
  return read_attribute(name_, file_, path, name, H5T_STRING, true, read_texts);
}

std::int64_t Hdf5File::integer(const std::string& path, const std::string& name) const {
  return read_attribute(name_, file_, path, name, H5T_INTEGER, false, [&](hid_t attribute, hid_t) {
    std::int64_t value = 0;
    check(H5Aread(attribute, H5T_NATIVE_INT64, &value), name);
    return value;
  });
}

bool Hdf5File::holds_texts(const std::string& path) const {
  return reading(name_, path, [&] {
    const Handle set(H5Dopen2(file_, path.c_str(), H5P_DEFAULT), H5Dclose, path);
    const Handle stored(H5Dget_type(set), H5Tclose, path);
    return H5Tget_class(stored) == H5T_STRING;
  });
}

bool Hdf5File::holds(const std::string& path) const {
  // Where a group on the way is missing the library takes that for an error, which is no yes.
  return reading(name_, path, [&] { return H5Lexists(file_, path.c_str(), H5P_DEFAULT) > 0; });
}

bool Hdf5File::has_attribute(const std::string& path, const std::string& name) const {
  return H5Aexists_by_name(file_, path.c_str(), name.c_str(), H5P_DEFAULT) > 0;
}

std::vector<std::string> Hdf5File::names(const std::string& path) const {
  return reading(name_, path, [&] {
    const Handle group(H5Gopen2(file_, path.c_str(), H5P_DEFAULT), H5Gclose, path);
    H5G_info_t info{};
    check(H5Gget_info(group, &info), path);
    std::vector<std::string> names;
    for (hsize_t i = 0; i < info.nlinks; ++i) {
      const auto name = [&](char* to, std::size_t size) {
        return H5Lget_name_by_idx(group, ".", H5_INDEX_NAME, H5_ITER_INC, i, to, size, H5P_DEFAULT);
      };
      std::string& one =
          names.emplace_back(static_cast<std::size_t>(std::max<ssize_t>(0, name(nullptr, 0))), ' ');
      if (name(one.data(), one.size() + 1) < 0) throw std::runtime_error("a link without a name");
    }
    return names;
  });
}

std::vector<std::string> Hdf5File::texts(const std::string& path) const {
  return reading(name_, path, [&] {
    const Handle set(H5Dopen2(file_, path.c_str(), H5P_DEFAULT), H5Dclose, path);
    const Handle space(H5Dget_space(set), H5Sclose, path);
    const Handle stored(H5Dget_type(set), H5Tclose, path);
    require_type(stored, H5T_STRING);
    const Handle type = utf8_text();
    std::vector<char*> raw(size_of(space), nullptr);
    check(H5Dread(set, type, H5S_ALL, H5S_ALL, SmallBuffer(), raw.data()), path);
    return taken(raw, type, space);
  });
}

std::vector<double> Hdf5File::numbers(const std::string& path) const {
  return reading(name_, path, [&] {
    const Handle set(H5Dopen2(file_, path.c_str(), H5P_DEFAULT), H5Dclose, path);
    const Handle space(H5Dget_space(set), H5Sclose, path);
    const Handle stored(H5Dget_type(set), H5Tclose, path);
    require_type(stored, H5T_FLOAT);
    std::vector<double> values(size_of(space));
    check(H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), path);
    return values;
  });
}

}  // namespace veriflex::io
