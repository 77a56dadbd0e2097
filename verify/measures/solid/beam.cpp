#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "base/root.hpp"
#include "bond/derive.hpp"
#include "engine/read_scene.hpp"
#include "measures/drivers.hpp"
#include "measures/solid/beam_section.hpp"
#include "solid/modes.hpp"

namespace veriflex::measures {

namespace {

using observe::Observations;
using observe::Record;

struct BeamStudy {
  solid::Material material;
  scene::SolidSpec section;  // its length is set by `length`
  std::int64_t length;       // from the clamped section to the loaded one, in spacings
  int clamped;               // sections that are clamped at the root
  int frequencies;           // how many bending frequencies are compared; 0 for none

  bool is_chain() const { return section_of(material, section, spacing_of(section)).nodes == 1.0; }
  bool is_rod() const { return std::holds_alternative<solid::Rod>(section.shape); }
};

Observations beam_observations(const BeamStudy& study) {
  Observations all;
  all.metrics = {
      {"bending_springs", {}, "M L^3 T^-2", "bending stiffness of the springs"},
      {"bending_straight", {}, "M L^3 T^-2", "bending stiffness of the straight angles"},
      {"bending_right", {}, "M L^3 T^-2", "bending stiffness of the right angles"},
      {"bending", {}, "M L^3 T^-2", "bending stiffness B of the section"},
      {"bending_deviation", {}, "1", "departure of B from the sum over springs and angles of a section"},
      {"deflection", {}, "M^-1 T^2", "of the tip, mean over the last section, per load"},
      {"timoshenko", {}, "M^-1 T^2", "L^3/3B + L/GA with the lattice's own B and GA"},
      {"timoshenko_error", {}, "1", "departure of the deflection from Timoshenko's beam"}};
  if (study.is_rod()) {
    all.metrics.push_back(
        {"bending_over_continuum", {}, "1", "B over E pi R^4/4, what a user would expect of a round rod"});
  }
  if (study.is_chain())
    all.metrics.push_back({"hinge_error", {}, "1", "departure of the deflection from the sum over hinges"});
  for (int k = 1; k <= study.frequencies; ++k) {
    all.metrics.push_back({fmt::format("frequency_ratio_{}", k),
                           {},
                           "1",
                           fmt::format("bending frequency {} over that of an Euler-Bernoulli beam", k)});
  }
  if (study.frequencies > 0) {
    all.records = {{"frequencies",
                    "Lowest bending frequencies of the beam, clamped at one end",
                    {{"mode", "", "1", "number of the mode", {}},
                     {"omega", "", "T^-1", "angular frequency of the lattice", {}},
                     {"omega_beam", "", "T^-1", "Euler-Bernoulli beam with the lattice's own B", {}},
                     {"ratio", "", "1", "omega over omega_beam", {}}}}};
  }
  return all;
}

solid::Network beam_of(const BeamStudy& study, std::int64_t sections) {
  return scene::build(with_sections(study.section, sections));
}

solid::Network beam_of(const BeamStudy& study) { return beam_of(study, study.length + study.clamped); }

// Twice the energy per curvature^2 that the network has in pure bending about y, of its springs, straight and
// right angles together or of some of them.
double bending_energy(const BeamStudy& study, const solid::Network& network) {
  Positions u = Positions::Zero(network.node_count(), 3);
  const double mean = network.rest.col(0).mean();
  u.col(2) = -(network.rest.col(0).array() - mean) * network.rest.col(2).array();
  u.col(0) = 0.5 * network.rest.col(2).array().square();
  const solid::FixedDofs free = solid::FixedDofs::Constant(network.node_count(), 3, false);
  const auto h = solid::free_hessian(study.material, network, Positions::Zero(network.node_count(), 3), free);
  const Eigen::VectorXd flat = u.reshaped();
  return flat.dot(h * flat);
}

// Bending stiffness of one section more: what a body of 8 sections has beyond one of 7, term by term.
BeamSection measured_section(const BeamStudy& study) {
  const auto per_section = [&](const BeamStudy& of, auto keep) {
    double difference = 0.0;
    for (const std::int64_t sections : {7, 8}) {
      solid::Network network = beam_of(of, sections);
      std::erase_if(network.angles, [&](const solid::Angle& angle) { return !keep(angle); });
      difference = bending_energy(of, network) - difference;
    }
    return difference / spacing_of(of.section);
  };
  const auto none = [](const solid::Angle&) { return false; };
  const auto straight = [](const solid::Angle& angle) { return angle.straight; };
  const auto right = [](const solid::Angle& angle) { return !angle.straight; };
  const double springs = per_section(study, none);
  BeamSection measured = section_of(study.material, study.section, spacing_of(study.section));
  measured.spring_bending = springs;
  measured.straight_bending = per_section(study, straight) - springs;
  measured.right_bending = per_section(study, right) - springs;
  return measured;
}

// Tip deflection per load of the clamped beam, loaded evenly over its last section: linear response.
double tip_deflection(const BeamStudy& study, const BeamSection& section) {
  const solid::Network network = beam_of(study);
  const auto per_section = static_cast<Eigen::Index>(section.nodes);
  solid::FixedDofs held = solid::FixedDofs::Constant(network.node_count(), 3, false);
  held.topRows(per_section * study.clamped).setConstant(true);
  Positions load = Positions::Zero(network.node_count(), 3);
  load.col(0).tail(per_section).setConstant(1.0 / section.nodes);
  return solid::linear_response(study.material, network, held, load).col(0).tail(per_section).mean();
}

// Tip deflection per load of a row of hinges: one of compliance 1/k_a per node along the axis.
double hinge_sum(const BeamStudy& study) {
  const double r0 = spacing_of(study.section);
  const auto n = static_cast<double>(study.length);
  return r0 * r0 * n * (n + 1.0) * (2.0 * n + 1.0) / 6.0 / study.material.angle_stiffness;
}

// The k-th root of cos x cosh x = -1: clamped-free beam.
double beam_root(int k) {
  const double guess = (k - 0.5) * std::numbers::pi;
  return bracketed_root([](double x) { return std::cos(x) + 1.0 / std::cosh(x); }, guess - 0.5, guess + 0.5);
}

void compare_frequencies(const BeamStudy& study, const BeamSection& section, Observations& seen) {
  const solid::Network network = beam_of(study);
  solid::FixedDofs held = solid::FixedDofs::Constant(network.node_count(), 3, false);
  held.topRows(static_cast<Eigen::Index>(section.nodes) * study.clamped).setConstant(true);
  // Bending in x only: the same frequencies appear once.
  held.col(1).setConstant(true);
  const Eigen::VectorXd omega = solid::lowest_frequencies(
      study.material, network, Positions::Zero(network.node_count(), 3), held, 1.0, study.frequencies);
  Record& record = seen.open("frequencies");
  const double span = static_cast<double>(study.length) * network.spacing;
  for (int k = 1; k <= study.frequencies; ++k) {
    const double root = beam_root(k) / span;
    const double beam = root * root * std::sqrt(section.bending() * network.spacing / section.nodes);
    record.append({static_cast<double>(k), omega[k - 1], beam, omega[k - 1] / beam});
    seen.set(fmt::format("frequency_ratio_{}", k), omega[k - 1] / beam);
  }
}

void run_beam(const BeamStudy& study, Observations& seen, engine::Cost& cost) {
  const BeamSection section = section_of(study.material, study.section, spacing_of(study.section));
  const BeamSection measured = measured_section(study);
  seen.set("bending_springs", measured.spring_bending);
  seen.set("bending_straight", measured.straight_bending);
  seen.set("bending_right", measured.right_bending);
  seen.set("bending", measured.bending());
  seen.set("bending_deviation", std::abs(measured.bending() / section.bending() - 1.0));
  if (study.is_rod()) {
    const double young = bond::derive(study.material.law).young_modulus;
    const double continuum = young * std::numbers::pi * std::pow(section.radius, 4) / 4.0;
    seen.set("bending_over_continuum", measured.bending() / continuum);
  }
  cost.finish("section");
  const double span = static_cast<double>(study.length) * spacing_of(study.section);
  const double beam =
      span * span * span / (3.0 * section.bending()) + (study.is_chain() ? 0.0 : span / section.shear);
  const double tip = tip_deflection(study, section);
  seen.set("deflection", tip);
  seen.set("timoshenko", beam);
  seen.set("timoshenko_error", std::abs(tip / beam - 1.0));
  if (study.is_chain()) seen.set("hinge_error", std::abs(tip / hinge_sum(study) - 1.0));
  cost.finish("cantilever");
  if (study.frequencies == 0) return;
  compare_frequencies(study, section, seen);
  cost.finish("frequencies");
}

}  // namespace

engine::Study read_beam(const io::Table& top) {
  const solid::Material material = read_material_with_angles(top);
  const double rest_length = engine::read_derivation(top, material.law).rest_length;
  const io::Table t = top.table("beam");
  const BeamStudy study{
      .material = material,
      .section = engine::read_solid_at_rest(top, material.law, rest_length),
      .length = t.integer("length", 2, 100000),
      .clamped = static_cast<int>(t.integer("clamped", 1, 100)),
      .frequencies = t.has("frequencies") ? static_cast<int>(t.integer("frequencies", 1, 20)) : 0};
  if (study.frequencies > study.length) {
    t.fail("frequencies", fmt::format("'frequencies' is {}", study.frequencies),
           fmt::format("a beam of {} spacings has no more ways of bending than sections that move",
                       study.length),
           "Ask for fewer, or of a longer beam");
  }
  return {.plan = engine::read_plan(
              top, {.law = material.law,
                    .solid = with_sections(study.section, study.length + study.clamped),
                    .method = "linear response by sparse Cholesky; first sections clamped, last one loaded",
                    .by = {parts::Kind::Statics}}),
          .declares = beam_observations(study),
          .run = [study](Observations& seen, Progress&, engine::Cost& cost) { run_beam(study, seen, cost); }};
}

}  // namespace veriflex::measures
