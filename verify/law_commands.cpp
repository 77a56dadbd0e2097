#include "law_commands.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>

#include "bond/derive.hpp"

namespace veriflex {

namespace {

using Json = nlohmann::ordered_json;

struct LawOptions {
  std::string law = "fene-lj";
  std::map<std::string, double> given;
  bool json = false;
};

std::string option_name(std::string parameter) {
  std::replace(parameter.begin(), parameter.end(), '_', '-');
  return "--" + parameter;
}

// A symbol of one letter is a short option: -K.
std::string symbol_option(const std::string& symbol) { return (symbol.size() == 1 ? "-" : "--") + symbol; }

// One option per parameter that any law has, and which laws have it.
void add_law_options(CLI::App& command, LawOptions& options) {
  command.add_option("--law", options.law, fmt::format("bond law: {}", fmt::join(bond::law_names(), ", ")))
      ->capture_default_str();
  std::map<std::string, std::string> meaning;
  std::vector<std::string> order;
  std::map<std::string, std::string> spelt;  // the options of a parameter, by its name
  std::set<std::string> taken;
  for (const bond::LawInfo& law : bond::laws()) {
    for (const bond::ParameterInfo& p : law.parameters) {
      std::string& text = meaning[p.name];
      if (text.empty()) order.push_back(p.name);
      if (text.empty()) spelt[p.name] = option_name(p.name);
      if (!p.symbol.empty() && taken.insert(p.symbol).second) spelt[p.name] += "," + symbol_option(p.symbol);
      text +=
          fmt::format("{}{}: {} [{}]", text.empty() ? "" : "; ", law.name, p.meaning, to_string(p.dimension));
    }
  }
  for (const std::string& name : order) {
    command.add_option_function<double>(
        spelt[name], [&options, name](double value) { options.given[name] = value; }, meaning[name]);
  }
  command.add_flag("--json", options.json,
                   "print one JSON object (17 digits; null for what the law does not have)");
}

[[noreturn]] void fail(const BadParameter& bad) {
  throw InputError({}, fmt::format("{}: {}", option_name(bad.parameter), bad.problem), bad.why,
                   bad.suggestion);
}

// The law the options describe; what they leave open and the law does not default comes from `otherwise`.
bond::AnyLaw law_of(const LawOptions& options, std::optional<double> otherwise) {
  std::vector<std::string> asked;
  bond::AnyLaw law = bond::make_law(options.law, [&](const std::string& name) -> std::optional<double> {
    asked.push_back(name);
    const auto given = options.given.find(name);
    if (given != options.given.end()) return given->second;
    for (const bond::LawInfo& info : bond::laws()) {
      for (const bond::ParameterInfo& p : info.parameters) {
        if (info.name == options.law && p.name == name && p.required) return otherwise;
      }
    }
    return std::nullopt;
  });
  for (const auto& [name, value] : options.given) {
    if (std::find(asked.begin(), asked.end(), name) == asked.end()) {
      throw BadParameter(name, fmt::format("bond law {} has no '{}'", options.law, name),
                         fmt::format("it has: {}", fmt::join(asked, ", ")), "Leave it out");
    }
  }
  return law;
}

Json json_number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }
Json json_number(const std::optional<double>& value) { return value ? json_number(*value) : Json(nullptr); }
Json interval(const Interval& i) { return Json::array({json_number(i.lo), json_number(i.hi)}); }

Json validity_json(const bond::Derivation& d) {
  Json all = Json::array();
  for (const bond::Validity& v : d.validity) {
    all.push_back(
        {{"tolerance", v.tolerance}, {"secant", interval(v.secant)}, {"tangent", interval(v.tangent)}});
  }
  return all;
}

Json parameters_json(const bond::AnyLaw& law) {
  Json all = Json::object();
  for (const bond::NamedValue& p : bond::parameters_of(law)) all[p.name] = json_number(p.value);
  return all;
}

std::optional<double> parameter(const bond::AnyLaw& law, const std::string& name) {
  for (const bond::NamedValue& p : bond::parameters_of(law)) {
    if (p.name == name) return p.value;
  }
  return std::nullopt;
}

Json derivation_json(const bond::AnyLaw& law, const bond::Derivation& d) {
  Json kinks = Json::array();
  for (const bond::Kink& k : d.kinks) {
    kinks.push_back({{"length", k.length},
                     {"strain", k.strain},
                     {"tension_jump", k.tension_jump},
                     {"tangent_below", k.tangent_below},
                     {"tangent_above", k.tangent_above}});
  }
  return {{"law", bond::name_of(law)},
          {"parameters", parameters_json(law)},
          {"rest_length", json_number(d.rest_length)},
          {"stiffness", json_number(d.stiffness)},
          {"force_per_strain", json_number(d.force_per_strain)},
          {"young_modulus", json_number(d.young_modulus)},
          {"stiffness_over_fene_k", json_number(d.stiffness_over_fene_k)},
          {"strain_at_r_max", json_number(d.strain_at_r_max)},
          {"min_tangent_ratio", json_number(d.min_tangent_ratio)},
          {"min_tangent_strain", json_number(d.min_tangent_strain)},
          {"stiffness_by_differences", json_number(d.stiffness_by_differences.value)},
          {"kinks", kinks},
          {"validity", validity_json(d)}};
}

void print_row(const std::string& name, double value, const std::string& dimension,
               const std::string& meaning) {
  fmt::print("  {:<26} {:<24.17g} {:<13} {}\n", name, value, "[" + dimension + "]", meaning);
}

void print_law(const bond::AnyLaw& law) {
  fmt::print("{}\n", bond::name_of(law));
  for (const bond::NamedValue& p : bond::parameters_of(law))
    print_row(p.name, p.value, to_string(p.dimension), "");
}

void print_validity(const bond::Derivation& d) {
  fmt::print("linear within   secant modulus (strain)             tangent modulus (strain)\n");
  for (const bond::Validity& v : d.validity) {
    fmt::print("  {:>4.0f} %        {:+.6f} ... {:+.6f}            {:+.6f} ... {:+.6f}\n",
               100.0 * v.tolerance, v.secant.lo, v.secant.hi, v.tangent.lo, v.tangent.hi);
  }
}

void print_derivation(const bond::AnyLaw& law, const bond::Derivation& d) {
  print_law(law);
  fmt::print("at rest\n");
  print_row("rest_length", d.rest_length, "L", "r_eq");
  print_row("stiffness", d.stiffness, "M T^-2", "U''(r_eq)");
  print_row("force_per_strain", d.force_per_strain, "M L T^-2", "-dF/d(strain) = U''(r_eq) r_eq");
  print_row("young_modulus", d.young_modulus, "M L^-1 T^-2", "E = U''(r_eq)/r_eq");
  if (d.stiffness_over_fene_k) {
    print_row("stiffness_over_fene_k", *d.stiffness_over_fene_k, "1", "U''(r_eq)/K");
  }
  if (std::isfinite(d.stiffness_by_differences.value)) {
    print_row("stiffness by differences", d.stiffness_by_differences.value, "M T^-2",
              fmt::format("GSL, its own error estimate {:.1e}", d.stiffness_by_differences.error));
  } else {
    fmt::print("  no stiffness by differences: the law changes too close to its rest length\n");
  }
  fmt::print("under strain\n");
  if (d.strain_at_r_max)
    print_row("strain_at_r_max", *d.strain_at_r_max, "1", "the longest length is never reached");
  print_row("min_tangent_ratio", d.min_tangent_ratio, "1", "infimum of U''(r)/U''(r_eq) in tension");
  print_row("min_tangent_strain", d.min_tangent_strain, "1", "where");
  for (const bond::Kink& k : d.kinks) {
    fmt::print(
        "  stiffness jumps at r = {:.6g} (strain {:+.6f}): tangent ratio {:.5f} -> {:.5f}, tension by "
        "{:.6g}\n",
        k.length, k.strain, k.tangent_below, k.tangent_above, k.tension_jump);
  }
  print_validity(d);
}

void derive_command(const LawOptions& options) {
  try {
    const bond::AnyLaw law = law_of(options, std::nullopt);
    const bond::Derivation d = bond::derive(law);
    if (options.json) {
      fmt::print("{}\n", derivation_json(law, d).dump(2));
    } else {
      print_derivation(law, d);
    }
  } catch (const BadParameter& bad) {
    fail(bad);
  }
}

struct CalibrateOptions {
  LawOptions law;
  double young = 0.0;
  double spacing = 0.0;
  double poisson = 0.0;
};

void calibrate_command(const CalibrateOptions& options) {
  try {
    // The shape of the law does not depend on its units: what is not given is 1.
    const bond::AnyLaw prototype = law_of(options.law, 1.0);
    const bond::Calibration c = bond::calibrate(prototype, options.young, options.spacing, options.poisson);
    if (options.law.json) {
      const Json json{{"law", bond::name_of(c.law)},
                      {"parameters", parameters_json(c.law)},
                      {"epsilon", json_number(parameter(c.law, "epsilon"))},
                      {"sigma", json_number(parameter(c.law, "sigma"))},
                      {"bond_stiffness", json_number(parameter(c.law, "bond_stiffness"))},
                      {"angle_stiffness", json_number(c.angle_stiffness)},
                      {"rest_length", json_number(c.derivation.rest_length)},
                      {"young_modulus", json_number(c.derivation.young_modulus)},
                      {"validity", validity_json(c.derivation)}};
      fmt::print("{}\n", json.dump(2));
      return;
    }
    print_law(c.law);
    fmt::print("gives\n");
    print_row("rest_length", c.derivation.rest_length, "L", "r_eq");
    print_row("young_modulus", c.derivation.young_modulus, "M L^-1 T^-2", "E = U''(r_eq)/r_eq");
    print_row("angle_stiffness", c.angle_stiffness, "M L^2 T^-2", "k_a = r0^3 E / (8 (1 + nu))");
    print_validity(c.derivation);
  } catch (const BadParameter& bad) {
    fail(bad);
  }
}

}  // namespace

void add_derive_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "derive", "rest length, stiffness, Young's modulus and validity range of a bond law");
  const auto options = std::make_shared<LawOptions>();
  add_law_options(*command, *options);
  command->footer("Example: veriflex derive --law fene-lj --epsilon 1 --sigma 1 --json");
  command->callback([options] { derive_command(*options); });
}

void add_calibrate_command(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("calibrate", "bond and angle parameters for a wanted Young's modulus and spacing");
  const auto options = std::make_shared<CalibrateOptions>();
  command->add_option("--young", options->young, "Young's modulus E [M L^-1 T^-2]")->required();
  command->add_option("--spacing", options->spacing, "lattice spacing r0, the rest length [L]")->required();
  command
      ->add_option("--poisson", options->poisson,
                   "Poisson's ratio in the shear sense: G = E/(2 (1 + nu)) [1]")
      ->required();
  add_law_options(*command, options->law);
  command->footer(
      "The law's own options give its shape in any units, for example --fene-k and --r-max for epsilon = "
      "sigma = 1.\n"
      "Example: veriflex calibrate --young 0.26 --spacing 1 --poisson 0.3 --json");
  command->callback([options] { calibrate_command(*options); });
}

}  // namespace veriflex
