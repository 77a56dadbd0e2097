#include "units_command.hpp"

#include <fmt/format.h>

#include <memory>

#include "base/error.hpp"
#include "base/say.hpp"
#include "engine/symbols.hpp"
#include "engine/units.hpp"
#include "measures/scene/scene.hpp"
#include "run_cases.hpp"

namespace veriflex {

namespace {

using Json = nlohmann::ordered_json;
using engine::Quantity;

struct UnitsOptions : Options {
  engine::Physical flow{.viscosity = 0.0, .speed = 0.0, .length = 0.0, .density = 1000.0, .spacings = 0.0};
};

Json json_of(const std::vector<Quantity>& all) {
  Json list = Json::array();
  for (const Quantity& q : all) {
    list.push_back({{"name", q.name},
                    {"symbol", q.symbol},
                    {"lattice", q.lattice},
                    {"physical", q.physical ? Json(*q.physical) : Json(nullptr)},
                    {"unit", q.unit},
                    {"good", q.fault.empty()},
                    {"fault", q.fault},
                    {"remedy", q.remedy}});
  }
  return list;
}

void print(const std::vector<Quantity>& all) {
  std::size_t width = 8;
  for (const Quantity& q : all) width = std::max(width, q.name.size());
  say("  {:<{}}  {:<12} {:>14}  {:>14}\n", "", width, "", "lattice", "SI");
  for (const Quantity& q : all) {
    say("  {:<{}}  {:<12} {:>14.8g}  {:>14} {}\n", q.name, width, q.symbol, q.lattice,
        q.physical ? fmt::format("{:.8g}", *q.physical) : "", q.unit);
  }
  bool good = true;
  for (const Quantity& q : all) {
    if (q.fault.empty()) continue;
    good = false;
    say("  {} = {:.6g}: {}. Take {}\n", q.name, q.lattice, q.fault, q.remedy);
  }
  if (good) say("  all within their good range\n");
}

void units_of_case(const UnitsOptions& o) {
  const std::filesystem::path path = engine::case_named(o.cases.front(), o.case_folder);
  const engine::Case c = read_without_baseline(path, o);  // throws what is wrong with it
  if (c.driver != "scene") {
    throw InputError({path.string()}, fmt::format("driver '{}' does not tell its numbers", c.driver),
                     "scenes do", "Give a case of driver scene, or a flow with --viscosity and --spacings");
  }
  const std::vector<Quantity> all =
      measures::quantities_of(engine::parse_case(c.text, path.string(), o.overrides));
  if (o.json) {
    print_json(Json{{"id", c.id}, {"quantities", json_of(all)}});
    return;
  }
  say("{}: {}\n", c.id, c.title);
  print(all);
}

void units_of_flow(const UnitsOptions& o) {
  try {
    const engine::Lattice found = engine::lattice_of(o.flow);
    const std::vector<Quantity> all = engine::quantities(found.told, found.units);
    if (o.json) {
      print_json(Json{{"units",
                       {{"spacing", found.units.spacing},
                        {"time_step", found.units.time_step},
                        {"density", found.units.density}}},
                      {"quantities", json_of(all)}});
      return;
    }
    print(all);
    say("for a case:\n[units]\nspacing = {}\ntime_step = {}\ndensity = {}\n[fluid]\nrelaxation_time = {}\n",
        io::toml_text(found.units.spacing), io::toml_text(found.units.time_step),
        io::toml_text(found.units.density), io::toml_text(*found.told.relaxation_time));
    if (o.flow.young_modulus)
      say("bonds of such a body: veriflex calibrate --young {} --spacing 1 --poisson ...\n",
          found.told.bodies.front().young_modulus);
  } catch (const BadParameter& bad) {
    throw InputError({}, fmt::format("--{}: {}", bad.parameter, bad.problem), bad.why, bad.suggestion);
  }
}

}  // namespace

void add_units_command(CLI::App& app) {
  const auto o = std::make_shared<UnitsOptions>();
  CLI::App* units = app.add_subcommand(
      "units", "numbers of a scene in lattice units and in SI, each judged; or lattice values of a flow");
  CLI::Option* of_case = units->add_option("case", o->cases, "path of a case file, or id")->expected(1);
  units->add_option("--set", o->overrides, "replace a value of the case, key=value; may be repeated")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false);
  engine::Physical& flow = o->flow;
  CLI::Option* viscosity =
      units->add_option("--viscosity,--nu", flow.viscosity, "kinematic, of a flow without a case [m^2/s]");
  units->add_option("--speed", flow.speed, "of that flow [m/s]")->needs(viscosity);
  units->add_option("--length", flow.length, "[m]")->needs(viscosity);
  units->add_option("--spacings", flow.spacings, "of the lattice on that length")->needs(viscosity);
  units->add_option("--density", flow.density, "of the fluid [kg/m^3]")
      ->needs(viscosity)
      ->capture_default_str();
  units->add_option("--young", flow.young_modulus, "of a body [Pa]")->needs(viscosity);
  units->add_option("--solid-density", flow.solid_density, "of that body [kg/m^3] (default: the fluid's)")
      ->needs(viscosity);
  CLI::Option* tau =
      units->add_option("--tau", flow.relaxation_time, "relaxation time wanted")->needs(viscosity);
  units->add_option("--mach", flow.mach, "Mach number wanted")
      ->needs(viscosity)
      ->excludes(tau)
      ->capture_default_str();
  viscosity->excludes(of_case);
  units->add_option("--cases", o->case_folder, "folder of case files")->capture_default_str();
  units->add_flag("--json", o->json, "print JSON");
  units->footer(
      "Example: veriflex units my-scene.toml\n"
      "         veriflex units --viscosity 1e-6 --speed 0.01 --length 1e-3 --spacings 20 --young 1e4");
  units->callback([o, viscosity] {
    if (!o->cases.empty()) return units_of_case(*o);
    if (viscosity->count() > 0) return units_of_flow(*o);
    throw InputError({}, "neither a case nor a flow is given", "there is nothing to convert",
                     "Name a case, or give --viscosity, --speed, --length and --spacings");
  });
}

}  // namespace veriflex
