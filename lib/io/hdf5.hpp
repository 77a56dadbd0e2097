/// HDF5 files: made in memory, so that they reach the disk whole or not at all, and read back.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace veriflex::io {

/// The first line of a file, which says what it is.
inline const std::string result_seal = "veriflex-result";
inline const std::string checkpoint_seal = "veriflex-checkpoint";
inline const std::string snapshot_seal = "veriflex-snapshot";

/// The file being made. Paths are absolute ("/records/potential"); groups on the way to a data set are made
/// as needed. Identical calls give identical bytes: no times are stored. Every function throws
/// std::bad_alloc when the HDF5 library lacks memory, and std::runtime_error naming the path when it refuses
/// otherwise, which is a mistake of the caller.
class Hdf5Image {
 public:
  Hdf5Image();
  ~Hdf5Image();
  Hdf5Image(const Hdf5Image&) = delete;
  Hdf5Image& operator=(const Hdf5Image&) = delete;

  void group(const std::string& path);
  void text(const std::string& path, const std::string& value);
  void texts(const std::string& path, const std::vector<std::string>& values);
  void numbers(const std::string& path, std::span<const double> values);
  /// A table or grid, the last index fastest; where it is large, compressed without loss.
  void array(const std::string& path, std::span<const double> values, const std::vector<std::size_t>& shape);
  void array(const std::string& path, std::span<const std::int64_t> values,
             const std::vector<std::size_t>& shape);
  void array(const std::string& path, std::span<const std::uint8_t> values,
             const std::vector<std::size_t>& shape);

  /// Attributes of the group or data set at `path`, which must exist ("/" always does).
  void attribute(const std::string& path, const std::string& name, const std::string& value);
  void attribute(const std::string& path, const std::string& name, std::int64_t value);
  void attribute(const std::string& path, const std::string& name, const std::vector<std::string>& values);
  void attribute(const std::string& path, const std::string& name, std::span<const double> values);
  void attribute(const std::string& path, const std::string& name, std::span<const std::int64_t> values);
  /// Of fixed length, which some readers demand.
  void ascii_attribute(const std::string& path, const std::string& name, const std::string& value);

  /// The bytes of the file so far: 512 bytes with the SHA-256 of what follows, then the HDF5 structure.
  std::vector<char> bytes(const std::string& seal = result_seal) const;

 private:
  std::int64_t file_;
};

/// A file opened for reading, after its checksum was verified. Every function throws InputError when the file
/// was not made by Hdf5Image, is damaged, or lacks what is asked for.
class Hdf5File {
 public:
  explicit Hdf5File(const std::filesystem::path& path, const std::string& seal = result_seal);
  ~Hdf5File();
  Hdf5File(const Hdf5File&) = delete;
  Hdf5File& operator=(const Hdf5File&) = delete;

  const std::string& name() const { return name_; }                               // as messages give it
  std::string attribute(const std::string& path, const std::string& name) const;  // a text
  std::int64_t integer(const std::string& path, const std::string& name) const;   // an attribute
  std::vector<std::string> attribute_texts(const std::string& path, const std::string& name) const;
  std::vector<std::string> texts(const std::string& path) const;
  std::vector<double> numbers(const std::string& path) const;
  bool holds_texts(const std::string& path) const;
  bool holds(const std::string& path) const;
  bool has_attribute(const std::string& path, const std::string& name) const;
  /// The groups and data sets in a group, by name.
  std::vector<std::string> names(const std::string& group) const;

 private:
  std::string name_;
  std::int64_t file_;
};

}  // namespace veriflex::io
