#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

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

Record centre_lines(const StrokeResult& a, const StrokeResult& b, double spacing) {
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
      const double rest = static_cast<double>(s) * spacing;
      record.append({static_cast<double>(k * static_cast<std::size_t>(line.rows())) + static_cast<double>(s),
                     static_cast<double>(k + 1) / phases_per_period, static_cast<double>(s),
                     rest + line(s, 1), line(s, 2), rest + line(s, 1) - a.centre[first + k][1],
                     rest + other(s, 1), other(s, 2), rest + other(s, 1) - b.centre[first + k][1]});
    }
  }
  return record;
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

Record periods_of(const StrokeResult& a, const StrokeResult& b) {
  Record record{"periods",
                "Work and swimming, period by period",
                {{"period", "", "1", "number, from 1", {}},
                 {"work", "", "M L^2 T^-2", "of the drive, law of [bond]", {}},
                 {"work_compared", "", "M L^2 T^-2", "law of [compared_bond]", {}},
                 {"swum", "", "L", "along y, law of [bond]; positive is towards the driven end", {}},
                 {"swum_compared", "", "L", "law of [compared_bond]", {}}}};
  for (std::size_t k = 0; k < a.work.size(); ++k) {
    const auto swum_in = [&](const StrokeResult& seen) {
      const std::size_t end = (k + 1) * phases_per_period - 1;
      return seen.centre[end][1] - (k > 0 ? seen.centre[end - phases_per_period][1] : 0.0);
    };
    record.append({static_cast<double>(k + 1), a.work[k], b.work[k], swum_in(a), swum_in(b)});
  }
  return record;
}

/// Speeds in the plane of the stroke, law of [bond].
Record film_of(const StrokeResult& seen) {
  Record record{"film",
                "Speed of the fluid in the plane of the stroke",
                {{"phase", "t/T", "1", "phase of the last period", {}},
                 {"y", "y", "L", "along the filament at rest, 0 where its free end was", {}},
                 {"z", "z", "L", "along the drive, 0 on the axis at rest", {}},
                 {"speed", "|u|", "L T^-1", "of the fluid", {}}}};
  for (const Frame& frame : seen.film) {
    for (Eigen::Index i = 0; i < frame.place.rows(); ++i) {
      record.append({frame.phase, frame.place(i, 1), frame.place(i, 2), frame.speed[i]});
    }
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

void add(std::vector<observe::Metric>& metrics, const std::vector<observe::Metric>& more) {
  metrics.insert(metrics.end(), more.begin(), more.end());
}

/// Of the law of [bond] alone.
std::vector<observe::Metric> metrics_of(const StrokeResult& a, const Stroke& stroke) {
  std::vector<observe::Metric> metrics{
      {"swum", swum(a), "L", "along y in the last period, law of [bond]; positive is towards the driven end"},
      {"work", a.work.back(), "M L^2 T^-2", "of the drive in the last period, law of [bond]"},
      {"min_strain", a.min_strain, "1", "of any bond at any step, law of [bond]"},
      {"min_strain_time", a.min_strain_time, "1", "when, in periods"},
      {"min_strain_place", a.min_strain_place, "L", "where along the axis, 0 at the free end"},
      {"max_strain", a.max_strain, "1", "of any bond at any step, law of [bond]"},
      {"max_strain_time", a.max_strain_time, "1", "when, in periods"},
      {"max_strain_place", a.max_strain_place, "L", "where along the axis, 0 at the free end"},
      {"period", stroke.period(), "T", "2 pi/omega, from the Reynolds number"},
      {"touched_nodes", static_cast<double>(a.touched_nodes), "1",
       "distinct lattice nodes under the supports"}};
  add(metrics, period_change_of(a, stroke.amplitude, "period_change",
                                "max |d|/z0 from the period before, law of [bond]"));
  if (stroke.short_bond > 0.0) {
    metrics.push_back({"share_short", a.share_short, "1",
                       "of bonds and sampled times of the last period with r < 1.2 sigma, law of [bond]"});
  }
  return metrics;
}

/// Of the law of [compared_bond] alone.
std::vector<observe::Metric> metrics_of_compared(const StrokeResult& b, const Stroke& stroke) {
  std::vector<observe::Metric> metrics{
      {"swum_compared", swum(b), "L", "the same as swum, law of [compared_bond]"},
      {"work_compared", b.work.back(), "M L^2 T^-2", "the same as work, law of [compared_bond]"},
      {"min_strain_compared", b.min_strain, "1", "of any bond at any step, law of [compared_bond]"},
      {"max_strain_compared", b.max_strain, "1", "of any bond at any step, law of [compared_bond]"}};
  add(metrics, period_change_of(b, stroke.amplitude, "period_change_compared",
                                "max |d|/z0 from the period before, law of [compared_bond]"));
  return metrics;
}

void run(const FilamentStudy& study, Observations& seen, Progress& progress, engine::Cost& cost) {
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
  add(seen.metrics, metrics_of(a, study.stroke));
  if (!a.film.empty()) seen.records.push_back(film_of(a));
  cost.finish(bond::name_of(study.stroke.law), parts_of(a.seconds));
  const StrokeResult b = run_guarded(other, bond::name_of(study.other), "stroke_compared", progress);
  seen.records.push_back(history_of(b, "stroke_compared", bond::name_of(study.other)));
  add(seen.metrics, metrics_of_compared(b, other));
  cost.finish(bond::name_of(study.other) + " compared", parts_of(b.seconds));

  seen.records.insert(seen.records.begin(),
                      {centre_lines(a, b, study.stroke.rod.spacing), deviations_of(a, b, z0)});
  seen.records.push_back(histogram_of(a, b));
  seen.records.push_back(periods_of(a, b));
  const Deviation d = worst(a, b, z0);
  add(seen.metrics,
      {{"deviation_z_max", d.z_max, "1", "max |dz|/z0 between the laws over four phases of the last period"},
       {"deviation_z_rms", d.z_rms, "1", "largest rms of dz/z0 of these phases"},
       {"deviation_lab_max", d.lab_max, "1", "max |d|/z0 in the laboratory"},
       {"deviation_swimming_max", d.moved_max, "1", "max |d|/z0, displacement along y taken out"},
       {"max_mach", worse(a.max_mach, b.max_mach), "1",
        "over the runs, sampled at the watched steps, the first and the last"},
       {"dt_over_limit", worse(step_over_limit(study.stroke), step_over_limit(other)), "1",
        "sub-step over the linear limit 2/omega_max at rest"}});

  const std::array<std::size_t, 4> phases = figure_phases(a);
  for (std::size_t k = 0; k < phases.size(); ++k) {
    seen.metrics.push_back({fmt::format("deviation_z_phase_{}", k + 1), deviation(a, b, phases[k], z0).z_max,
                            "1",
                            fmt::format("max |dz|/z0 between the laws at {}/4 of the last period", k + 1)});
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
      const StrokeResult c =
          run_guarded(strokes[2 + i], fmt::format("E x {}", factor), "stroke_modulus", progress);
      const Deviation e = worst(c, b, z0);
      record.append({factor, e.z_max, e.z_rms, e.moved_max});
      cost.finish(fmt::format("modulus x {}", factor), parts_of(c.seconds));
    }
    seen.records.push_back(record);
    seen.metrics.push_back(
        {"modulus_low", modulus_at(record, d.z_max, -1), "1",
         "a softer body's E'/E that moves the centre line as far as the change of the law"});
    seen.metrics.push_back({"modulus_high", modulus_at(record, d.z_max, +1), "1",
                            "a stiffer body's E'/E that does; the farthest tried when none does"});
  }
  // Wall time is no part of what was measured: it goes into the timing of the result.
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
  std::vector<std::string> measures{"deviation_z_max",
                                    "deviation_z_rms",
                                    "deviation_z_phase_1",
                                    "deviation_z_phase_2",
                                    "deviation_z_phase_3",
                                    "deviation_z_phase_4",
                                    "deviation_lab_max",
                                    "deviation_swimming_max",
                                    "swum",
                                    "swum_compared",
                                    "work",
                                    "work_compared",
                                    "min_strain",
                                    "min_strain_time",
                                    "min_strain_place",
                                    "max_strain",
                                    "max_strain_time",
                                    "max_strain_place",
                                    "min_strain_compared",
                                    "max_strain_compared",
                                    "max_mach",
                                    "period",
                                    "touched_nodes",
                                    "coupling_growth",
                                    "dt_over_limit",
                                    "centre_lines.z",
                                    "centre_lines.y_compared",
                                    "centre_lines.z_compared",
                                    "centre_lines.y",
                                    "law_deviation.z_max"};
  if (study.stroke.periods > 1) measures.insert(measures.end(), {"period_change", "period_change_compared"});
  if (study.stroke.short_bond > 0.0) measures.emplace_back("share_short");
  if (!study.modulus_factors.empty()) measures.insert(measures.end(), {"modulus_low", "modulus_high"});
  scene::Plan plan = plan_stroke(top, study.stroke);
  return {.plan = std::move(plan),
          .measures = measures,
          .run = [study](Observations& seen, Progress& progress,
                         engine::Cost& cost) { run(study, seen, progress, cost); },
          .expects = [study] { return expected_work(study.stroke, 2 + std::ssize(study.modulus_factors)); },
          .offers =
              [study] {
                return scene::offers({.fluid = study.stroke.fluid, .bodies = {body_of(study.stroke)}},
                                     [](std::size_t) { return "filament.substeps"; });
              }};
}

}  // namespace veriflex::measures
