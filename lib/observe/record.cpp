#include "observe/record.hpp"

#include <algorithm>
#include <stdexcept>

namespace veriflex::observe {

namespace {

template <class Named>
const Named* named(const std::vector<Named>& all, const std::string& name) {
  const auto found = std::find_if(all.begin(), all.end(), [&](const Named& n) { return n.name == name; });
  return found == all.end() ? nullptr : &*found;
}

}  // namespace

const Column* Record::find(const std::string& column) const { return named(columns, column); }

void Record::append(const std::vector<double>& row) {
  if (row.size() != columns.size()) {
    throw std::logic_error("a row of record '" + name + "' has " + std::to_string(row.size()) +
                           " values for " + std::to_string(columns.size()) + " columns");
  }
  for (std::size_t i = 0; i < columns.size(); ++i) columns[i].values.push_back(row[i]);
}

const Record* Observations::record(const std::string& name) const { return named(records, name); }

const Metric* Observations::metric(const std::string& name) const { return named(metrics, name); }

void Observations::set(const std::string& name, double value) {
  const Metric* known = named(declared, name);
  if (known == nullptr) throw std::logic_error("metric '" + name + "' is not declared");
  if (metric(name) != nullptr) throw std::logic_error("metric '" + name + "' is set twice");
  metrics.push_back({name, value, known->dimension, known->meaning});
}

Record& Observations::open(const std::string& name) {
  const auto found =
      std::find_if(records.begin(), records.end(), [&](const Record& r) { return r.name == name; });
  if (found == records.end()) throw std::logic_error("record '" + name + "' is not declared");
  return *found;
}

}  // namespace veriflex::observe
