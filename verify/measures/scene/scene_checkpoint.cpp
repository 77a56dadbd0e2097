#include <fmt/format.h>

#include <algorithm>

#include "base/error.hpp"
#include "base/mutant.hpp"
#include "base/parts.hpp"
#include "engine/columns.hpp"
#include "measures/scene/scene.hpp"

// A running scene in a file, and out of it. Positions stand there by columns: all x, all y, all z.

namespace veriflex::measures {

namespace {

std::span<const double> numbers(const Positions& X) { return {X.data(), static_cast<std::size_t>(X.size())}; }

/// A file with its checksum may still be of anybody's making: a scene has room for so many numbers alone.
void require(bool sound, const io::Hdf5File& file, const std::string& what) {
  if (sound) return;
  throw InputError({file.name()}, what, "this scene has no place for that",
                   "Run without --resume to begin anew, which replaces it");
}

std::vector<double> numbers(const io::Hdf5File& file, const std::string& path, std::size_t count) {
  std::vector<double> values = file.numbers(path);
  require(values.size() == count, file, fmt::format("{} values in {}, not {}", values.size(), path, count));
  return values;
}

std::int64_t integer(const io::Hdf5File& file, const std::string& path, const std::string& name,
                     std::int64_t least) {
  const std::int64_t value = file.integer(path, name);
  require(value >= least, file, fmt::format("'{}' of {} is {}", name, path, value));
  return value;
}

/// Of so many nodes, or of none where there may be none.
Positions positions(const io::Hdf5File& file, const std::string& path, std::size_t nodes,
                    bool may_be_empty = false) {
  const std::vector<double> values = file.numbers(path);
  require(values.size() == 3 * nodes || (may_be_empty && values.empty()), file,
          fmt::format("{} values in {}, not {}", values.size(), path, 3 * nodes));
  return Eigen::Map<const Positions>(values.data(), std::ssize(values) / 3, 3);
}

/// Lists of so many numbers for each node, one after the other.
template <std::size_t Count>
std::span<const double> numbers(const std::vector<std::array<double, Count>>& nodes) {
  if (nodes.empty()) return {};
  return {nodes.front().data(), Count * nodes.size()};
}

template <std::size_t Count>
std::vector<std::array<double, Count>> by_node(const io::Hdf5File& file, const std::string& path,
                                               std::size_t count) {
  const std::vector<double> values = numbers(file, path, Count * count);
  std::vector<std::array<double, Count>> nodes(count);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(i * Count), Count, nodes[i].begin());
  }
  return nodes;
}

std::string body_path(std::size_t i) { return fmt::format("/simulation/body_{}", i); }

void put(io::Hdf5Image& image, const scene::State& state) {
  image.group("/simulation");
  image.attribute("/simulation", "steps", state.steps);
  if (state.fluid) {
    image.numbers("/simulation/fluid/populations", numbers(state.fluid->populations));
    image.numbers("/simulation/fluid/moments", planted(Mutant::checkpoint_without_moments)
                                                   ? std::span<const double>()
                                                   : numbers(state.fluid->moments));
    image.attribute("/simulation/fluid", "steps", state.fluid->steps);
  }
  for (std::size_t i = 0; i < state.bodies.size(); ++i) {
    const std::string path = body_path(i);
    image.group(path);
    image.attribute(path, "steps", state.bodies[i].steps);
    if (!state.bodies[i].elastic) continue;
    const solid::Integrator::State& elastic = *state.bodies[i].elastic;
    image.numbers(path + "/displacement", numbers(elastic.displacement));
    image.numbers(path + "/velocity", numbers(elastic.velocity));
    image.numbers(path + "/linearised_at", numbers(elastic.linearised_at));
    image.numbers(path + "/stiffest", std::span(&elastic.stiffest, 1));
    image.numbers(path + "/substep", std::span(&elastic.substep, 1));
    image.attribute(path, "substeps", std::int64_t{elastic.substeps});
    image.attribute(path, "own_steps", elastic.steps);
  }
}

scene::State state_of(const io::Hdf5File& file, const scene::Simulation& simulation) {
  scene::State state{integer(file, "/simulation", "steps", 0), {}, {}};
  if (simulation.has_fluid()) {
    const std::string moments = "/simulation/fluid/moments";
    const auto nodes = static_cast<std::size_t>(simulation.fluid().spec().grid.count());
    state.fluid = fluid::State{integer(file, "/simulation/fluid", "steps", 0),
                               by_node<fluid::Q>(file, "/simulation/fluid/populations", nodes),
                               by_node<4>(file, moments, file.numbers(moments).empty() ? 0 : nodes)};
  }
  for (std::size_t i = 0; i < simulation.body_count(); ++i) {
    const std::string path = body_path(i);
    scene::MovingBody::State& body =
        state.bodies.emplace_back(scene::MovingBody::State{integer(file, path, "steps", 0), {}});
    if (!simulation.body(i).is_elastic()) continue;
    const auto nodes = static_cast<std::size_t>(simulation.body(i).positions().rows());
    body.elastic = {positions(file, path + "/displacement", nodes),
                    positions(file, path + "/velocity", nodes),
                    integer(file, path, "own_steps", 0),
                    static_cast<int>(integer(file, path, "substeps", 1)),
                    numbers(file, path + "/stiffest", 1).front(),
                    numbers(file, path + "/substep", 1).front(),
                    positions(file, path + "/linearised_at", nodes, true)};
  }
  return state;
}

void put(io::Hdf5Image& image, const observe::Run::State& state) {
  image.group("/run");
  image.attribute("/run", "checked", state.checked);
  std::vector<std::string> names, dimensions, meanings;
  std::vector<double> values, warned;
  for (const observe::Metric& metric : state.good) {
    names.push_back(metric.name);
    values.push_back(metric.value);
    dimensions.push_back(metric.dimension);
    meanings.push_back(metric.meaning);
  }
  image.texts("/run/good/name", names);
  image.numbers("/run/good/value", values);
  image.texts("/run/good/dimension", dimensions);
  image.texts("/run/good/meaning", meanings);
  for (std::size_t i = 0; i < state.good_nodes.size(); ++i) {
    image.numbers(fmt::format("/run/good_nodes/{}", i), numbers(state.good_nodes[i]));
  }
  image.numbers("/run/load_work", state.load_work);
  for (const auto& pair : state.warned) {
    for (const std::size_t body : pair) warned.push_back(static_cast<double>(body));
  }
  image.numbers("/run/warned", warned);
}

/// `now`: of the run at its start.
observe::Run::State run_of(const io::Hdf5File& file, const scene::Simulation& simulation,
                           const observe::Run::State& now) {
  observe::Run::State state{
      file.integer("/run", "checked"), {}, {}, numbers(file, "/run/load_work", now.load_work.size()), {}};
  state.good = engine::read_metrics(file, "/run/good");
  for (std::size_t i = 0; i < simulation.body_count(); ++i) {
    state.good_nodes.push_back(positions(file, fmt::format("/run/good_nodes/{}", i),
                                         static_cast<std::size_t>(simulation.body(i).positions().rows())));
  }
  const std::vector<double> warned = file.numbers("/run/warned");
  require(warned.size() % 2 == 0, file, fmt::format("{} values in /run/warned, not pairs", warned.size()));
  for (std::size_t i = 0; i < warned.size(); i += 2) {
    state.warned.push_back({engine::count_of(warned[i], file, "/run/warned"),
                            engine::count_of(warned[i + 1], file, "/run/warned")});
  }
  return state;
}

std::string column_path(std::size_t record, std::size_t column) {
  return fmt::format("/records/{}/{}", record, column);
}

}  // namespace

void Running::put_in(io::Hdf5Image& image) const {
  put(image, simulation.state());
  put(image, run.state());
  for (std::size_t r = 0; r < records.size(); ++r) {
    for (std::size_t c = 0; c < records[r].columns.size(); ++c) {
      image.numbers(column_path(r, c), records[r].columns[c].values);
    }
    if (memories[r]) image.numbers(fmt::format("/memories/{}", r), *memories[r]);
  }
  image.texts("/warnings", progress.warnings());
}

void Running::take_from(const io::Hdf5File& file) {
  const parts::Aside to_put_it_back;  // populations of a fluid that is made of moments
  simulation.restore(state_of(file, simulation));
  run.restore(run_of(file, simulation, run.state()));
  for (std::size_t r = 0; r < records.size(); ++r) {
    for (std::size_t c = 0; c < records[r].columns.size(); ++c) {
      std::vector<double> values = file.numbers(column_path(r, c));
      const std::size_t rows = c == 0 ? values.size() : records[r].columns[0].size();
      require(values.size() == rows, file,
              fmt::format("{} values in {}, not {}", values.size(), column_path(r, c), rows));
      records[r].columns[c].values = std::move(values);
    }
    if (memories[r] && !planted(Mutant::memories_not_resumed))
      *memories[r] = numbers(file, fmt::format("/memories/{}", r), memories[r]->size());
  }
  // Those of the start have been said again.
  const std::vector<std::string> warnings = file.texts("/warnings");
  for (std::size_t i = progress.warnings().size(); i < warnings.size(); ++i) progress.warn(warnings[i]);
}

}  // namespace veriflex::measures
