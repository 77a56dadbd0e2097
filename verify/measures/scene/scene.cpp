#include "measures/scene/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <memory>
#include <optional>
#include <span>

#include "base/error.hpp"
#include "base/stop.hpp"
#include "engine/check_coupling.hpp"
#include "engine/check_place.hpp"
#include "engine/checkpoint.hpp"
#include "engine/read_scene.hpp"
#include "engine/units.hpp"
#include "measures/drivers.hpp"
#include "scene/contact.hpp"
#include "scene/markers.hpp"

// Any scene: a fluid, bodies in it or without one, and what is observed of them while it runs.

namespace veriflex::measures {

namespace {

constexpr auto max_steps = static_cast<std::int64_t>(engine::max_steps);

struct SceneStudy : CaseScene {
  std::vector<Observation> observations;
  observe::MonitorSpec monitor;
  std::int64_t steps;
  std::optional<double> checkpoint;  // seconds from one to the next

  bool has_elastic_coupling() const {
    return std::any_of(scene.bodies.begin(), scene.bodies.end(),
                       [](const scene::Body& body) { return body.coupling && !body.motion; });
  }
};

/// Of the drives and oscillations, which must agree; 0 without one  [T].
double period_of(const CaseScene& read) {
  double period = 0.0;
  for (std::size_t i = 0; i < read.bodies.size(); ++i) {
    const CaseBody& body = read.bodies[i];
    if (!body.period) continue;
    if (period != 0.0 && *body.period != period) {
      throw InputError(body.table.place(),
                       fmt::format("{} has a period of {}, a body before it one of {}",
                                   read.scene.bodies[i].name, *body.period, period),
                       "phases and periods of a run are those of one motion", "Use one period");
    }
    period = *body.period;
  }
  return period;
}

std::int64_t read_steps(const io::Table& t, double period) {
  if (t.has("steps") == t.has("periods")) {
    throw InputError(t.place(), t.has("steps") ? "both steps and periods" : "neither steps nor periods",
                     "either says how long the run is", "Give one");
  }
  if (t.has("steps")) return t.integer("steps", 1, max_steps);
  const std::int64_t periods = t.integer("periods", 1, max_steps);
  if (period == 0.0) {
    t.fail("periods", "periods of nothing", "no body of the scene is driven or oscillates",
           "Give steps instead");
  }
  return engine::whole_steps(static_cast<double>(periods) * period, 1.0, "the run takes", t.place("periods"));
}

std::optional<double> read_checkpoint(const io::Table& t) {
  const std::optional<double> seconds = t.number_if("checkpoint");
  if (seconds && !(*seconds > 0.0)) {
    t.fail("checkpoint", fmt::format("'checkpoint' is {}", *seconds),
           "it is the time from one checkpoint to the next, in seconds", "Give for example 600");
  }
  return seconds;
}

/// What [monitor] says of bodies.
observe::BodyLimits read_body_limits(const io::Table& top, const CaseScene& read) {
  observe::BodyLimits limits;
  if (!top.has("monitor")) return limits;
  const io::Table t = top.table("monitor");
  limits.physical = t.flag("physical", false);
  if (t.has("buckled")) {
    limits.buckled = t.number("buckled");
    if (!(limits.buckled > 0.0) || limits.buckled >= 1.0) {
      t.fail("buckled", fmt::format("'buckled' is {}", limits.buckled),
             "it is a part of a column's length, between 0 and 1", "Give for example 0.05");
    }
    for (const scene::Body& body : read.scene.bodies) {
      const auto along = body.network.rest.col(body.axis);
      if (along.maxCoeff() - along.minCoeff() > 1.5 * body.network.spacing) continue;
      t.fail("buckled", fmt::format("'buckled' is set, and '{}' has fewer than three sections", body.name),
             "it has no middle that could give way", "Leave it out");
    }
  }
  if (!t.has("energy_growth")) return limits;
  limits.energy_growth = t.number("energy_growth");
  if (!(limits.energy_growth > 0.0)) {
    t.fail("energy_growth", fmt::format("'energy_growth' is {}", limits.energy_growth),
           "no motion keeps its energy to the last digit", "Give for example 100");
  }
  for (std::size_t i = 0; i < read.bodies.size(); ++i) {
    const scene::Body& body = read.scene.bodies[i];
    const bool has_energy = read.bodies[i].table.has("start") || body.conditions.load.size() > 0;
    if (!body.motion && !body.coupling && !body.conditions.drive && has_energy) continue;
    t.fail("energy_growth",
           fmt::format("'energy_growth' is set, and the energy of '{}' is not its own", body.name),
           "it is kept only by a body that starts deformed or moving or bears a dead load, and that nothing "
           "drives and no fluid meets",
           "Leave it out");
  }
  return limits;
}

Place place_of(const CaseBody& body) { return body.table.place("place"); }

/// Refuses a body that has no room where it stands.
void check_body(const scene::Body& body, const CaseBody& said, const fluid::Spec& fluid) {
  const Positions X = scene::markers_at_rest(body);
  engine::check_supports(fluid, body.coupling->delta, X, said.stroke, body.name, place_of(said));
  const Vec3 extent = X.colwise().maxCoeff() - X.colwise().minCoeff();
  engine::check_images(fluid, body.coupling->delta, extent, said.stroke, body.name, place_of(said));
}

/// Refuses bodies in one fluid that stand in each other; `b` stands there.
void check_pair(const scene::Body& a, const scene::Body& b, const Place& there, const fluid::Spec& fluid) {
  constexpr double nearest = 1.0;  // [L]
  const auto nodes = [](const scene::Body& body) {
    return Positions(body.network.rest.rowwise() + body.place.transpose());
  };
  const auto met = scene::nearest_within(nearest, nodes(a), nodes(b), fluid.grid, closed(fluid));
  if (!met) return;
  throw InputError(there, fmt::format("{} stands in {}", b.name, a.name),
                   fmt::format("their nodes {} and {} are {:.3g} spacings apart; nothing keeps bodies from "
                               "passing through each other",
                               met->second, met->first, met->distance),
                   "Move one of them away by a spacing or more");
}

/// Makes the steps that are left, and leaves a checkpoint behind when one is due or the run is asked to stop.
/// None after the last step: what that one exchanged, which is still looked at, is in no state.
void advance_with_checkpoints(const SceneStudy& study, Running& running, engine::Checkpoints& checkpoints,
                              engine::Cost& cost) {
  if (checkpoints.earlier() != nullptr) {
    running.take_from(*checkpoints.earlier());
    checkpoints.resumed(running.simulation.steps(), cost);
  }
  while (running.simulation.steps() < study.steps) {
    {
      const stop::Held whole_step;
      const std::int64_t left = study.steps - running.simulation.steps();
      running.run.advance(std::min(left, running.simulation.steps_at_once()), study.steps);
    }
    const bool is_last = running.simulation.steps() == study.steps;
    if (!is_last && (stop::asked() || checkpoints.is_due(*study.checkpoint))) {
      checkpoints.write(running.simulation.steps(), [&](io::Hdf5Image& image) { running.put_in(image); });
    }
  }
}

void run_scene(const SceneStudy& study, observe::Observations& seen, Progress& progress, engine::Cost& cost,
               engine::Checkpoints* checkpoints) {
  if (study.has_elastic_coupling()) {
    seen.metrics.push_back(
        {"coupling_growth", 0.0, "1",
         "largest factor a step of the linearised coupling, of each body and of bodies that share nodes of "
         "the fluid, without the fluid's own motion; up to 1 is stable"});
    for (std::size_t i = 0; i < study.bodies.size(); ++i) {
      const scene::Body& body = study.scene.bodies[i];
      if (!body.coupling || body.motion) continue;
      engine::check_coupling(*study.scene.fluid, body, body.name, study.bodies[i].table.place("node_mass"),
                             seen.metrics.back().value, progress);
    }
    for (const std::vector<std::size_t>& together : scene::bodies_that_share_nodes(study.scene)) {
      if (together.size() == 1) continue;
      std::vector<scene::Body> bodies;
      for (const std::size_t i : together) bodies.push_back(study.scene.bodies[i]);
      engine::check_common_coupling(*study.scene.fluid, bodies,
                                    study.bodies[together.front()].table.place("coupling"),
                                    seen.metrics.back().value, progress);
    }
    cost.finish("stability of the coupling");
  }
  const std::size_t first = seen.records.size();
  std::vector<observe::Observer> observers;
  std::vector<std::shared_ptr<std::vector<double>>> memories;
  for (const Observation& observation : study.observations) {
    memories.push_back(add_observers(observation, study.scene, seen.records, seen.records.size(), observers));
    seen.records.push_back(empty_record(observation, study.scene));
  }
  scene::Simulation simulation(study.scene);
  observe::Run run(simulation, study.monitor, observers, "", progress);
  if (checkpoints != nullptr) {
    Running running{simulation, run, std::span(seen.records).subspan(first), memories, progress};
    advance_with_checkpoints(study, running, *checkpoints, cost);
  } else {
    run.advance(study.steps, study.steps);
  }
  run.finish();
  if (simulation.has_fluid()) {
    const scene::Simulation::Seconds& spent = simulation.seconds();
    cost.finish("run", {{"fluid", spent.fluid.wall, spent.fluid.cpu},
                        {"coupling", spent.coupling.wall, spent.coupling.cpu},
                        {"solid", spent.solid.wall, spent.solid.cpu}});
  } else {
    cost.finish("run");
  }
  for (std::size_t i = 0; i < study.observations.size(); ++i) {
    const std::vector<observe::Metric> metrics = metrics_of(study.observations[i], seen.records[first + i]);
    seen.metrics.insert(seen.metrics.end(), metrics.begin(), metrics.end());
  }
}

}  // namespace

void check_places(const CaseScene& read) {
  if (!read.scene.fluid) return;
  const std::vector<scene::Body>& bodies = read.scene.bodies;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (!bodies[i].coupling) continue;
    check_body(bodies[i], read.bodies[i], *read.scene.fluid);
    for (std::size_t j = 0; j < i; ++j) {
      if (bodies[j].coupling) check_pair(bodies[j], bodies[i], place_of(read.bodies[i]), *read.scene.fluid);
    }
  }
}

scene::Plan plan_of(const io::Table& top, const scene::Scene& scene) {
  try {
    return scene::plan_scene(scene);
  } catch (const BadParameter& bad) {  // of the fluid: bodies are looked at before they are built
    top.table("fluid").fail("nodes", bad.problem, bad.why, bad.suggestion);
  }
}

bool is_plain_name(const std::string& name) {
  return std::all_of(name.begin(), name.end(),
                     [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '-'; });
}

std::vector<std::int32_t> read_node_list(const io::Table& table, const std::string& key, Eigen::Index count) {
  std::vector<std::int32_t> nodes;
  for (const std::int64_t node : table.integers(key)) {
    if (node < 0 || node >= count) {
      table.fail(key, fmt::format("'{}' lists node {}", key, node),
                 fmt::format("the body has nodes 0 to {}", count - 1), "List the body's own nodes");
    }
    nodes.push_back(static_cast<std::int32_t>(node));
  }
  return nodes;
}

CaseScene read_fluid_and_bodies(const io::Table& top) {
  CaseScene read;
  if (top.has("fluid")) {
    read.scene.fluid = engine::read_fluid(top);
    read.scene.initial_flow = read_initial_flow(top, *read.scene.fluid);
  }
  for (const io::Table& table : top.tables("body")) {
    scene::Body body;
    read.bodies.push_back(read_body(table, read.scene.fluid.has_value(), body));
    const std::string& name = body.name;
    for (const scene::Body& other : read.scene.bodies) {
      if (other.name == name) {
        table.fail("name", fmt::format("two bodies are called '{}'", name), "columns are called after them",
                   "Give each a name of its own");
      }
    }
    read.scene.bodies.push_back(std::move(body));
  }
  if (!read.scene.fluid && read.scene.bodies.empty()) {
    throw InputError(top.place(), "the scene is empty", "it has neither [fluid] nor [[body]]", "Add one");
  }
  for (std::size_t i = 0; i < read.bodies.size(); ++i) {
    const scene::Body& body = read.scene.bodies[i];
    if (body.motion && !body.coupling) {
      read.bodies[i].table.fail("motion",
                                fmt::format("the motion of {} is given, and it meets no fluid", body.name),
                                "nothing would come of it", "Add [fluid] and a coupling");
    }
  }
  return read;
}

engine::Study read_scene(const io::Table& top) {
  const observe::MonitorSpec monitor = engine::read_monitor(top);
  SceneStudy study{read_fluid_and_bodies(top), {}, monitor, 0, {}};
  study.monitor.bodies = read_body_limits(top, study);
  const double period = period_of(study);
  study.steps = read_steps(top.table("run"), period);
  study.checkpoint = read_checkpoint(top.table("run"));
  scene::Plan plan = plan_of(top, study.scene);
  check_places(study);
  study.observations = read_observations(top, study.scene, period, study.steps);
  engine::read_units(top);  // for `veriflex units`; nothing depends on it here
  std::vector<std::string> measures;
  if (study.has_elastic_coupling()) measures.emplace_back("coupling_growth");
  for (const Observation& observation : study.observations) {
    const std::vector<std::string> more = measures_of(observation, study.scene);
    measures.insert(measures.end(), more.begin(), more.end());
  }
  // One copy for all that is done with it: bodies may be large.
  const auto shared = std::make_shared<const SceneStudy>(std::move(study));
  engine::Study made{
      .plan = std::move(plan),
      .measures = measures,
      .run = [shared](observe::Observations& seen, Progress& progress,
                      engine::Cost& cost) { run_scene(*shared, seen, progress, cost, nullptr); },
      .expects =
          [shared] {
            const auto work = scene::expected_work(shared->scene, shared->steps);
            return work ? std::vector{*work} : std::vector<scene::ExpectedWork>{};
          },
      .offers =
          [shared] {
            return scene::offers(shared->scene,
                                 [](std::size_t i) { return fmt::format("body.{}.substeps", i); });
          }};
  if (shared->checkpoint) {
    made.run_with_checkpoints = [shared](observe::Observations& seen, Progress& progress, engine::Cost& cost,
                                         engine::Checkpoints& checkpoints) {
      run_scene(*shared, seen, progress, cost, &checkpoints);
    };
  }
  return made;
}

}  // namespace veriflex::measures
