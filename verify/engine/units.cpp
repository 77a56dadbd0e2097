#include "engine/units.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "base/mutant.hpp"
#include "engine/read_scene.hpp"
#include "fluid/lattice.hpp"

namespace veriflex::engine {

namespace {

const double sound = 1.0 / std::sqrt(3.0);  // [L T^-1]

// Limits of what is called good, with what is known of each.
constexpr double small_tau = 0.51;  // below, what is not resolved hardly decays
constexpr double large_tau = 2.0;   // above, half-way walls and the time step err visibly
constexpr double good_mach = 0.1;   // errors of Ma^2: 1 %
constexpr double good_grid_reynolds = 10.0;
constexpr double good_resolution = 8.0;
constexpr double good_cauchy = 0.1;

class Collected {
 public:
  explicit Collected(const std::optional<Units>& units) : units_(units) {}

  void add(const std::string& name, const std::string& symbol, double lattice, int mass, int length, int time,
           const std::string& unit) {
    all_.push_back({name, symbol, lattice});
    if (!units_) return;
    all_.back().physical = lattice * units_->factor(mass, length, time);
    all_.back().unit = unit;
  }
  void add(const std::string& name, const std::string& symbol, double number) {
    all_.push_back({name, symbol, number});
  }
  void fault(const std::string& why, const std::string& remedy) {
    all_.back().fault = why;
    all_.back().remedy = remedy;
  }
  std::vector<Quantity> all() const { return all_; }

 private:
  std::optional<Units> units_;
  std::vector<Quantity> all_;
};

void add_flow(const Told& told, double viscosity, Collected& to) {
  if (!told.speed) return;
  const double speed = *told.speed, mach = speed / sound, grid_reynolds = speed / viscosity;
  to.add("speed", "U", speed, 0, 1, -1, "m/s");
  to.add("mach", "Ma", mach);
  if (mach > good_mach) {
    to.fault(fmt::format("compression errs by Ma^2, {:.2g} %", 100.0 * mach * mach),
             fmt::format("a time step {:.2g} times shorter, tau - 1/2 smaller by the same factor",
                         mach / good_mach));
  }
  to.add("grid_reynolds", "U dx/nu", grid_reynolds);
  if (grid_reynolds > good_grid_reynolds) {
    to.fault("gradients are sharper than the lattice resolves",
             fmt::format("a spacing {:.2g} times finer at the same Mach number",
                         grid_reynolds / good_grid_reynolds));
  }
  if (told.length)
    to.add("reynolds", "Re",
           (planted(Mutant::reynolds_of_radius) ? 0.5 : 1.0) * speed * *told.length / viscosity);
}

void add_body(const Told& told, const Told::Body& body, Collected& to) {
  to.add(body.name + ".young_modulus", "E", body.young_modulus, 1, -1, -2, "Pa");
  to.add(body.name + ".density", "rho_s", body.density, 1, -3, 0, "kg/m^3");
  if (!told.relaxation_time) return;
  to.add(body.name + ".density_ratio", "rho_s/rho_f", body.density);
  if (body.is_coupled && body.density < 1.0) {
    to.fault("the explicit coupling of a light body may be unstable",
             "look at coupling_growth of a run; a larger node_mass or more sub-steps help");
  }
  if (!told.speed) return;
  const double cauchy = *told.speed * *told.speed / body.young_modulus;
  to.add(body.name + ".cauchy", "rho U^2/E", cauchy);
  if (cauchy > good_cauchy) {
    to.fault("the flow strains the body by as much",
             fmt::format("a modulus {:.2g} times larger, if strains are to be small", cauchy / good_cauchy));
  }
}

}  // namespace

double Units::factor(int mass, int length, int time) const {
  const double unit_mass = density * spacing * spacing * spacing;
  return std::pow(unit_mass, mass) * std::pow(spacing, length) *
         std::pow(time_step, planted(Mutant::unit_of_time_inverted) ? -time : time);
}

std::optional<CaseUnits> read_units(const io::Table& top) {
  if (!top.has("units")) return std::nullopt;
  const io::Table t = top.table("units");
  const auto positive = [&](const std::string& key, double value) {
    return need_positive(t, key, value, "It is in SI");
  };
  CaseUnits units{{.spacing = positive("spacing", t.number("spacing")),
                   .time_step = positive("time_step", t.number("time_step")),
                   .density = positive("density", t.number("density"))}};
  if (t.has("speed")) units.speed = positive("speed", t.number("speed"));
  if (t.has("length")) units.length = positive("length", t.number("length"));
  return units;
}

std::vector<Quantity> quantities(const Told& told, const std::optional<Units>& units) {
  Collected to(units);
  if (told.relaxation_time) {
    const double tau = *told.relaxation_time, viscosity = fluid::viscosity(tau);
    to.add("relaxation_time", "tau", tau);
    if (tau < small_tau)
      to.fault("what the lattice does not resolve hardly decays",
               "a finer spacing, or a longer time step, with which the speed U on the lattice is larger");
    if (tau > large_tau)
      to.fault("walls and time steps err with the square of tau - 1/2", "a shorter time step");
    to.add("viscosity", "nu", viscosity, 0, 2, -1, "m^2/s");
    if (told.length) {
      to.add("length", "L", *told.length, 0, 1, 0, "m");
      if (*told.length < good_resolution)
        to.fault("so few spacings hardly resolve it", fmt::format("{} spacings or more", good_resolution));
    }
    add_flow(told, viscosity, to);
  }
  for (const Told::Body& body : told.bodies) add_body(told, body, to);
  return to.all();
}

Lattice lattice_of(const Physical& flow) {
  for (const auto& [name, value] : {std::pair{"viscosity", flow.viscosity},
                                    {"speed", flow.speed},
                                    {"length", flow.length},
                                    {"density", flow.density},
                                    {"spacings", flow.spacings},
                                    {"mach", flow.mach},
                                    {"young", flow.young_modulus.value_or(1.0)},
                                    {"solid-density", flow.solid_density.value_or(1.0)}}) {
    if (!(value > 0.0) || std::isinf(value))
      throw BadParameter(name, fmt::format("it is {}", value), "it must be positive and finite",
                         "Give it in SI");
  }
  if (flow.relaxation_time && !(*flow.relaxation_time > 0.5)) {
    throw BadParameter("tau", fmt::format("it is {}", *flow.relaxation_time),
                       "the viscosity (tau - 1/2)/3 must be positive", "Use more than 0.5");
  }
  const double spacing = flow.length / flow.spacings;
  const double time_step = flow.relaxation_time
                               ? fluid::viscosity(*flow.relaxation_time) * spacing * spacing / flow.viscosity
                               : flow.mach * sound * spacing / flow.speed;
  const Units units{.spacing = spacing, .time_step = time_step, .density = flow.density};
  Lattice found{units, {}};
  found.told.relaxation_time = flow.relaxation_time
                                   ? *flow.relaxation_time
                                   : 0.5 + 3.0 * flow.viscosity * time_step / (spacing * spacing);
  found.told.speed = flow.speed * time_step / spacing;
  found.told.length = flow.spacings;
  if (flow.young_modulus || flow.solid_density) {
    const double young = flow.young_modulus.value_or(0.0) / units.factor(1, -1, -2);
    found.told.bodies.push_back(
        {"body", young, flow.solid_density.value_or(flow.density) / flow.density, true});
  }
  return found;
}

}  // namespace veriflex::engine
