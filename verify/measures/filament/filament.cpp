#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "base/reduce.hpp"
#include "bond/derive.hpp"
#include "engine/read_scene.hpp"
#include "measures/drivers.hpp"
#include "measures/filament/filament_case.hpp"
#include "measures/filament/filament_compare.hpp"
#include "measures/filament/filament_guard.hpp"

// The paper's one result: the driven filament with the one bond law against the other. Both run in the same
// fluid, and what is asked is how far their centre lines are apart.

namespace veriflex::measures {

namespace {

using observe::Observations;
using observe::Record;

struct FilamentStudy {
  Stroke stroke;                        // with the law of [bond]
  bond::AnyLaw other;                   // of [compared_bond]
  std::vector<double> modulus_factors;  // of the compared law's body: what a wrong modulus would look like
};

/// Scaled energies scale the modulus and every stiffness of a law by the same factor and leave its rest
/// length.
bond::AnyLaw stiffer(const bond::AnyLaw& law, double factor) { return bond::rescaled(law, factor, 1.0); }

Observations filament_observations(const FilamentStudy& study) {
  Observations all;
  all.records = {
      {"centre_lines",
       "Centre lines in the last period",
       {{"point", "", "1", "number of the row", {}},
        {"phase", "t/T", "1", "phase of the last period", {}},
        {"section", "", "1", "number of the section, 0 at the free end", {}},
        {"y", "y", "L", "along the filament at rest, law of [bond]", {}},
        {"z", "z", "L", "across it, along the drive", {}},
        {"y_swimming", "", "L", "y less the body's own displacement", {}},
        {"y_compared", "", "L", "y, law of [compared_bond]", {}},
        {"z_compared", "", "L", "z, law of [compared_bond]", {}},
        {"y_swimming_compared", "", "L", "y less the body's own displacement, law of [compared_bond]", {}}}},
      {"law_deviation",
       "How far the two laws' centre lines are apart",
       {{"phase", "t/T", "1", "phase of the last period", {}},
        {"z_max", "", "1", "max |dz|/z0 over the axis nodes", {}},
        {"z_rms", "", "1", "rms of dz/z0", {}},
        {"lab_max", "", "1", "max |d|/z0 in the laboratory", {}},
        {"lab_rms", "", "1", "rms of |d|/z0 in the laboratory", {}},
        {"swimming_max", "", "1", "max |d|/z0 with each body's displacement along y taken out", {}},
        {"swimming_rms", "", "1", "rms of the same", {}}}},
      {"film",
       "Speed of the fluid in the plane of the stroke",
       {{"phase", "t/T", "1", "phase of the last period", {}},
        {"y", "y", "L", "along the filament at rest, 0 where its free end was", {}},
        {"z", "z", "L", "along the drive, 0 on the axis at rest", {}},
        {"speed", "|u|", "L T^-1", "of the fluid, law of [bond]", {}}}},
      {"strain_histogram",
       "Bond lengths in the last period",
       {{"length", "r/r0", "1", "middle of the bin, over the spacing", {}},
        {"share", "", "1", "of bonds and times, law of [bond]", {}},
        {"share_compared", "", "1", "law of [compared_bond]", {}}}},
      {"periods",
       "Work and swimming, period by period",
       {{"period", "", "1", "number, from 1", {}},
        {"work", "", "M L^2 T^-2", "of the drive, law of [bond]", {}},
        {"work_compared", "", "M L^2 T^-2", "law of [compared_bond]", {}},
        {"swum", "", "L", "along y, law of [bond]; positive is towards the driven end", {}},
        {"swum_compared", "", "L", "law of [compared_bond]", {}}}},
      {"modulus_deviation",
       "What a wrong modulus would look like",
       {{"factor", "E'/E", "1", "of all stiffnesses of the bonds", {}},
        {"z_max", "", "1", "max |dz|/z0 from the same law with its own modulus", {}},
        {"z_rms", "", "1", "rms of dz/z0", {}},
        {"swimming_max", "", "1", "max |d|/z0, displacement along y taken out", {}}}}};
  all.metrics = {
      growth_of_coupling(),
      {"swum", {}, "L", "along y in the last period, law of [bond]; positive is towards the driven end"},
      {"work", {}, "M L^2 T^-2", "of the drive in the last period, law of [bond]"},
      {"min_strain", {}, "1", "of any bond at any step, law of [bond]"},
      {"min_strain_time", {}, "1", "when, in periods"},
      {"min_strain_place", {}, "L", "where along the axis, 0 at the free end"},
      {"max_strain", {}, "1", "of any bond at any step, law of [bond]"},
      {"max_strain_time", {}, "1", "when, in periods"},
      {"max_strain_place", {}, "L", "where along the axis, 0 at the free end"},
      {"period", {}, "T", "2 pi/omega, from the Reynolds number"},
      {"touched_nodes", {}, "1", "distinct lattice nodes under the supports"},
      {"swum_compared", {}, "L", "the same as swum, law of [compared_bond]"},
      {"work_compared", {}, "M L^2 T^-2", "the same as work, law of [compared_bond]"},
      {"min_strain_compared", {}, "1", "of any bond at any step, law of [compared_bond]"},
      {"max_strain_compared", {}, "1", "of any bond at any step, law of [compared_bond]"},
      {"deviation_z_max", {}, "1", "max |dz|/z0 between the laws over four phases of the last period"},
      {"deviation_z_rms", {}, "1", "largest rms of dz/z0 of these phases"},
      {"deviation_lab_max", {}, "1", "max |d|/z0 in the laboratory"},
      {"deviation_swimming_max", {}, "1", "max |d|/z0, displacement along y taken out"},
      {"max_mach", {}, "1", "over the runs, sampled at the watched steps, the first and the last"},
      {"dt_over_limit", {}, "1", "sub-step over the linear limit 2/omega_max at rest"}};
  for (int k = 1; k <= 4; ++k) {
    all.metrics.push_back({fmt::format("deviation_z_phase_{}", k),
                           {},
                           "1",
                           fmt::format("max |dz|/z0 between the laws at {}/4 of the last period", k)});
  }
  if (study.stroke.periods > 1) {
    all.metrics.insert(
        all.metrics.end(),
        {{"period_change", {}, "1", "max |d|/z0 from the period before, law of [bond]"},
         {"period_change_compared", {}, "1", "max |d|/z0 from the period before, law of [compared_bond]"}});
  }
  if (study.stroke.short_bond > 0.0) {
    all.metrics.push_back(
        {"share_short",
         {},
         "1",
         "of bonds and sampled times of the last period with r < 1.2 sigma, law of [bond]"});
  }
  if (!study.modulus_factors.empty()) {
    all.metrics.insert(
        all.metrics.end(),
        {{"modulus_low",
          {},
          "1",
          "a softer body's E'/E that moves the centre line as far as the change of the law"},
         {"modulus_high", {}, "1", "a stiffer body's E'/E that does; the farthest tried when none does"}});
  }
  return all;
}

void record_centre_lines(const StrokeResult& a, const StrokeResult& b, double spacing, Record& record) {
  const std::size_t first = a.lines.size() - phases_per_period;
  for (std::size_t k = 0; k < phases_per_period; ++k) {
    const CentreLine& line = a.lines[first + k];
    const CentreLine& other = b.lines[first + k];
    for (Eigen::Index s = 0; s < line.rows(); ++s) {
      const double rest = static_cast<double>(s) * spacing;
      record.append({static_cast<double>(k * static_cast<std::size_t>(line.rows())) + static_cast<double>(s),
                     static_cast<double>(k + 1) / phases_per_period, static_cast<double>(s),
                     rest + line(s, 1), line(s, 2), rest + line(s, 1) - a.centre[first + k][1],
                     rest + other(s, 1), other(s, 2), rest + other(s, 1) - b.centre[first + k][1]});
    }
  }
}

void record_histogram(const StrokeResult& a, const StrokeResult& b, Record& record) {
  const double bin = (strain_bin_hi - strain_bin_lo) / strain_bins;
  for (int i = 0; i < strain_bins; ++i) {
    const auto k = static_cast<std::size_t>(i);
    record.append({1.0 + strain_bin_lo + (i + 0.5) * bin, a.histogram[k], b.histogram[k]});
  }
}

void record_periods(const StrokeResult& a, const StrokeResult& b, Record& record) {
  for (std::size_t k = 0; k < a.work.size(); ++k) {
    const auto swum_in = [&](const StrokeResult& seen) {
      const std::size_t end = (k + 1) * phases_per_period - 1;
      return seen.centre[end][1] - (k > 0 ? seen.centre[end - phases_per_period][1] : 0.0);
    };
    record.append({static_cast<double>(k + 1), a.work[k], b.work[k], swum_in(a), swum_in(b)});
  }
}

void record_film(const StrokeResult& seen, Record& record) {
  for (const Frame& frame : seen.film) {
    for (Eigen::Index i = 0; i < frame.place.rows(); ++i) {
      record.append({frame.phase, frame.place(i, 1), frame.place(i, 2), frame.speed[i]});
    }
  }
}

void record_deviations(const StrokeResult& a, const StrokeResult& b, double z0, Observations& seen) {
  for (std::size_t k = 0; k < 4; ++k) {
    const Deviation d = deviation(a, b, figure_phases(a)[k], z0);
    seen.open("law_deviation")
        .append({0.25 * static_cast<double>(k + 1), d.z_max, d.z_rms, d.lab_max, d.lab_rms, d.moved_max,
                 d.moved_rms});
    seen.set(fmt::format("deviation_z_phase_{}", k + 1), d.z_max);
  }
  const Deviation d = worst(a, b, z0);
  seen.set("deviation_z_max", d.z_max);
  seen.set("deviation_z_rms", d.z_rms);
  seen.set("deviation_lab_max", d.lab_max);
  seen.set("deviation_swimming_max", d.moved_max);
}

/// E'/E on one side of 1 at which a wrong modulus moves the centre line by `distance`, linear between the
/// factors tried; the farthest of these when all stay below.
double modulus_at(const Record& record, double distance, int side) {
  std::vector<std::pair<double, double>> tried{{1.0, 0.0}};
  for (std::size_t i = 0; i < record.find("factor")->values.size(); ++i) {
    const double factor = record.find("factor")->values[i];
    if ((factor - 1.0) * side > 0.0) tried.emplace_back(factor, record.find("z_max")->values[i]);
  }
  std::sort(tried.begin(), tried.end(),
            [&](const auto& a, const auto& b) { return (a.first - b.first) * side < 0.0; });
  for (std::size_t i = 1; i < tried.size(); ++i) {
    const auto& [near, below] = tried[i - 1];
    const auto& [far, above] = tried[i];
    if (above >= distance) return near + (far - near) * (distance - below) / (above - below);
  }
  return tried.back().first;
}

/// Of the law of [bond] alone.
void measure(const StrokeResult& a, const Stroke& stroke, Observations& seen) {
  seen.set("swum", swum(a));
  seen.set("work", a.work.back());
  seen.set("min_strain", a.min_strain);
  seen.set("min_strain_time", a.min_strain_time);
  seen.set("min_strain_place", a.min_strain_place);
  seen.set("max_strain", a.max_strain);
  seen.set("max_strain_time", a.max_strain_time);
  seen.set("max_strain_place", a.max_strain_place);
  seen.set("period", stroke.period());
  seen.set("touched_nodes", static_cast<double>(a.touched_nodes));
  if (stroke.periods > 1) seen.set("period_change", change_over_last_period(a, stroke.amplitude));
  if (stroke.short_bond > 0.0) seen.set("share_short", a.share_short);
  record_film(a, seen.open("film"));
}

/// Of the law of [compared_bond] alone.
void measure_compared(const StrokeResult& b, const Stroke& stroke, Observations& seen) {
  seen.set("swum_compared", swum(b));
  seen.set("work_compared", b.work.back());
  seen.set("min_strain_compared", b.min_strain);
  seen.set("max_strain_compared", b.max_strain);
  if (stroke.periods > 1) seen.set("period_change_compared", change_over_last_period(b, stroke.amplitude));
}

void run_filament(const FilamentStudy& study, Observations& seen, Progress& progress, engine::Cost& cost) {
  const double z0 = study.stroke.amplitude;
  Stroke other = study.stroke;
  other.law = study.other;
  other.film = 0;
  std::vector<Stroke> strokes{study.stroke, other};
  for (const double factor : study.modulus_factors) {
    strokes.push_back(other);
    strokes.back().law = stiffer(study.other, factor);
  }
  check_strokes(strokes, seen, progress);
  cost.finish("stability of the coupling");
  const StrokeResult a = run_guarded(study.stroke, bond::name_of(study.stroke.law), "stroke", progress);
  seen.records.push_back(history_of(a, "stroke", bond::name_of(study.stroke.law)));
  measure(a, study.stroke, seen);
  cost.finish(bond::name_of(study.stroke.law), parts_of(a.seconds));
  const StrokeResult b = run_guarded(other, bond::name_of(study.other), "stroke_compared", progress);
  seen.records.push_back(history_of(b, "stroke_compared", bond::name_of(study.other)));
  measure_compared(b, other, seen);
  cost.finish(bond::name_of(study.other) + " compared", parts_of(b.seconds));

  record_centre_lines(a, b, study.stroke.rod.spacing, seen.open("centre_lines"));
  record_histogram(a, b, seen.open("strain_histogram"));
  record_periods(a, b, seen.open("periods"));
  record_deviations(a, b, z0, seen);
  seen.set("max_mach", worse(a.max_mach, b.max_mach));
  seen.set("dt_over_limit", worse(step_over_limit(study.stroke), step_over_limit(other)));
  if (study.modulus_factors.empty()) return;
  Record& record = seen.open("modulus_deviation");
  for (std::size_t i = 0; i < study.modulus_factors.size(); ++i) {
    const double factor = study.modulus_factors[i];
    const StrokeResult c =
        run_guarded(strokes[2 + i], fmt::format("E x {}", factor), "stroke_modulus", progress);
    const Deviation e = worst(c, b, z0);
    record.append({factor, e.z_max, e.z_rms, e.moved_max});
    cost.finish(fmt::format("modulus x {}", factor), parts_of(c.seconds));
  }
  const double distance = worst(a, b, z0).z_max;
  seen.set("modulus_low", modulus_at(record, distance, -1));
  seen.set("modulus_high", modulus_at(record, distance, +1));
}

std::vector<double> read_factors(const io::Table& t, const bond::AnyLaw& law) {
  const std::vector<double> factors = t.numbers("modulus_factors");
  for (auto factor = factors.begin(); factor != factors.end(); ++factor) {
    const auto fail = [&](const std::string& why) {
      t.fail("modulus_factors", fmt::format("'modulus_factors' holds {}", *factor), why,
             "Give for example [0.95, 1.05]");
    };
    if (!(*factor > 0.0)) fail("a modulus is positive");
    if (std::find(factors.begin(), factor, *factor) != factor) fail("twice the same run");
    try {
      stiffer(law, *factor);
    } catch (const BadParameter& bad) {
      fail(fmt::format("{}: {}", bad.problem, bad.why));
    }
  }
  return factors;
}

}  // namespace

engine::Study read_filament(const io::Table& top) {
  FilamentStudy study{
      .stroke = read_stroke(top), .other = engine::read_law(top, "compared_bond"), .modulus_factors = {}};
  const io::Table t = top.table("filament");
  if (t.has("modulus_factors")) study.modulus_factors = read_factors(t, study.other);
  if (t.has("film")) study.stroke.film = t.integer("film", 1, 1000);
  scene::Plan plan = plan_stroke(top, study.stroke);
  return {
      .plan = std::move(plan),
      .declares = filament_observations(study),
      .run = std::bind_front(run_filament, study),
      .expects =
          [study] { return std::vector{expected_work(study.stroke, 2 + std::ssize(study.modulus_factors))}; },
      .offers =
          [study] {
            return scene::offers({.fluid = study.stroke.fluid, .bodies = {body_of(study.stroke)}},
                                 [](std::size_t) { return "filament.substeps"; });
          }};
}

}  // namespace veriflex::measures
