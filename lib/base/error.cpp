#include "base/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace veriflex {

namespace {

std::string sentence(std::string_view problem, std::string_view why, std::string_view suggestion) {
  std::string text{problem};
  if (!why.empty()) text += fmt::format(" ({})", why);
  if (!suggestion.empty()) text += fmt::format(". {}", suggestion);
  return text;
}

// Insertions, deletions, replacements and swaps of neighbours.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    before.swap(last);
    last.swap(row);
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j - 1] + (a[i - 1] != b[j - 1]), last[j] + 1, row[j - 1] + 1});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) row[j] = std::min(row[j], before[j - 2] + 1);
    }
  }
  return row[b.size()];
}

}  // namespace

std::string to_string(const Place& place) {
  if (place.file.empty()) return "command line";
  if (place.line == 0) return place.file;
  return fmt::format("{}:{}:{}", place.file, place.line, place.column);
}

std::string to_string(FailureMode mode) {
  switch (mode) {
    case FailureMode::NotFinite:
      return "not-finite";
    case FailureMode::Density:
      return "density";
    case FailureMode::Mach:
      return "mach";
    case FailureMode::Bond:
      return "bond";
    case FailureMode::Marker:
      return "marker";
    case FailureMode::TimeStep:
      return "time-step";
    case FailureMode::Equilibrium:
      return "equilibrium";
    case FailureMode::NotConverged:
      return "not-converged";
    case FailureMode::Coupling:
      return "coupling";
    case FailureMode::Energy:
      return "energy";
    case FailureMode::Unphysical:
      return "unphysical";
    case FailureMode::Buckled:
      return "buckled";
    case FailureMode::Other:
      break;
  }
  return "other";
}

InputError::InputError(const Place& place, std::string_view problem, std::string_view why,
                       std::string_view suggestion)
    : std::runtime_error(to_string(place) + ": " + sentence(problem, why, suggestion)) {}

BadParameter::BadParameter(std::string_view parameter_, std::string_view problem_, std::string_view why_,
                           std::string_view suggestion_)
    : std::invalid_argument(sentence(problem_, why_, suggestion_)),
      parameter(parameter_),
      problem(problem_),
      why(why_),
      suggestion(suggestion_) {}

OutputError::OutputError(std::string_view path, std::string_view problem, std::string_view remedy)
    : std::runtime_error(fmt::format("{}: {}. {}", path, problem, remedy)) {}

std::string nearest_name(std::string_view word, const std::vector<std::string>& known) {
  std::string nearest;
  std::size_t least = std::max<std::size_t>(1, word.size() / 3) + 1;
  for (const std::string& name : known) {
    const std::size_t distance = edit_distance(word, name);
    if (distance < least) {
      least = distance;
      nearest = name;
    }
  }
  return nearest;
}

}  // namespace veriflex
