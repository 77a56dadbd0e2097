#include "bond/laws.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <utility>

#include "base/error.hpp"

namespace veriflex::bond {

namespace {

template <class Visit, std::size_t... I>
void for_each_law(Visit visit, std::index_sequence<I...>) {
  (visit.template operator()<std::variant_alternative_t<I, AnyLaw>>(), ...);
}

template <class Visit>
void for_each_law(Visit visit) {
  for_each_law(visit, std::make_index_sequence<std::variant_size_v<AnyLaw>>{});
}

// What is given for a parameter, by its name or by its symbol.
template <BondLaw Law>
std::optional<double> given_for(const Parameter<Law>& parameter, const Lookup& given) {
  const std::optional<double> by_name = given(std::string(parameter.name));
  if (parameter.symbol.empty()) return by_name;
  const std::optional<double> by_symbol = given(std::string(parameter.symbol));
  if (by_name && by_symbol) {
    throw BadParameter(parameter.symbol, fmt::format("both '{}' and '{}'", parameter.name, parameter.symbol),
                       "they are two names of one parameter", "Keep one");
  }
  return by_name ? by_name : by_symbol;
}

template <BondLaw Law>
Law make(const Lookup& given) {
  Law law{};
  for (const Parameter<Law>& parameter : Law::parameters()) {
    if (const std::optional<double> value = given_for(parameter, given)) {
      law.*parameter.member = *value;
    } else if (parameter.fallback != nullptr) {
      law.*parameter.member = parameter.fallback(law);
    } else {
      throw MissingParameter(
          parameter.name, fmt::format("bond law {} lacks '{}'", Law::name, parameter.name),
          parameter.symbol.empty() ? std::string(parameter.meaning)
                                   : fmt::format("{}, {}", parameter.symbol, parameter.meaning),
          fmt::format("Give {} a value with dimension {}", parameter.name, to_string(parameter.dimension)));
    }
  }
  law.check();
  return law;
}

}  // namespace

std::string to_string(Dimension d) {
  std::string text;
  const auto append = [&text](std::string_view unit, int power) {
    if (power == 0) return;
    if (!text.empty()) text += ' ';
    text += unit;
    if (power != 1) text += fmt::format("^{}", power);
  };
  append("M", d.energy);
  append("L", 2 * d.energy + d.length);
  append("T", -2 * d.energy);
  return text.empty() ? "1" : text;
}

void require_positive(std::string_view parameter, double value) {
  if (value > 0.0 && std::isfinite(value)) return;
  throw BadParameter(parameter, fmt::format("'{}' is {}", parameter, value), "it must be positive and finite",
                     "Give a positive number");
}

std::vector<LawInfo> laws() {
  std::vector<LawInfo> all;
  for_each_law([&all]<class Law>() {
    LawInfo info{std::string(Law::name), {}};
    for (const Parameter<Law>& p : Law::parameters()) {
      info.parameters.push_back({std::string(p.name), std::string(p.symbol), p.dimension,
                                 std::string(p.meaning), p.fallback == nullptr});
    }
    all.push_back(info);
  });
  return all;
}

std::vector<std::string> law_names() {
  std::vector<std::string> names;
  for_each_law([&names]<class Law>() { names.emplace_back(Law::name); });
  return names;
}

AnyLaw make_law(const std::string& name, const Lookup& given) {
  std::optional<AnyLaw> made;
  for_each_law([&]<class Law>() {
    if (name == Law::name) made = make<Law>(given);
  });
  if (made) return *made;
  const std::string near = nearest_name(name, law_names());
  throw BadParameter("law", fmt::format("unknown bond law '{}'", name),
                     fmt::format("known: {}", fmt::join(law_names(), ", ")),
                     near.empty() ? "Choose one of these" : fmt::format("Did you mean '{}'?", near));
}

std::string name_of(const AnyLaw& law) {
  return std::visit([]<class Law>(const Law&) { return std::string(Law::name); }, law);
}

double energy(const AnyLaw& law, double r) {
  return std::visit([r](const auto& l) { return l.energy(r); }, law);
}
double tension(const AnyLaw& law, double r) {
  return std::visit([r](const auto& l) { return l.tension(r); }, law);
}
double stiffness(const AnyLaw& law, double r) {
  return std::visit([r](const auto& l) { return l.stiffness(r); }, law);
}
Interval domain(const AnyLaw& law) {
  return std::visit([](const auto& l) { return l.domain(); }, law);
}

std::vector<NamedValue> parameters_of(const AnyLaw& law) {
  return std::visit(
      []<class Law>(const Law& l) {
        std::vector<NamedValue> values;
        for (const Parameter<Law>& p : Law::parameters()) {
          values.push_back({std::string(p.name), p.dimension, l.*p.member});
        }
        return values;
      },
      law);
}

AnyLaw rescaled(const AnyLaw& law, double energy, double length) {
  return std::visit(
      [&]<class Law>(Law l) -> AnyLaw {
        for (const Parameter<Law>& p : Law::parameters()) {
          l.*p.member *= std::pow(energy, p.dimension.energy) * std::pow(length, p.dimension.length);
        }
        l.check();
        return l;
      },
      law);
}

}  // namespace veriflex::bond
