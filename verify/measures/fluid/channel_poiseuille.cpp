#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "analytic/channel.hpp"
#include "measures/fluid/channel.hpp"
#include "measures/for_all.hpp"
#include "observe/field.hpp"

// Between plates nothing but the velocity along them varies, and the lattice's own steady state is known: the
// parabola with a slip of g (16 (tau - 1/2)^2 - 3)/(24 nu), in the velocity sum f c + g/2. The bare velocity
// sum f c is what both force schemes have in common, before the collision; it lags by the half step g/2.

namespace veriflex::measures::channel {

namespace {

using observe::Observations;
using observe::Record;

struct Poiseuille {
  Common common;
  Steady steady;
  double velocity;                       // of the parabola's top at the first resolution  [L T^-1]
  std::vector<double> relaxation_times;  // of the slip, at the first resolution
  std::vector<fluid::Storage> storages;  // whose error is plotted against run time; may be empty
};

struct Piece {
  double relaxation_time;
  fluid::Scheme scheme;
  std::size_t normal;
  std::int64_t nodes;
};

/// Falls as 1/nodes, so that the Reynolds number stays (diffusive scaling).
double top_velocity(const Poiseuille& study, std::int64_t nodes) {
  return study.velocity * static_cast<double>(study.common.resolutions.front()) / static_cast<double>(nodes);
}

double force_of(const Poiseuille& study, const Piece& piece) {
  const auto height = static_cast<double>(piece.nodes);
  return 8.0 * fluid::viscosity(piece.relaxation_time) * top_velocity(study, piece.nodes) / (height * height);
}

fluid::Spec spec_of(const Poiseuille& study, const Piece& piece) {
  fluid::Spec spec = gap(study.common.fluid, piece.normal, piece.nodes);
  spec.relaxation_time = piece.relaxation_time;
  spec.scheme = piece.scheme;
  spec.body_force[static_cast<Eigen::Index>(along(piece.normal))] = force_of(study, piece);
  return spec;
}

std::vector<double> along_gap(const fluid::Fluid& fluid, std::size_t normal) {
  const std::vector<std::int64_t> nodes = observe::line(fluid.spec().grid, normal, {0, 0, 0});
  const Positions u = velocities_of(fluid, nodes);
  const auto column = u.col(static_cast<Eigen::Index>(along(normal)));
  return {column.begin(), column.end()};
}

/// sum f c across the gap once it is steady.
std::vector<double> bare_profile(const Poiseuille& study, const Piece& piece) {
  const std::unique_ptr<fluid::Fluid> fluid = fluid::make_fluid(spec_of(study, piece));
  run_to_steady(*fluid, observe::line(fluid->spec().grid, piece.normal, {0, 0, 0}), study.steady,
                study.common.monitor);
  return along_gap(*fluid, piece.normal);
}

std::vector<double> plus(std::vector<double> values, double offset) {
  for (double& value : values) value += offset;
  return values;
}

std::vector<double> parabola(const Poiseuille& study, const Piece& piece) {
  std::vector<double> u;
  for (std::int64_t j = 0; j < piece.nodes; ++j) {
    u.push_back(force_of(study, piece) / fluid::viscosity(piece.relaxation_time) *
                analytic::plane_poiseuille(from_wall(j), static_cast<double>(piece.nodes)));
  }
  return u;
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double worst = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    worst = worse(worst, std::abs(a[i] - b[i]));
  }
  return worst;
}

/// Mean over the gap of (velocity - parabola)/g.
double slip_over_force(const Poiseuille& study, const Piece& piece, const std::vector<double>& velocity) {
  const std::vector<double> exact = parabola(study, piece);
  double sum = 0.0;
  for (std::size_t i = 0; i < exact.size(); ++i) sum += velocity[i] - exact[i];
  return sum / static_cast<double>(exact.size()) / force_of(study, piece);
}

/// Every relaxation time with both schemes and walls on each axis, at the first resolution.
std::vector<Piece> slip_pieces(const Poiseuille& study) {
  std::vector<Piece> pieces;
  for (const double tau : study.relaxation_times) {
    for (const fluid::Scheme scheme : {fluid::Scheme::FirstOrder, fluid::Scheme::Guo}) {
      for (const std::size_t normal : {1U, 0U, 2U})
        pieces.push_back({tau, scheme, normal, study.common.resolutions.front()});
    }
  }
  return pieces;
}

void measure_slip(const Poiseuille& study, Progress& progress, Observations& seen) {
  const std::vector<Piece> pieces = slip_pieces(study);
  seen.records.push_back({"slip",
                          "Slip at the wall over the force",
                          {{"relaxation_time", "τ", "T", "", {}},
                           {"slip_first_order", "", "T", "in sum f c + g/2, first-order force", {}},
                           {"slip_guo", "", "T", "in sum f c + g/2, Guo's force", {}},
                           {"slip_exact", "", "T", "(16 (tau - 1/2)^2 - 3)/(24 nu)", {}},
                           {"slip_bare", "", "T", "in sum f c, first-order force", {}}}});
  double exact_error = 0.0, axes = 0.0, schemes = 0.0;
  const double scale = study.velocity;
  std::vector<std::vector<double>> bare(pieces.size());
  const auto keep = [&](std::size_t last) {  // of six: first-order y, x, z; Guo y, x, z
    if (last % 6 != 5) return;
    const std::size_t i = last - 5;
    if (std::any_of(&bare[i], &bare[last], [](const auto& profile) { return profile.empty(); })) return;
    const Piece& piece = pieces[i];
    const double g = force_of(study, piece);
    const double slip = analytic::half_way_slip(piece.relaxation_time);
    const std::vector<double> exact = plus(parabola(study, piece), slip * g);
    for (std::size_t k = i; k < i + 6; ++k) {
      exact_error = worse(exact_error, largest_difference(plus(bare[k], 0.5 * g), exact) / scale);
    }
    for (const std::size_t k : {i + 1, i + 2})
      axes = worse(axes, largest_difference(bare[k], bare[i]) / scale);
    for (const std::size_t k : {i + 4, i + 5})
      axes = worse(axes, largest_difference(bare[k], bare[i + 3]) / scale);
    schemes = worse(schemes, largest_difference(bare[i], bare[i + 3]) / scale);
    seen.records.front().append({piece.relaxation_time, slip_over_force(study, piece, plus(bare[i], 0.5 * g)),
                                 slip_over_force(study, piece, plus(bare[i + 3], 0.5 * g)), slip,
                                 slip_over_force(study, piece, bare[i])});
  };
  for_all(
      pieces.size(), "relaxation times", progress,
      [&](std::size_t i) { bare[i] = bare_profile(study, pieces[i]); }, keep);
  seen.metrics.push_back({"exact_error", exact_error, "1",
                          "sum f c + g/2 against the lattice's own solution, over the top velocity; worst of "
                          "all relaxation times, schemes and axes"});
  seen.metrics.push_back(
      {"axis_difference", axes, "1", "walls across x or z against y, over the top velocity"});
  seen.metrics.push_back({"scheme_difference", schemes, "1",
                          "sum f c of Guo's scheme against that of first order, over the top velocity"});
}

Piece convergence_piece(const Poiseuille& study, std::int64_t nodes) {
  return {study.common.fluid.relaxation_time, study.common.fluid.scheme, 1, nodes};
}

void measure_convergence(const Poiseuille& study, Progress& progress, Observations& seen) {
  const std::vector<std::int64_t>& resolutions = study.common.resolutions;
  std::vector<std::vector<double>> bare(resolutions.size());
  std::vector<Norms> bare_errors;
  for_all(
      resolutions.size(), "resolutions", progress,
      [&](std::size_t i) { bare[i] = bare_profile(study, convergence_piece(study, resolutions[i])); },
      [&](std::size_t i) {
        const Piece piece = convergence_piece(study, resolutions[i]);
        const std::vector<double> exact = parabola(study, piece);
        add_errors(seen, resolutions[i], error_norms(plus(bare[i], 0.5 * force_of(study, piece)), exact));
        bare_errors.push_back(error_norms(bare[i], exact));
      });
  add_convergence(seen);

  const Piece coarsest = convergence_piece(study, resolutions.front());
  const double g = force_of(study, coarsest);
  seen.metrics.push_back({"error_bare_l2", bare_errors.back().l2, "1", "of sum f c, finest resolution"});
  seen.metrics.push_back({"slip", slip_over_force(study, coarsest, plus(bare[0], 0.5 * g)), "T",
                          "slip over g in sum f c + g/2, first resolution"});
  seen.metrics.push_back({"slip_bare", slip_over_force(study, coarsest, bare[0]), "T",
                          "slip over g in sum f c, first resolution"});

  Record profile{"profile",
                 "Velocity across the gap at the coarsest resolution",
                 {{"position", "y/H", "1", "from wall to wall", {}},
                  {"velocity", "", "1", "sum f c + g/2, over the parabola's top", {}},
                  {"velocity_exact", "", "1", "the parabola", {}},
                  {"bare", "", "1", "sum f c, over the parabola's top", {}},
                  {"bare_exact", "", "1", "the parabola", {}}}};
  const std::vector<double> exact = parabola(study, coarsest);
  for (std::size_t j = 0; j < exact.size(); ++j) {
    const double u = study.velocity;
    profile.append({(static_cast<double>(j) + 0.5) / static_cast<double>(exact.size()),
                    (bare[0][j] + 0.5 * g) / u, exact[j] / u, bare[0][j] / u, exact[j] / u});
  }
  seen.records.push_back(profile);
}

/// After this many H^2/nu the slowest mode has fallen by exp(-2.5 pi^2) = 2e-11.
constexpr double viscous_times = 2.5;
constexpr double max_steps = 1e9;
constexpr std::int64_t row = 32;  // nodes along x: full vectors in both storages

double work_steps(const Poiseuille& study, std::int64_t nodes) {
  const auto height = static_cast<double>(nodes);
  return std::ceil(viscous_times * height * height / fluid::viscosity(study.common.fluid.relaxation_time));
}

fluid::Spec work_spec(const Poiseuille& study, fluid::Storage storage, std::int64_t nodes) {
  fluid::Spec spec = spec_of(study, convergence_piece(study, nodes));
  spec.storage = storage;
  spec.grid.size[0] = row;
  spec.grid.size[2] = 2;
  return spec;
}

/// Both storages do the same steps; what float saves in time it pays in error. Two nodes along z are one
/// thread's work: waiting for another would be most of what is measured in a box this small.
void measure_work(const Poiseuille& study, engine::Cost& cost, Observations& seen) {
  seen.records.push_back(
      {"work_precision",
       "Error of the velocity against the work done",
       {{"nodes", "", "1", "across the gap", {}},
        {"bits", "", "1", "of a stored population", {}},
        {"steps", "", "1", "2.5 H^2/nu", {}},
        {"node_steps", "", "1", "steps times nodes of the box", {}},
        {"error", "", "1", "root mean square against the parabola, over that of the velocity", {}}}});
  Record& record = seen.records.back();
  cost.finish("set-up");
  std::vector<double> finest;
  for (const fluid::Storage storage : study.storages) {
    for (const std::int64_t nodes : study.common.resolutions) {
      const Piece piece = convergence_piece(study, nodes);
      const fluid::Spec spec = work_spec(study, storage, nodes);
      const double steps = work_steps(study, nodes);
      const std::unique_ptr<fluid::Fluid> fluid = fluid::make_fluid(spec);
      run_steps(*fluid, static_cast<std::int64_t>(steps), study.common.monitor);
      const std::vector<double> u = plus(along_gap(*fluid, 1), 0.5 * force_of(study, piece));
      const double error = error_norms(u, parabola(study, piece)).l2;
      cost.finish(fmt::format("work_precision/{}", record.columns[0].values.size()));
      record.append({static_cast<double>(nodes), 8.0 * static_cast<double>(fluid::bytes_of(storage)), steps,
                     steps * static_cast<double>(spec.grid.count()), error});
      if (nodes == study.common.resolutions.back()) finest.push_back(error);
    }
  }
  for (std::size_t i = 0; i < finest.size(); ++i) {
    const bool is_double = study.storages[i] == fluid::Storage::Double;
    seen.metrics.push_back({is_double ? "work_error_double" : "work_error_float", finest[i], "1",
                            "of the finest row of work_precision"});
  }
}

void run(const Poiseuille& study, Observations& seen, Progress& progress, engine::Cost& cost) {
  measure_slip(study, progress, seen);
  cost.finish("slip");
  measure_convergence(study, progress, seen);
  cost.finish("convergence");
  if (!study.storages.empty()) measure_work(study, cost, seen);
}

std::vector<fluid::Storage> read_storages(const io::Table& t) {
  std::vector<fluid::Storage> storages;
  for (const std::string& name : t.texts("storages")) {
    if (storages.size() == 2) t.fail("storages", "more than two", "there are two", "Name each at most once");
    const std::vector<std::string> known = names_of(fluid::storages);
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      t.fail("storages", fmt::format("'storages' holds '{}'", name),
             fmt::format("known: {}", fmt::join(known, ", ")), "Use these");
    }
    storages.push_back(row_named(fluid::storages, name).value);
  }
  if (storages.size() == 2 && storages[0] == storages[1])
    t.fail("storages", "one stands there twice", "each is run once", "Name each at most once");
  return storages;
}

}  // namespace

namespace {

void require_in_reach(const io::Table& t, const Poiseuille& study) {
  const std::vector<std::int64_t>& resolutions = study.common.resolutions;
  const auto require = [&](double tau, std::int64_t nodes) {
    channel::require_in_reach(t, study.steady, slowest_rate(tau, static_cast<double>(nodes)),
                              fmt::format("a gap of {} nodes at tau = {}", nodes, tau));
  };
  for (const double tau : study.relaxation_times) require(tau, resolutions.front());
  require(study.common.fluid.relaxation_time, resolutions.back());
  if (study.storages.empty() || work_steps(study, resolutions.back()) <= max_steps) return;
  t.fail("storages", fmt::format("a run would take {:.3g} steps", work_steps(study, resolutions.back())),
         fmt::format("{:.1g} is the most", max_steps), "Use fewer nodes or a larger relaxation time");
}

/// The plans of all that is run: at once for slip and convergence, in turn for the work.
scene::Plan plan_of(const io::Table& top, const Poiseuille& study) {
  std::vector<fluid::Spec> steady, work;
  for (const Piece& piece : slip_pieces(study)) steady.push_back(spec_of(study, piece));
  for (const std::int64_t nodes : study.common.resolutions) {
    steady.push_back(spec_of(study, convergence_piece(study, nodes)));
    for (const fluid::Storage storage : study.storages) work.push_back(work_spec(study, storage, nodes));
  }
  const scene::Plan at_once = plan_at_once(top, steady);
  if (work.empty()) return at_once;
  const scene::Plan in_turn = plan_in_turn(top, work);
  const auto memory = [](const scene::Plan& plan) {
    double sum = 0.0;
    for (const scene::Built& built : plan.built) sum += built.memory_bytes;
    return sum;
  };
  return memory(in_turn) > memory(at_once) ? in_turn : at_once;
}

}  // namespace

engine::Study read_poiseuille(const io::Table& top) {
  const io::Table t = top.table("channel");
  const Common common = read_common(top);
  Poiseuille study{.common = common,
                   .steady = read_steady(t, 1e-15, common.fluid.storage),
                   .velocity = read_velocity(t, common),
                   .relaxation_times = t.numbers("relaxation_times"),
                   .storages = {}};
  if (t.has("storages")) study.storages = read_storages(t);
  if (study.relaxation_times.empty() ||
      *std::min_element(study.relaxation_times.begin(), study.relaxation_times.end()) <= 0.5) {
    t.fail("relaxation_times", "none, or one that is not more than 0.5",
           "the viscosity (tau - 1/2)/3 must be positive", "Give for example [0.6, 1.0, 1.5]");
  }
  require_in_reach(t, study);
  std::vector<std::string> measures = convergence_measures();
  measures.insert(measures.end(), {"exact_error", "axis_difference", "scheme_difference", "error_bare_l2",
                                   "slip", "slip_bare", "profile.velocity", "profile.bare"});
  for (const fluid::Storage storage : study.storages) {
    measures.push_back(fmt::format("work_error_{}", row_of(fluid::storages, storage).id));
  }
  return {.plan = plan_of(top, study),
          .measures = measures,
          .run = [study](Observations& seen, Progress& progress, engine::Cost& cost) {
            run(study, seen, progress, cost);
          }};
}

}  // namespace veriflex::measures::channel
