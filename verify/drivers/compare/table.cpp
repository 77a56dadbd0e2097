#include "drivers/compare/table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>

#include "repository.hpp"

namespace veriflex::drivers::compare {

Table::Table(const io::Section& compare, const std::string& key, const std::string& id)
    : compare_(compare), key_(key) {
  const std::filesystem::path beside = std::filesystem::path(compare.place().file).parent_path();
  reference_ = engine::find_reference(id, beside, repository::references(), compare.place(key));
  if (reference_.columns.empty()) {
    compare.fail(key, fmt::format("reference '{}' has no table", reference_.id),
                 "its rows are what is compared", "Name a reference with [data]");
  }
}

void Table::need(const std::vector<std::string>& names) const {
  for (const std::string& name : names) {
    if (find(name) != nullptr) continue;
    std::vector<std::string> has;
    for (const io::CsvColumn& column : reference_.columns) has.push_back(column.name);
    compare_.fail(key_, fmt::format("the table of '{}' has no column '{}'", reference_.id, name),
                  fmt::format("it has: {}; needed: {}", fmt::join(has, ", "), fmt::join(names, ", ")),
                  "Look at the kind of comparison and at the table");
  }
}

Positions Table::vectors(const std::string& prefix, const std::string& suffix) const {
  Positions all(static_cast<Eigen::Index>(rows()), 3);
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<double>& values = (*this)[prefix + "xyz"[axis] + suffix];
    for (std::size_t i = 0; i < rows(); ++i) all(static_cast<Eigen::Index>(i), axis) = values[i];
  }
  return all;
}

bool Table::clamped(std::size_t row) const {
  const std::vector<double>* flags = find("clamped");
  return flags != nullptr && (*flags)[row] != 0.0;
}

const std::vector<double>* Table::find(const std::string& name) const {
  for (const io::CsvColumn& column : reference_.columns) {
    if (column.name == name) return &column.values;
  }
  return nullptr;
}

std::vector<std::string> xyz(const std::string& prefix, const std::string& suffix) {
  return {prefix + "x" + suffix, prefix + "y" + suffix, prefix + "z" + suffix};
}

std::vector<std::string> joined(std::vector<std::string> a,
                                const std::vector<std::vector<std::string>>& more) {
  for (const auto& names : more) a.insert(a.end(), names.begin(), names.end());
  return a;
}

Errors relative_errors(const std::vector<double>& difference, const std::vector<double>& peer,
                       const Table& table) {
  Largest scale;
  for (std::size_t i = 0; i < peer.size(); ++i) {
    if (!table.clamped(i)) scale.add(peer[i]);
  }
  Largest counted;
  Largest clamped;
  Errors errors;
  for (std::size_t i = 0; i < peer.size(); ++i) {
    errors.by_row.push_back(std::abs(difference[i]) / scale.value);
    (table.clamped(i) ? clamped : counted).add(errors.by_row.back());
  }
  errors.largest = counted.value;
  errors.largest_clamped = clamped.value;
  return errors;
}

std::vector<double> plus(std::vector<double> a, const std::vector<double>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] += b[i];
  return a;
}

std::vector<double> minus(std::vector<double> a, const std::vector<double>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] -= b[i];
  return a;
}

std::vector<double> lengths(const Positions& vectors) {
  const Eigen::VectorXd norms = vectors.rowwise().norm();
  return {norms.begin(), norms.end()};
}

void count_rows(const Table& table, observe::Observations& seen) {
  std::size_t clamped = 0;
  for (std::size_t i = 0; i < table.rows(); ++i) clamped += table.clamped(i);
  seen.metrics.push_back(
      {"rows", static_cast<double>(table.rows() - clamped), "1", "rows that were compared"});
  seen.metrics.push_back({"clamped_rows", static_cast<double>(clamped), "1",
                          "rows left out: the peer does not compute the stated potential there"});
}

}  // namespace veriflex::drivers::compare
