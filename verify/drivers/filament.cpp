#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "bond/derive.hpp"
#include "drivers/drivers.hpp"
#include "drivers/filament_run.hpp"
#include "engine/check_coupling.hpp"
#include "engine/read_scene.hpp"
#include "observe/interrupted.hpp"

// The paper's one result: the driven filament with the one bond law against the other. Both run in the same
// fluid, and what is asked is how far their centre lines are apart.

namespace veriflex::drivers {

namespace {

using observe::Observations;
using observe::Record;

struct FilamentStudy {
  Stroke stroke;                        // with the law of [bond]
  bond::AnyLaw other;                   // of [compared_bond]
  std::vector<double> modulus_factors;  // of the compared law's body: what a wrong modulus would look like
  Place node_mass;                      // in the case, where an unstable coupling is reported
};

struct Deviation {
  double z_max, z_rms;          // of |dz| over the axis nodes
  double lab_max, lab_rms;      // of |d|
  double moved_max, moved_rms;  // of |d| after taking out each body's own displacement along y
};

Deviation deviation(const StrokeResult& a, const StrokeResult& b, std::size_t phase, double z0) {
  Positions d = a.lines[phase] - b.lines[phase];
  Deviation result{};
  const auto rms = [&](const auto& values) {
    return std::sqrt(values.squaredNorm() / static_cast<double>(d.rows())) / z0;
  };
  result.z_max = d.col(2).cwiseAbs().maxCoeff() / z0;
  result.z_rms = rms(d.col(2));
  result.lab_max = d.rowwise().norm().maxCoeff() / z0;
  result.lab_rms = rms(d);
  d.col(1).array() -= a.centre[phase][1] - b.centre[phase][1];
  result.moved_max = d.rowwise().norm().maxCoeff() / z0;
  result.moved_rms = rms(d);
  return result;
}

/// The figures' four phases: T/4, T/2, 3T/4, T of the last period, as indices of StrokeResult::lines.
std::array<std::size_t, 4> figure_phases(const StrokeResult& seen) {
  const std::size_t last = seen.lines.size() - phases_per_period;
  return {last + 1, last + 3, last + 5, last + 7};
}

Deviation worst(const StrokeResult& a, const StrokeResult& b, double z0) {
  Deviation most{};
  for (const std::size_t phase : figure_phases(a)) {
    const Deviation d = deviation(a, b, phase, z0);
    most.z_max = std::max(most.z_max, d.z_max);
    most.z_rms = std::max(most.z_rms, d.z_rms);
    most.lab_max = std::max(most.lab_max, d.lab_max);
    most.lab_rms = std::max(most.lab_rms, d.lab_rms);
    most.moved_max = std::max(most.moved_max, d.moved_max);
    most.moved_rms = std::max(most.moved_rms, d.moved_rms);
  }
  return most;
}

/// Largest change of the centre line from one period to the next at the figures' phases, over z0, swimming
/// taken out.
double change_over_last_period(const StrokeResult& seen, double z0) {
  if (seen.lines.size() < 2 * phases_per_period) return 1.0;
  double most = 0.0;
  for (const std::size_t phase : figure_phases(seen)) {
    Positions d = seen.lines[phase] - seen.lines[phase - phases_per_period];
    d.col(1).array() -= seen.centre[phase][1] - seen.centre[phase - phases_per_period][1];
    most = std::max(most, d.rowwise().norm().maxCoeff() / z0);
  }
  return most;
}

double swum(const StrokeResult& seen) {
  const std::size_t last = seen.centre.size() - 1;
  const double from = seen.centre.size() > phases_per_period ? seen.centre[last - phases_per_period][1] : 0.0;
  return seen.centre[last][1] - from;
}

/// Scaled energies scale the modulus and every stiffness of a law by the same factor and leave its rest
/// length.
bond::AnyLaw stiffer(const bond::AnyLaw& law, double factor) { return bond::rescaled(law, factor, 1.0); }

Record centre_lines(const StrokeResult& a, const StrokeResult& b) {
  Record record{
      "centre_lines",
      "Centre lines in the last period",
      {{"point", "", "1", "number of the row", {}},
       {"phase", "t/T", "1", "phase of the last period", {}},
       {"section", "", "1", "number of the section, 0 at the free end", {}},
       {"y", "y", "L", "along the filament at rest, law of [bond]", {}},
       {"z", "z", "L", "across it, along the drive", {}},
       {"y_swimming", "", "L", "y less the body's own displacement", {}},
       {"y_compared", "", "L", "y, law of [compared_bond]", {}},
       {"z_compared", "", "L", "z, law of [compared_bond]", {}},
       {"y_swimming_compared", "", "L", "y less the body's own displacement, law of [compared_bond]", {}}}};
  const std::size_t first = a.lines.size() - phases_per_period;
  for (std::size_t k = 0; k < phases_per_period; ++k) {
    const CentreLine& line = a.lines[first + k];
    const CentreLine& other = b.lines[first + k];
    for (Eigen::Index s = 0; s < line.rows(); ++s) {
      record.append({static_cast<double>(k * static_cast<std::size_t>(line.rows())) + static_cast<double>(s),
                     static_cast<double>(k + 1) / phases_per_period, static_cast<double>(s), line(s, 1),
                     line(s, 2), line(s, 1) - a.centre[first + k][1], other(s, 1), other(s, 2),
                     other(s, 1) - b.centre[first + k][1]});
    }
  }
  return record;
}

Record history_of(const StrokeResult& seen, const std::string& name, const std::string& law) {
  Record record{name,
                "The stroke in time, " + law,
                {{"time", "t/T", "1", "in periods", {}},
                 {"drive", "z", "L", "displacement of the driven node", {}},
                 {"force", "F", "M L T^-2", "that the drive exerts along z", {}},
                 {"centre_y", "Y", "L", "displacement of the centre of mass along the filament", {}},
                 {"slip", "", "L T^-1", "u_f - u_s, root mean square over the coupled nodes", {}},
                 {"least_strain", "", "1", "smallest bond strain", {}},
                 {"greatest_strain", "", "1", "largest bond strain", {}}}};
  for (const Moment& m : seen.history) {
    if (!std::isfinite(m.force) || !std::isfinite(m.slip)) break;  // of a stroke that broke off
    record.append({m.time, m.drive, m.force, m.centre_y, m.slip, m.least_strain, m.greatest_strain});
  }
  return record;
}

observe::Metric metric_of(double growth) {
  return {
      "coupling_growth", growth, "1",
      "largest factor a step of the linearised exchange, without the fluid's own motion; up to 1 is stable"};
}

Record histogram_of(const StrokeResult& a, const StrokeResult& b) {
  Record record{"strain_histogram",
                "Bond lengths in the last period",
                {{"length", "r/r0", "1", "middle of the bin, over the spacing", {}},
                 {"share", "", "1", "of bonds and times, law of [bond]", {}},
                 {"share_compared", "", "1", "law of [compared_bond]", {}}}};
  const double bin = (strain_bin_hi - strain_bin_lo) / strain_bins;
  for (int i = 0; i < strain_bins; ++i) {
    const auto k = static_cast<std::size_t>(i);
    record.append({1.0 + strain_bin_lo + (i + 0.5) * bin, a.histogram[k], b.histogram[k]});
  }
  return record;
}

Record deviations_of(const StrokeResult& a, const StrokeResult& b, double z0) {
  Record record{"law_deviation",
                "How far the two laws' centre lines are apart",
                {{"phase", "t/T", "1", "phase of the last period", {}},
                 {"z_max", "", "1", "max |dz|/z0 over the axis nodes", {}},
                 {"z_rms", "", "1", "rms of dz/z0", {}},
                 {"lab_max", "", "1", "max |d|/z0 in the laboratory", {}},
                 {"lab_rms", "", "1", "rms of |d|/z0 in the laboratory", {}},
                 {"swimming_max", "", "1", "max |d|/z0 with each body's displacement along y taken out", {}},
                 {"swimming_rms", "", "1", "rms of the same", {}}}};
  for (std::size_t k = 0; k < 4; ++k) {
    const Deviation d = deviation(a, b, figure_phases(a)[k], z0);
    record.append({0.25 * static_cast<double>(k + 1), d.z_max, d.z_rms, d.lab_max, d.lab_rms, d.moved_max,
                   d.moved_rms});
  }
  return record;
}

/// The largest growth of the exchange of any of these bodies with the fluid.
double check(const FilamentStudy& study, const std::vector<Stroke>& strokes, Progress& progress) {
  double growth = 0.0;
  for (const Stroke& stroke : strokes) {
    growth = std::max(growth, engine::check_coupling(stroke.fluid, body_of(stroke), coupling_of(stroke),
                                                     fmt::format("the {} body", bond::name_of(stroke.law)),
                                                     study.node_mass, progress));
  }
  return growth;
}

/// What is left of a stroke that broke off.
Observations until(const StrokeResult& seen, const std::string& law) {
  Record nodes{"last_good_nodes",
               "Where the nodes were at the last good look, " + law,
               {{"node", "", "1", "number of the node", {}},
                {"x", "", "L", "in the box, not wrapped", {}},
                {"y", "", "L", "along the filament at rest", {}},
                {"z", "", "L", "along the drive", {}}}};
  const LastGood& good = seen.last_good;
  for (Eigen::Index i = 0; i < good.nodes.rows(); ++i) {
    nodes.append({static_cast<double>(i), good.nodes(i, 0), good.nodes(i, 1), good.nodes(i, 2)});
  }
  Observations left{.records = {history_of(seen, "stroke", law), nodes},
                    .metrics = observe::last_good(good.step, good.fluid)};
  left.metrics.push_back({"least_strain", seen.least_strain, "1", "of any bond until the end"});
  left.metrics.push_back({"greatest_strain", seen.greatest_strain, "1", "of any bond until the end"});
  return left;
}

/// run_stroke() under the name of its law; what it saw until it broke off goes on to the result.
StrokeResult run_named(const Stroke& stroke, const std::string& name, double growth, Progress& progress) {
  try {
    return run_stroke(stroke, name, progress);
  } catch (const StrokeFailure& failure) {
    Observations seen = until(failure.seen, name);
    seen.metrics.push_back(metric_of(growth));
    throw observe::Interrupted(NumericalFailure(fmt::format("{}: {}", name, failure.what())),
                               std::move(seen));
  }
}

std::vector<engine::Phase> parts_of(const scene::Simulation::Seconds& s) {
  return {{"fluid", s.fluid.wall, s.fluid.cpu},
          {"coupling", s.coupling.wall, s.coupling.cpu},
          {"solid", s.solid.wall, s.solid.cpu}};
}

Observations run(const FilamentStudy& study, Progress& progress, engine::Cost& cost) {
  const double z0 = study.stroke.amplitude;
  Stroke other = study.stroke;
  other.law = study.other;
  std::vector<Stroke> strokes{study.stroke, other};
  for (const double factor : study.modulus_factors) {
    strokes.push_back(other);
    strokes.back().law = stiffer(study.other, factor);
  }
  const double growth = check(study, strokes, progress);
  cost.finish("stability of the coupling");
  const StrokeResult a = run_named(study.stroke, bond::name_of(study.stroke.law), growth, progress);
  cost.finish(bond::name_of(study.stroke.law), parts_of(a.seconds));
  const StrokeResult b = run_named(other, bond::name_of(study.other), growth, progress);
  cost.finish(bond::name_of(study.other) + " compared", parts_of(b.seconds));

  Observations seen;
  seen.records = {centre_lines(a, b), deviations_of(a, b, z0),
                  history_of(a, "stroke", bond::name_of(study.stroke.law)),
                  history_of(b, "stroke_compared", bond::name_of(study.other)), histogram_of(a, b)};
  const Deviation d = worst(a, b, z0);
  seen.metrics = {
      {"deviation_z_max", d.z_max, "1", "max |dz|/z0 between the laws over four phases of the last period"},
      {"deviation_z_rms", d.z_rms, "1", "largest rms of dz/z0 of these phases"},
      {"deviation_lab_max", d.lab_max, "1", "max |d|/z0 in the laboratory"},
      {"deviation_swimming_max", d.moved_max, "1", "max |d|/z0, displacement along y taken out"},
      {"period_change", change_over_last_period(a, z0), "1",
       "max |d|/z0 from the period before, law of [bond]"},
      {"period_change_compared", change_over_last_period(b, z0), "1", "the same, law of [compared_bond]"},
      {"swum", swum(a), "L", "along y in the last period, law of [bond]; positive is towards the driven end"},
      {"swum_compared", swum(b), "L", "the same, law of [compared_bond]"},
      {"work", a.work.back(), "M L^2 T^-2", "of the drive in the last period, law of [bond]"},
      {"work_compared", b.work.back(), "M L^2 T^-2", "the same, law of [compared_bond]"},
      {"least_strain", a.least_strain, "1", "of any bond, law of [bond]"},
      {"least_strain_time", a.least_strain_time, "1", "when, in periods"},
      {"least_strain_place", a.least_strain_place, "L", "where along the axis, 0 at the free end"},
      {"greatest_strain", a.greatest_strain, "1", "of any bond, law of [bond]"},
      {"greatest_strain_time", a.greatest_strain_time, "1", "when, in periods"},
      {"greatest_strain_place", a.greatest_strain_place, "L", "where along the axis, 0 at the free end"},
      {"least_strain_compared", b.least_strain, "1", "of any bond, law of [compared_bond]"},
      {"greatest_strain_compared", b.greatest_strain, "1", "of any bond, law of [compared_bond]"},
      {"greatest_mach", std::max(a.greatest_mach, b.greatest_mach), "1",
       "over the runs, at the watched steps"},
      {"period", study.stroke.period(), "T", "2 pi/omega, from the Reynolds number"},
      {"touched_nodes", static_cast<double>(a.touched_nodes), "1",
       "distinct lattice nodes under the supports"},
      metric_of(growth),
  };

  if (study.stroke.short_bond > 0.0) {
    seen.metrics.push_back({"share_short", a.share_short, "1",
                            "of bonds and times of the last period with r < 1.2 sigma, law of [bond]"});
  }
  if (!study.modulus_factors.empty()) {
    Record record{"modulus_deviation",
                  "What a wrong modulus would look like",
                  {{"factor", "E'/E", "1", "of all stiffnesses of the bonds", {}},
                   {"z_max", "", "1", "max |dz|/z0 from the same law with its own modulus", {}},
                   {"z_rms", "", "1", "rms of dz/z0", {}},
                   {"swimming_max", "", "1", "max |d|/z0, displacement along y taken out", {}}}};
    for (std::size_t i = 0; i < study.modulus_factors.size(); ++i) {
      const double factor = study.modulus_factors[i];
      const StrokeResult c = run_named(strokes[2 + i], fmt::format("E x {}", factor), growth, progress);
      const Deviation e = worst(c, b, z0);
      record.append({factor, e.z_max, e.z_rms, e.moved_max});
      cost.finish(fmt::format("modulus x {}", factor), parts_of(c.seconds));
    }
    seen.records.push_back(record);
  }
  // Wall time is no part of what was measured: it goes into the timing of the result.
  return seen;
}

solid::Substeps read_substeps(const io::Section& t) {
  return {.count = static_cast<int>(t.integer("substeps", 1, 1000)), .safety = 0.0};
}

}  // namespace

engine::Study read_filament(const io::Section& top) {
  const bond::AnyLaw law = engine::read_law(top);
  const bond::Derivation derivation = engine::read_derivation(top, law);
  const scene::SolidSpec solid = engine::read_solid(top, law, derivation.rest_length);
  const auto* rod = std::get_if<solid::Rod>(&solid.shape);
  if (rod == nullptr || rod->sections < 3) {
    top.table("solid").fail("shape", "the filament is no rod of three sections or more",
                            "its axis must have nodes", "Use shape = \"rod\"");
  }
  const io::Section t = top.table("filament");
  FilamentStudy study{.stroke = {.fluid = engine::read_fluid(top),
                                 .rod = *rod,
                                 .law = law,
                                 .angle_stiffness = solid.angle_stiffness,
                                 .node_mass = t.number("node_mass"),
                                 .substeps = read_substeps(t),
                                 .coupling = engine::read_coupling(top),
                                 .offset = Vec3::Zero(),
                                 .amplitude = t.number("amplitude"),
                                 .reynolds = t.number("reynolds"),
                                 .driven = Driven::Node,
                                 .ramp_periods = t.number("ramp_periods", 0.0),
                                 .periods = static_cast<int>(t.integer("periods", 1, 1000)),
                                 .watch = engine::read_watch(top)},
                      .other = engine::read_law(top, "compared_bond"),
                      .modulus_factors = {},
                      .node_mass = t.place("node_mass")};
  if (t.has("driven") && t.choice("driven", {"node", "section"}) == "section")
    study.stroke.driven = Driven::Section;
  if (t.has("offset")) {
    const std::vector<double> offset = t.numbers("offset");
    if (offset.size() != 3)
      t.fail("offset", "'offset' is no vector", "it has x, y and z", "Give three numbers");
    study.stroke.offset = {offset[0], offset[1], offset[2]};
  }
  if (t.has("modulus_factors")) study.modulus_factors = t.numbers("modulus_factors");
  for (const bond::NamedValue& p : bond::parameters_of(law)) {
    if (p.name == "diameter") study.stroke.short_bond = 1.2 * p.value;
  }
  for (const auto& [key, value] : {std::pair{"amplitude", study.stroke.amplitude},
                                   {"reynolds", study.stroke.reynolds},
                                   {"node_mass", study.stroke.node_mass}}) {
    if (!(value > 0.0))
      t.fail(key, fmt::format("'{}' is {}", key, value), "it must be positive", "Give more than 0");
  }
  return {.plan = engine::read_plan(top, {.law = law,
                                          .solid = solid,
                                          .method = fmt::format("leap-frog, {} sub-steps, driven at one end",
                                                                study.stroke.substeps.count),
                                          .moves = true,
                                          .fluid = study.stroke.fluid}),
          .measures = {"deviation_z_max",
                       "deviation_z_rms",
                       "deviation_lab_max",
                       "deviation_swimming_max",
                       "period_change",
                       "period_change_compared",
                       "swum",
                       "swum_compared",
                       "work",
                       "work_compared",
                       "least_strain",
                       "least_strain_time",
                       "least_strain_place",
                       "greatest_strain",
                       "greatest_strain_time",
                       "greatest_strain_place",
                       "least_strain_compared",
                       "greatest_strain_compared",
                       "greatest_mach",
                       "period",
                       "touched_nodes",
                       "coupling_growth",
                       "share_short",
                       "centre_lines.z",
                       "centre_lines.y_compared",
                       "centre_lines.z_compared",
                       "centre_lines.y",
                       "law_deviation.z_max"},
          .run = [study](Progress& progress, engine::Cost& cost) { return run(study, progress, cost); }};
}

}  // namespace veriflex::drivers
