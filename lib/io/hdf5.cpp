#include "io/hdf5.hpp"

#include <fmt/format.h>
#include <hdf5.h>

#include <stdexcept>

namespace veriflex::io {

namespace {

// An HDF5 identifier with the function that closes it.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t), const std::string& what) : id_(id), close_(close) {
    if (id < 0) throw std::runtime_error(fmt::format("HDF5 library: cannot make {}", what));
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
  if (status < 0) throw std::runtime_error(fmt::format("HDF5 library: cannot write {}", what));
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

void write_dataset(hid_t file, const std::string& path, hid_t file_type, hid_t memory_type, hid_t space,
                   const void* data) {
  const Handle links(H5Pcreate(H5P_LINK_CREATE), H5Pclose, "link properties");
  check(H5Pset_create_intermediate_group(links, 1), path);
  const Handle properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "data set properties");
  check(H5Pset_obj_track_times(properties, false), path);
  const Handle set(H5Dcreate2(file, path.c_str(), file_type, space, links, properties, H5P_DEFAULT), H5Dclose,
                   path);
  check(H5Dwrite(set, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data), path);
}

void write_attribute(hid_t file, const std::string& path, const std::string& name, hid_t file_type,
                     hid_t memory_type, hid_t space, const void* data) {
  const Handle object(H5Oopen(file, path.c_str(), H5P_DEFAULT), H5Oclose, path);
  const Handle attribute(H5Acreate2(object, name.c_str(), file_type, space, H5P_DEFAULT, H5P_DEFAULT),
                         H5Aclose, path + "@" + name);
  check(H5Awrite(attribute, memory_type, data), path + "@" + name);
}

Handle scalar() { return Handle(H5Screate(H5S_SCALAR), H5Sclose, "a scalar"); }

}  // namespace

Hdf5Image::Hdf5Image() {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // errors are thrown, not printed
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "file properties");
  check(H5Pset_fapl_core(access, std::size_t{1} << 20, false), "file properties");
  file_ = H5Fcreate("in-memory", H5F_ACC_TRUNC, H5P_DEFAULT, access);
  if (file_ < 0) throw std::runtime_error("HDF5 library: cannot make a file in memory");
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

void Hdf5Image::numbers(const std::string& path, const std::vector<double>& values) {
  write_dataset(file_, path, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, extent(values.size()), values.data());
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

std::vector<char> Hdf5Image::bytes() const {
  check(H5Fflush(file_, H5F_SCOPE_GLOBAL), "the file");
  const ssize_t size = H5Fget_file_image(file_, nullptr, 0);
  if (size < 0) throw std::runtime_error("HDF5 library: cannot read back the file made in memory");
  std::vector<char> image(static_cast<std::size_t>(size));
  if (H5Fget_file_image(file_, image.data(), image.size()) != size) {
    throw std::runtime_error("HDF5 library: cannot read back the file made in memory");
  }
  return image;
}

}  // namespace veriflex::io
