#include <fmt/format.h>

#include <algorithm>

#include "base/parts.hpp"
#include "measures/scene/scene.hpp"

// A running scene in a file, and out of it. Positions stand there by columns: all x, all y, all z.

namespace veriflex::measures {

namespace {

std::span<const double> numbers(const Positions& X) { return {X.data(), static_cast<std::size_t>(X.size())}; }

Positions positions(const io::Hdf5File& file, const std::string& path) {
  const std::vector<double> values = file.numbers(path);
  return Eigen::Map<const Positions>(values.data(), std::ssize(values) / 3, 3);
}

/// Lists of so many numbers for each node, one after the other.
template <std::size_t Count>
std::span<const double> numbers(const std::vector<std::array<double, Count>>& nodes) {
  if (nodes.empty()) return {};
  return {nodes.front().data(), Count * nodes.size()};
}

template <std::size_t Count>
std::vector<std::array<double, Count>> by_node(const io::Hdf5File& file, const std::string& path) {
  const std::vector<double> values = file.numbers(path);
  std::vector<std::array<double, Count>> nodes(values.size() / Count);
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
    image.numbers("/simulation/fluid/moments", numbers(state.fluid->moments));
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
  scene::State state{file.integer("/simulation", "steps"), {}, {}};
  if (simulation.has_fluid()) {
    state.fluid = fluid::State{file.integer("/simulation/fluid", "steps"),
                               by_node<fluid::Q>(file, "/simulation/fluid/populations"),
                               by_node<4>(file, "/simulation/fluid/moments")};
  }
  for (std::size_t i = 0; i < simulation.body_count(); ++i) {
    const std::string path = body_path(i);
    scene::MovingBody::State& body =
        state.bodies.emplace_back(scene::MovingBody::State{file.integer(path, "steps"), {}});
    if (!simulation.body(i).is_elastic()) continue;
    body.elastic = {
        positions(file, path + "/displacement"),  positions(file, path + "/velocity"),
        file.integer(path, "own_steps"),          static_cast<int>(file.integer(path, "substeps")),
        file.numbers(path + "/stiffest").front(), file.numbers(path + "/substep").front(),
        positions(file, path + "/linearised_at")};
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

observe::Run::State run_of(const io::Hdf5File& file, std::size_t bodies) {
  observe::Run::State state{file.integer("/run", "checked"), {}, {}, file.numbers("/run/load_work"), {}};
  const std::vector<std::string> names = file.texts("/run/good/name");
  const std::vector<double> values = file.numbers("/run/good/value");
  const std::vector<std::string> dimensions = file.texts("/run/good/dimension");
  const std::vector<std::string> meanings = file.texts("/run/good/meaning");
  for (std::size_t i = 0; i < names.size(); ++i) {
    state.good.push_back({names[i], values[i], dimensions[i], meanings[i]});
  }
  for (std::size_t i = 0; i < bodies; ++i) {
    state.good_nodes.push_back(positions(file, fmt::format("/run/good_nodes/{}", i)));
  }
  const std::vector<double> warned = file.numbers("/run/warned");
  for (std::size_t i = 0; i + 1 < warned.size(); i += 2) {
    state.warned.push_back({static_cast<std::size_t>(warned[i]), static_cast<std::size_t>(warned[i + 1])});
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
  run.restore(run_of(file, simulation.body_count()));
  for (std::size_t r = 0; r < records.size(); ++r) {
    for (std::size_t c = 0; c < records[r].columns.size(); ++c) {
      records[r].columns[c].values = file.numbers(column_path(r, c));
    }
    if (memories[r]) *memories[r] = file.numbers(fmt::format("/memories/{}", r));
  }
  // Those of the start have been said again.
  const std::vector<std::string> warnings = file.texts("/warnings");
  for (std::size_t i = progress.warnings().size(); i < warnings.size(); ++i) progress.warn(warnings[i]);
}

}  // namespace veriflex::measures
