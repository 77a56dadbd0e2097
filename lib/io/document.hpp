/// TOML documents as typed tables that remember which keys were read, so that a key nobody reads is an
/// error.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"

namespace veriflex::io {

/// What the longest list of texts may hold: the lists of a case become attributes of its result file, which
/// HDF5 limits to 64 KiB.
inline constexpr std::size_t longest_list = 2000;

/// One table of a document. A copy refers to the same table. Every reader throws InputError with file, line
/// and column when the value is missing (for the forms without default), of another type, or not finite where
/// a number is asked for.
class Table {
 public:
  struct Node;
  explicit Table(std::shared_ptr<Node> node) : node_(std::move(node)) {}

  bool has(const std::string& key) const;
  bool has_list(const std::string& key) const;  // there, and an array
  bool has_text(const std::string& key) const;  // there, and a text

  double number(const std::string& key) const;  // finite; an integer counts as a number
  std::int64_t integer(const std::string& key, std::int64_t min, std::int64_t max) const;
  bool flag(const std::string& key) const;
  std::string text(const std::string& key) const;  // not empty
  std::vector<double> numbers(const std::string& key) const;
  std::vector<std::int64_t> integers(const std::string& key) const;
  std::vector<std::string> texts(const std::string& key) const;
  Table table(const std::string& key) const;
  std::vector<Table> tables(const std::string& key) const;  // an array of tables; empty when absent

  /// As number(), but `inf` is allowed too.
  double number_or_infinity(const std::string& key) const;
  /// As numbers(), but each may be `inf` or `nan`, where there is none.
  std::vector<double> numbers_or_none(const std::string& key) const;

  std::optional<double> number_if(const std::string& key) const;
  double number(const std::string& key, double otherwise) const;
  std::string text(const std::string& key, const std::string& otherwise) const;
  bool flag(const std::string& key, bool otherwise) const;
  /// One of `allowed`, with the nearest suggested otherwise.
  std::string choice(const std::string& key, const std::vector<std::string>& allowed) const;

  std::vector<std::string> keys() const;

  /// A key that stands in the document.
  struct Entry {
    std::string path;                 // dotted, from this table; entries of `[[name]]` are `name[]`
    std::optional<std::string> text;  // its value, where that is text
    Place place;
  };
  /// All keys here and in the tables below, whether or not anything reads them.
  std::vector<Entry> entries() const;

  Place place() const;
  Place place(const std::string& key) const;
  [[noreturn]] void fail(const std::string& key, const std::string& problem, const std::string& why,
                         const std::string& suggestion) const;

  /// The value at a dotted path below this table as TOML text, `[[name]]` entries as `name.0`; nothing when
  /// there is none.
  std::optional<std::string> shown(const std::string& path) const;
  /// The value of a key of this table as TOML text, and of an array's entries.
  std::string shown_value(const std::string& key) const;
  std::vector<std::string> shown_values(const std::string& key) const;

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

/// A text or a number as TOML, so that reading gives it back: quoted and escaped; the fewest digits, never
/// without point or exponent, lest it read as an integer too large for one.
std::string toml_text(const std::string& text);
std::string toml_text(double number);

/// The key that `word` stands for in the tables called `table`, wherever they stand; empty where it is no
/// other name of a key. What is in the document under such a name is read under that key.
using Synonyms = std::function<std::string_view(std::string_view table, std::string_view word)>;

/// The document in `text`, after applying `overrides` of the form `dotted.key=value` (a TOML value; a bare
/// word is taken as text). `[[name]]` entries are addressed as `name.0`; the number after the last adds one.
/// An override of a key or table that the document lacks adds it, and a reader that does not know it will
/// object. One without value, `key=`, removes the key or table. Entries of a list are
/// addressed by their number, `nodes.2=32`. `synonyms` hold in the text, in `overrides` and in
/// Table::shown(). Throws InputError, also where a key stands under two names, with both places.
Table parse_document(const std::string& text, const std::string& file,
                     const std::vector<std::string>& overrides = {}, const Synonyms& synonyms = {});

}  // namespace veriflex::io
