/// TOML documents as typed sections that remember which keys were read, so that a key nobody reads is an
/// error.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/error.hpp"

namespace veriflex::io {

/// What the longest list of texts may hold: the lists of a case become attributes of its result file, which
/// HDF5 limits to 64 KiB.
inline constexpr std::size_t longest_list = 2000;

/// One table of a document. A copy refers to the same table. Every reader throws InputError with file, line
/// and column when the value is missing (for the forms without default), of another type, or not finite where
/// a number is asked for.
class Section {
 public:
  struct Node;
  explicit Section(std::shared_ptr<Node> node) : node_(std::move(node)) {}

  bool has(const std::string& key) const;
  bool has_list(const std::string& key) const;  // there, and an array
  bool has_text(const std::string& key) const;  // there, and a text

  double number(const std::string& key) const;  // finite; an integer counts as a number
  std::int64_t integer(const std::string& key, std::int64_t least, std::int64_t most) const;
  bool flag(const std::string& key) const;
  std::string text(const std::string& key) const;  // not empty
  std::vector<double> numbers(const std::string& key) const;
  std::vector<std::int64_t> integers(const std::string& key) const;
  std::vector<std::string> texts(const std::string& key) const;
  Section table(const std::string& key) const;
  std::vector<Section> tables(const std::string& key) const;  // an array of tables; empty when absent

  /// As number(), but `inf` is allowed too.
  double number_or_infinity(const std::string& key) const;

  std::optional<double> number_if(const std::string& key) const;
  double number(const std::string& key, double otherwise) const;
  std::string text(const std::string& key, const std::string& otherwise) const;
  bool flag(const std::string& key, bool otherwise) const;
  /// One of `allowed`, with the nearest suggested otherwise.
  std::string choice(const std::string& key, const std::vector<std::string>& allowed) const;

  std::vector<std::string> keys() const;
  Place place() const;
  Place place(const std::string& key) const;
  [[noreturn]] void fail(const std::string& key, const std::string& problem, const std::string& why,
                         const std::string& suggestion) const;

  /// The value at a dotted path below this table as TOML text, `[[name]]` entries as `name.0`; nothing when
  /// there is none.
  std::optional<std::string> shown(const std::string& path) const;

  /// One error per key, here or in any table below, that nothing has read.
  std::vector<InputError> unknown_keys() const;
  /// Says that this table's reader broke off: unknown_keys() then leaves it out, and the tables below.
  void abandon() const;
  /// Throws the first of unknown_keys().
  void finish() const;

  /// Dotted paths of every key that a reader has asked for, here and in the tables below, present or not; the
  /// entries of
  /// `[[name]]` are `name[]`. What the schema documents must list.
  std::vector<std::string> asked() const;

 private:
  std::shared_ptr<Node> node_;
};

/// The document in `text`, after applying `overrides` of the form `dotted.key=value` (a TOML value; a bare
/// word is taken as text). `[[name]]` entries are addressed as `name.0`; the number after the last adds one.
/// An override of a key or table that the document lacks adds it, and a reader that does not know it will
/// object. Throws InputError.
Section parse_document(const std::string& text, const std::string& file,
                       const std::vector<std::string>& overrides = {});

}  // namespace veriflex::io
