#include "measures/external/exact_law.hpp"

#include <cmath>
#include <limits>

#include "analytic/channel.hpp"
#include "analytic/decaying_flow.hpp"
#include "analytic/exact_solid.hpp"
#include "bond/laws.hpp"
#include "engine/read_scene.hpp"

namespace veriflex::measures::external {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// With its ends, where a law holds at them.
Interval closed(double lo, double hi) {
  return {std::nextafter(lo, -infinity), std::nextafter(hi, infinity)};
}

double positive(const io::Table& exact, const std::string& parameter) {
  return engine::need_positive(exact, parameter, exact.number(parameter));
}

// u(y) between plates at 0 and `height`, density 1.
ExactLaw plane_poiseuille(const io::Table& exact) {
  const double height = positive(exact, "height");
  const double force = positive(exact, "force");
  const double viscosity = positive(exact, "viscosity");
  return {"plane-poiseuille", "L", "L T^-1", closed(0.0, height),
          [=](double y) { return force / viscosity * analytic::plane_poiseuille(y, height); }};
}

// Amplitude of a shear wave in time.
ExactLaw shear_wave(const io::Table& exact) {
  const analytic::DecayingFlow wave{.pattern = analytic::Pattern::Shear,
                                    .a = 0,
                                    .b = 1,
                                    .wavenumber = positive(exact, "wavenumber"),
                                    .amplitude = positive(exact, "amplitude"),
                                    .viscosity = positive(exact, "viscosity")};
  return {"shear-wave", "T", "L T^-1", closed(0.0, infinity),
          [=](double time) { return wave.amplitude * std::exp(-wave.decay_rate() * time); }};
}

// Deflection over length of a cantilever's tip against the load P L^2/B.
ExactLaw elastica() {
  return {"elastica", "1", "1", closed(0.0, 200.0),
          [](double load) { return analytic::elastica_tip(load).deflection; }};
}

// dU/dr of one bond against its length.
ExactLaw bond_tension(const io::Table& top) {
  const bond::AnyLaw law = engine::read_law(top);
  return {"bond-tension", "L", "M L T^-2", bond::domain(law),
          [=](double r) { return bond::tension(law, r); }};
}

}  // namespace

ExactLaw read_exact_law(const io::Table& top, const io::Table& exact) {
  const std::string name =
      exact.choice("law", {"plane-poiseuille", "shear-wave", "elastica", "bond-tension"});
  if (name == "plane-poiseuille") return plane_poiseuille(exact);
  if (name == "shear-wave") return shear_wave(exact);
  if (name == "elastica") return elastica();
  return bond_tension(top);
}

}  // namespace veriflex::measures::external
