#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "base/reduce.hpp"
#include "base/root.hpp"
#include "bond/derive.hpp"
#include "engine/read_scene.hpp"
#include "measures/drivers.hpp"
#include "measures/solid/beam_section.hpp"
#include "solid/modes.hpp"

namespace veriflex::measures {

namespace {

using observe::Metric;
using observe::Observations;
using observe::Record;

struct BeamStudy {
  solid::Material material;
  scene::SolidSpec section;           // its length is set by `lengths`
  std::vector<std::int64_t> lengths;  // from the clamped section to the loaded one, in spacings
  int clamped;                        // sections that are clamped at the root
  int frequencies;  // how many bending frequencies are compared, of the longest beam; 0 for none
};

solid::Network beam_of(const BeamStudy& study, std::int64_t sections) {
  return scene::build(with_sections(study.section, sections));
}

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

// Tip deflection per load of the clamped beam of `length` spacings, loaded evenly over its last section:
// linear response.
double tip_deflection(const BeamStudy& study, const BeamSection& section, std::int64_t length) {
  const solid::Network network = beam_of(study, length + study.clamped);
  const auto per_section = static_cast<Eigen::Index>(section.nodes);
  solid::FixedDofs held = solid::FixedDofs::Constant(network.node_count(), 3, false);
  held.topRows(per_section * study.clamped).setConstant(true);
  Positions load = Positions::Zero(network.node_count(), 3);
  load.col(0).tail(per_section).setConstant(1.0 / section.nodes);
  return solid::linear_response(study.material, network, held, load).col(0).tail(per_section).mean();
}

// Tip deflection per load of a row of hinges: one of compliance 1/k_a per node along the axis.
double hinge_sum(const BeamStudy& study, std::int64_t length) {
  const double r0 = spacing_of(study.section);
  const auto n = static_cast<double>(length);
  return r0 * r0 * n * (n + 1.0) * (2.0 * n + 1.0) / 6.0 / study.material.angle_stiffness;
}

// The k-th root of cos x cosh x = -1: clamped-free beam.
double beam_root(int k) {
  const double guess = (k - 0.5) * std::numbers::pi;
  return bracketed_root([](double x) { return std::cos(x) + 1.0 / std::cosh(x); }, guess - 0.5, guess + 0.5);
}

void compare_frequencies(const BeamStudy& study, const BeamSection& section, Observations& seen) {
  const std::int64_t length = study.lengths.back();
  const solid::Network network = beam_of(study, length + study.clamped);
  solid::FixedDofs held = solid::FixedDofs::Constant(network.node_count(), 3, false);
  held.topRows(static_cast<Eigen::Index>(section.nodes) * study.clamped).setConstant(true);
  // Bending in x only: the same frequencies appear once.
  held.col(1).setConstant(true);
  const Eigen::VectorXd omega = solid::lowest_frequencies(
      study.material, network, Positions::Zero(network.node_count(), 3), held, 1.0, study.frequencies);
  Record record{"frequencies",
                "Lowest bending frequencies of the longest beam, clamped at one end",
                {{"mode", "", "1", "number of the mode", {}},
                 {"omega", "", "T^-1", "angular frequency of the lattice", {}},
                 {"omega_beam", "", "T^-1", "Euler-Bernoulli beam with the lattice's own B", {}},
                 {"ratio", "", "1", "omega over omega_beam", {}}}};
  const double span = static_cast<double>(length) * network.spacing;
  for (int k = 1; k <= study.frequencies; ++k) {
    const double root = beam_root(k) / span;
    const double beam = root * root * std::sqrt(section.bending() * network.spacing / section.nodes);
    record.append({static_cast<double>(k), omega[k - 1], beam, omega[k - 1] / beam});
    seen.metrics.push_back({fmt::format("frequency_ratio_{}", k), omega[k - 1] / beam, "1",
                            fmt::format("bending frequency {} over that of an Euler-Bernoulli beam", k)});
  }
  seen.records.push_back(record);
}

void run(const BeamStudy& study, Observations& seen, Progress& progress, engine::Cost& cost) {
  const BeamSection section = section_of(study.material, study.section, spacing_of(study.section));
  const BeamSection measured = measured_section(study);
  const bool chain = section.nodes == 1.0;
  seen.metrics = {
      {"bending_springs", measured.spring_bending, "M L^3 T^-2", "bending stiffness of the springs"},
      {"bending_straight", measured.straight_bending, "M L^3 T^-2",
       "bending stiffness of the straight angles"},
      {"bending_right", measured.right_bending, "M L^3 T^-2", "bending stiffness of the right angles"},
      {"bending", measured.bending(), "M L^3 T^-2", "bending stiffness B of the section"},
      {"bending_deviation", std::abs(measured.bending() / section.bending() - 1.0), "1",
       "departure of B from the sum over springs and angles of a section"}};
  if (section.radius > 0.0) {
    const double young = bond::derive(study.material.law).young_modulus;
    const double continuum = young * std::numbers::pi * std::pow(section.radius, 4) / 4.0;
    seen.metrics.push_back({"bending_over_continuum", measured.bending() / continuum, "1",
                            "B over E pi R^4/4, what a user would expect of a round rod"});
  }
  cost.finish("section");
  seen.records.push_back(
      {"cantilever",
       "Tip deflection of the clamped beam per load",
       {{"length", "L", "L", "from the clamped section to the loaded one", {}},
        {"deflection", "", "M^-1 T^2", "mean over the last section, per load", {}},
        {"timoshenko", "", "M^-1 T^2", "L^3/3B + L/GA with the lattice's own B and GA", {}},
        {"error", "", "1", "departure from Timoshenko's beam", {}},
        {"spacings", "n", "1", "the length in spacings", {}}}});
  Record& record = seen.records.back();
  for (std::size_t i = 0; i < study.lengths.size(); ++i) {
    progress.show("cantilevers", i, study.lengths.size());
    const double span = static_cast<double>(study.lengths[i]) * spacing_of(study.section);
    const double beam = span * span * span / (3.0 * section.bending()) + (chain ? 0.0 : span / section.shear);
    const double tip = tip_deflection(study, section, study.lengths[i]);
    record.append({span, tip, beam, std::abs(tip / beam - 1.0), static_cast<double>(study.lengths[i])});
  }
  const std::vector<double>& error = record.find("error")->values;
  const std::vector<double>& span = record.find("length")->values;
  seen.metrics.push_back({"timoshenko_error", error.back(), "1", "of the longest beam"});
  if (error.size() > 1) {
    const std::size_t n = error.size();
    seen.metrics.push_back({"timoshenko_order",
                            std::log(error[n - 2] / error[n - 1]) / std::log(span[n - 1] / span[n - 2]), "1",
                            "order in 1/L at which the departure falls, last two lengths"});
  }
  if (chain) {
    double worst = 0.0;
    for (std::size_t i = 0; i < error.size(); ++i) {
      const double tip = record.find("deflection")->values[i];
      worst = worse(worst, std::abs(tip / hinge_sum(study, study.lengths[i]) - 1.0));
    }
    seen.metrics.push_back(
        {"hinge_error", worst, "1", "departure of a chain's deflection from the sum over its hinges"});
  }
  cost.finish("cantilevers");
  if (study.frequencies > 0) {
    compare_frequencies(study, section, seen);
    cost.finish("frequencies");
  }
}

}  // namespace

engine::Study read_beam(const io::Table& top) {
  const bond::AnyLaw law = engine::read_law(top);
  const double rest_length = engine::read_derivation(top, law).rest_length;
  const io::Table t = top.table("beam");
  BeamStudy study{
      .material = {law, engine::read_angle_stiffness(top)},
      .section = engine::read_solid_at_rest(top, law, rest_length),
      .lengths = t.integers("lengths"),
      .clamped = static_cast<int>(t.integer("clamped", 1, 100)),
      .frequencies = t.has("frequencies") ? static_cast<int>(t.integer("frequencies", 1, 20)) : 0};
  if (!(study.material.angle_stiffness > 0.0)) {
    top.table("bond").fail("law", "a beam of bonds alone", "without angles it has no shear stiffness",
                           "Add [angle] stiffness");
  }
  if (study.lengths.empty() || study.lengths.front() < 2 || study.lengths.back() > 100000) {
    t.fail("lengths", "no lengths, or one below 2 or above 100000", "a beam needs some sections",
           "Give for example [25, 50]");
  }
  for (std::size_t i = 1; i < study.lengths.size(); ++i) {
    if (study.lengths[i] <= study.lengths[i - 1]) {
      t.fail("lengths", "lengths do not rise", "the order is taken between neighbours", "Sort them");
    }
  }
  if (study.frequencies > study.lengths.back()) {
    t.fail("frequencies", fmt::format("'frequencies' is {}", study.frequencies),
           fmt::format("a beam of {} spacings has no more ways of bending than sections that move",
                       study.lengths.back()),
           "Ask for fewer, or of a longer beam");
  }
  std::vector<std::string> measures{"bending_springs",  "bending_straight",  "bending_right",
                                    "bending",          "bending_deviation", "bending_over_continuum",
                                    "timoshenko_error", "timoshenko_order",  "hinge_error"};
  measures.insert(measures.end(), {"cantilever.spacings", "cantilever.deflection", "cantilever.error"});
  if (study.frequencies > 0) {
    measures.insert(measures.end(),
                    {"frequencies.mode", "frequencies.omega", "frequencies.omega_beam", "frequencies.ratio"});
  }
  for (int k = 1; k <= study.frequencies; ++k) measures.push_back(fmt::format("frequency_ratio_{}", k));
  const scene::SolidSpec longest = with_sections(study.section, study.lengths.back() + study.clamped);
  return {.plan = engine::read_plan(
              top, {.law = law,
                    .solid = longest,
                    .method = "linear response by sparse Cholesky; first sections clamped, last one loaded",
                    .by = {parts::Kind::Statics}}),
          .measures = measures,
          .run = [study](Observations& seen, Progress& progress, engine::Cost& cost) {
            run(study, seen, progress, cost);
          }};
}

}  // namespace veriflex::measures
