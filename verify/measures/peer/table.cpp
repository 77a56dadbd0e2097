#include "measures/peer/table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "repository.hpp"

namespace veriflex::measures::peer {

PeerTable::PeerTable(const io::Table& peer, const std::string& key, const std::string& id)
    : peer_(peer), key_(key) {
  const std::filesystem::path beside = std::filesystem::path(peer.place().file).parent_path();
  reference_ = engine::find_reference(id, beside, repository::references(), peer.place(key));
  if (reference_.columns.empty()) {
    peer.fail(key, fmt::format("reference '{}' has no table", reference_.id), "its rows are what is compared",
              "Name a reference with [data]");
  }
  const std::vector<bool> flags = clamped();
  if (std::find(flags.begin(), flags.end(), false) == flags.end()) {
    fail(fmt::format("all {} rows of '{}' are flagged as clamped", rows(), reference_.id),
         "nothing is left to be compared", "Add a row that the other program computes as stated");
  }
}

void PeerTable::fail(const std::string& problem, const std::string& why,
                     const std::string& suggestion) const {
  peer_.fail(key_, problem, why, suggestion);
}

std::vector<std::int64_t> PeerTable::counts(const std::string& name) const {
  constexpr double most = 1e15;  // whole numbers up to here are exact
  std::vector<std::int64_t> all;
  for (const double value : (*this)[name]) {
    if (!(value >= 0.0) || value > most || std::floor(value) != value) {
      fail(fmt::format("the table has a row of {} {}", name, value),
           fmt::format("it is a whole number from 0 to {}", most), "Mend the table");
    }
    all.push_back(static_cast<std::int64_t>(value));
  }
  return all;
}

void PeerTable::need(const std::vector<std::string>& names) const {
  for (const std::string& name : names) {
    if (find(name) != nullptr) continue;
    std::vector<std::string> has;
    for (const io::CsvColumn& column : reference_.columns) has.push_back(column.name);
    peer_.fail(key_, fmt::format("the table of '{}' has no column '{}'", reference_.id, name),
               fmt::format("it has: {}; needed: {}", fmt::join(has, ", "), fmt::join(names, ", ")),
               "Look at the kind of comparison and at the table");
  }
}

Positions PeerTable::vectors(const std::string& prefix, const std::string& suffix) const {
  Positions all(static_cast<Eigen::Index>(rows()), 3);
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<double>& values = (*this)[prefix + "xyz"[axis] + suffix];
    for (std::size_t i = 0; i < rows(); ++i) all(static_cast<Eigen::Index>(i), axis) = values[i];
  }
  return all;
}

Errors PeerTable::errors(const std::vector<double>& ours, const std::string& column) const {
  const std::vector<double>& theirs = (*this)[column];
  return relative_errors(minus(ours, theirs), theirs, clamped());
}

bool PeerTable::clamped(std::size_t row) const {
  const std::vector<double>* flags = find("clamped");
  return flags != nullptr && (*flags)[row] != 0.0;
}

std::vector<bool> PeerTable::clamped() const {
  std::vector<bool> flags;
  for (std::size_t row = 0; row < rows(); ++row) flags.push_back(clamped(row));
  return flags;
}

bool PeerTable::has_clamped() const {
  const std::vector<bool> flags = clamped();
  return std::find(flags.begin(), flags.end(), true) != flags.end();
}

const std::vector<double>* PeerTable::find(const std::string& name) const {
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
                       const std::vector<bool>& clamped) {
  Largest scale;
  for (std::size_t i = 0; i < peer.size(); ++i) {
    if (!clamped[i]) scale.add(peer[i]);
  }
  Errors errors;
  for (std::size_t i = 0; i < peer.size(); ++i) {
    const double error = relative_to(difference[i], scale.value);
    errors.by_row.push_back(error);
    if (!clamped[i]) {
      errors.largest = worse(errors.largest, error);
    } else if (!std::isnan(difference[i])) {
      errors.largest_clamped = worse(errors.largest_clamped.value_or(0.0), error);
    }
  }
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

void declare_rows(observe::Observations& all) {
  all.metrics.push_back({"rows", {}, "1", "rows that were compared"});
  all.metrics.push_back(
      {"clamped_rows", {}, "1", "rows left out: the peer does not compute the stated potential there"});
}

void count_rows(const PeerTable& table, observe::Observations& seen) {
  std::size_t clamped = 0;
  for (std::size_t i = 0; i < table.rows(); ++i) clamped += table.clamped(i);
  seen.set("rows", static_cast<double>(table.rows() - clamped));
  seen.set("clamped_rows", static_cast<double>(clamped));
}

}  // namespace veriflex::measures::peer
