#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "base/error.hpp"
#include "base/reduce.hpp"
#include "engine/read_scene.hpp"
#include "measures/coupling/kicked_run.hpp"
#include "measures/drivers.hpp"
#include "measures/scene/scene.hpp"
#include "scene/coupling_stability.hpp"
#include "scene/exact_growth.hpp"
#include "scene/simulated_step.hpp"
#include "scene/transient_growth.hpp"

// How fast small perturbations of a scene at rest grow, three ways: by the spectrum of its own steps, by the
// linearised exchange without the fluid's own motion, and by a run that is kicked; and the node mass from
// which they do not.

namespace veriflex::measures {

namespace {

using observe::Observations;
using observe::Record;

struct SpectrumStudy {
  scene::Scene scene;  // at rest
  scene::GrowthSearch search;
  std::int64_t steps;                   // of a kicked run
  std::optional<double> resolution;     // of a measured least node mass; none is looked for without it
  std::vector<std::int64_t> transient;  // numbers of steps whose largest amplification is asked, rising
};

bool is_elastic_in_fluid(const scene::Body& body) { return body.coupling && !body.motion; }

/// All node masses by the same factor, and kicked.
scene::Scene kicked(const scene::Scene& scene, double factor) {
  scene::Scene heavier = scene;
  std::uint64_t seed = 1;
  for (scene::Body& body : heavier.bodies) {
    body.conditions.node_mass *= factor;
    if (!body.motion) body.conditions.load = kick_of(body.network.node_count(), seed++);
  }
  return heavier;
}

double growth_of_map(const scene::Scene& scene) {
  double growth = 1.0;
  for (const scene::Body& body : scene.bodies) {
    if (is_elastic_in_fluid(body)) {
      growth = worse(growth, scene::coupling_growth(*scene.fluid, body).factor);
    }
  }
  return growth;
}

/// The factor of all node masses at which the map of every body is stable.
double critical_factor_of_map(const scene::Scene& scene) {
  constexpr double accuracy = 2e-4;
  double factor = 0.0;
  for (const scene::Body& body : scene.bodies) {
    if (is_elastic_in_fluid(body)) {
      factor =
          worse(factor, scene::critical_node_mass(*scene.fluid, body, accuracy) / body.conditions.node_mass);
    }
  }
  return factor;
}

Observations coupled_spectrum_observations(bool with_least_mass, bool with_transient) {
  Observations all;
  all.records = {{"spectrum",
                  "Eigenvalues of largest magnitude of a step",
                  {{"real", "Re lambda", "1", "real part", {}},
                   {"imaginary", "Im lambda", "1", "imaginary part", {}},
                   {"magnitude", "|lambda|", "1", "growth in a step", {}},
                   {"residual", "", "1", "|G x - lambda x| over |x|, in energies", {}},
                   {"bodies", "", "1", "share of the bodies in the energy of x", {}}}}};
  all.metrics = {{"growth", {}, "1", "largest |lambda| of a step, without known invariants"},
                 {"grows", {}, "1", "1: by more than the resolution"},
                 {"growth_residual", {}, "1", "of the eigenvalue that it is of"},
                 {"growth_resolution", {}, "1", "growth above 1 that might not have been seen"},
                 {"growth_steps", {}, "1", "of the simulation, spent on the spectrum"},
                 {"growth_map", {}, "1", "of the linearised exchange without the fluid's own motion"},
                 {"grew", {}, "1", "1: the kicked run grew"},
                 {"growth_measured", {}, "1", "of the kicked run, in its second half; where it grew"},
                 {"growth_ratio", {}, "1", "measured over that of the spectrum"}};
  if (with_transient) {
    all.records.push_back(
        {"transient",
         "Largest amplification of small states",
         {{"steps", "n", "1", "steps", {}},
          {"amplification", "max |G^n x|/|x|", "1", "lengths being roots of energies", {}}}});
    all.metrics.push_back({"transient_growth", {}, "1", "largest amplification of a state in these steps"});
  }
  if (!with_least_mass) return all;
  all.metrics.insert(all.metrics.end(),
                     {{"critical_node_mass", {}, "M", "least stable node mass, by the spectrum"},
                      {"critical_node_mass_map", {}, "M", "the same without the fluid's own motion"},
                      {"critical_node_mass_measured", {}, "M", "the same of kicked runs"},
                      {"critical_ratio", {}, "1", "measured over that of the spectrum"},
                      {"critical_ratio_map", {}, "1", "measured over that of the map"},
                      {"critical_error", {}, "1", "how far they are apart"}});
  return all;
}

void run_coupled_spectrum(const SpectrumStudy& study, Observations& seen, Progress& progress,
                          engine::Cost& cost) {
  progress.show("spectrum", 0, study.resolution ? 4 : 2);
  const scene::ExactGrowth exact = scene::exact_growth(study.scene, study.search);
  cost.finish("spectrum");
  Record& spectrum = seen.open("spectrum");
  for (const scene::Eigenvalue& e : exact.spectrum) {
    spectrum.append({e.value.real(), e.value.imag(), std::abs(e.value), e.residual, e.bodies});
  }
  const double map = growth_of_map(study.scene);
  seen.set("growth", exact.factor);
  seen.set("grows", exact.grows() ? 1.0 : 0.0);
  seen.set("growth_residual", exact.residual);
  seen.set("growth_resolution", exact.resolution);
  seen.set("growth_steps", static_cast<double>(exact.steps));
  seen.set("growth_map", map);
  if (!study.transient.empty()) {
    const std::vector<double> grown = scene::transient_growth(study.scene, study.transient);
    Record& transient = seen.open("transient");
    for (std::size_t i = 0; i < grown.size(); ++i)
      transient.append({static_cast<double>(study.transient[i]), grown[i]});
    seen.set("transient_growth", *std::max_element(grown.begin(), grown.end()));
    cost.finish("transient growth");
  }
  progress.show("spectrum", 1, study.resolution ? 4 : 2);
  const KickedRun measured = run_kicked(kicked(study.scene, 1.0), study.steps);
  seen.set("grew", measured.grows ? 1.0 : 0.0);
  seen.set("growth_measured", measured.growth);
  seen.set("growth_ratio", measured.growth / exact.factor);
  cost.finish("kicked run");
  if (!study.resolution) return;

  const auto first = std::find_if(study.scene.bodies.begin(), study.scene.bodies.end(), is_elastic_in_fluid);
  const double mass = first->conditions.node_mass;
  const double of_map = critical_factor_of_map(study.scene);
  cost.finish("least mass of the map");
  progress.show("spectrum", 2, 4);
  const double of_spectrum =
      scene::critical_mass_factor(study.scene, of_map, 0.1 * *study.resolution, study.search);
  cost.finish("least mass of the spectrum");
  progress.show("spectrum", 3, 4);
  const double of_runs =
      least_stable([&](double factor) { return run_kicked(kicked(study.scene, factor), study.steps).grows; },
                   of_spectrum, *study.resolution, "kicked runs");
  cost.finish("least mass of the runs");
  seen.set("critical_node_mass", of_spectrum * mass);
  seen.set("critical_node_mass_map", of_map * mass);
  seen.set("critical_node_mass_measured", of_runs * mass);
  seen.set("critical_ratio", of_runs / of_spectrum);
  seen.set("critical_ratio_map", of_runs / of_map);
  seen.set("critical_error", std::abs(of_runs / of_spectrum - 1.0));
}

}  // namespace

engine::Study read_coupled_spectrum(const io::Table& top) {
  const CaseScene read = read_fluid_and_bodies(top);
  for (const CaseBody& body : read.bodies) {
    if (!body.table.has("start")) continue;
    body.table.fail("start", fmt::format("'{}' starts deformed or moving", body.table.text("name")),
                    "the spectrum is that of the scene at rest", "Leave 'start' out");
  }
  if (!read.scene.fluid) {
    throw InputError(top.place(), "the scene has no fluid", "bodies alone neither grow nor decay",
                     "Add [fluid]");
  }
  if (std::none_of(read.scene.bodies.begin(), read.scene.bodies.end(), is_elastic_in_fluid)) {
    throw InputError(top.place(), "no body of the scene moves by its own forces in the fluid",
                     "nothing could grow", "Give a [[body]] without motion a coupling");
  }
  if (read.scene.fluid->storage != fluid::Storage::Double) {
    top.table("fluid").fail("storage", "the populations are float",
                            "their rounding is as large as the perturbations", "Use storage = \"double\"");
  }
  const io::Table t = top.table("coupled_spectrum");
  SpectrumStudy study{.scene = scene::at_rest(read.scene),
                      .search = {.eigenvalues = static_cast<int>(
                                     t.has("eigenvalues") ? t.integer("eigenvalues", 1, 200) : 4)},
                      .steps = t.integer("steps", shortest_kicked_run, 10'000'000),
                      .resolution = t.number_if("resolution"),
                      .transient = {}};
  if (t.has("transient_steps")) {
    constexpr std::int64_t most_numbers = 200'000;  // each costs a step of the scene
    std::int64_t numbers = fluid::Q * study.scene.fluid->grid.count();
    for (const scene::Body& body : study.scene.bodies) numbers += 6 * body.network.node_count();
    if (numbers > most_numbers) {
      t.fail("transient_steps", fmt::format("a state of the scene has {} numbers", numbers),
             fmt::format("each is followed for a step, and {} may be", most_numbers),
             "Use a smaller box, or leave it out");
    }
    for (std::int64_t n = 1, most = t.integer("transient_steps", 1, 4096); n <= most; n *= 2)
      study.transient.push_back(n);
  }
  if (study.resolution && (!(*study.resolution >= 1e-5) || *study.resolution > 0.1)) {
    t.fail("resolution", fmt::format("'resolution' is {}", *study.resolution), "it lies between 1e-5 and 0.1",
           "Use 0.002");
  }
  scene::Scene perturbed = read.scene;
  perturbed.fluid->representation = fluid::Representation::Populations;  // these are what is perturbed
  scene::Plan plan = plan_of(top, perturbed);
  scene::put_in(plan, {"loads", "minute forces that kick the bodies of runs", 0.0, {parts::Kind::Loads}});
  check_places(read);
  return {.plan = std::move(plan),
          .declares = coupled_spectrum_observations(study.resolution.has_value(), !study.transient.empty()),
          .run = std::bind_front(run_coupled_spectrum, study)};
}

}  // namespace veriflex::measures
