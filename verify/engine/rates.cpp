#include "engine/rates.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "engine/result.hpp"
#include "io/file.hpp"
#include "scene/coupling_stability.hpp"
#include "scene/simulation.hpp"

namespace veriflex::engine {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr double least_seconds = 0.15;  // of a measurement
// Nodes along the axes: the moments of the small box fit the second-level cache, the populations of the large
// one no cache.
constexpr std::array<std::array<std::int64_t, 3>, 2> boxes{{{32, 24, 24}, {64, 96, 96}}};
constexpr std::array representations{fluid::Representation::Populations, fluid::Representation::Moments};
constexpr std::array storages{fluid::Storage::Double, fluid::Storage::Float};

/// Seconds of a step, of so many that are made in one call: the least of some measurements, since whatever
/// disturbs one makes it longer.
double seconds_of_a_step(const scene::Scene& scene, std::int64_t at_once = 1) {
  scene::Simulation simulation(scene);
  const auto advance = [&] {
    for (std::int64_t made = 0; made < std::max<std::int64_t>(4, at_once); made += at_once)
      simulation.advance(at_once);
  };
  advance();
  double least = std::numeric_limits<double>::infinity();
  for (int measurement = 0; measurement < 3; ++measurement) {
    const auto start = std::chrono::steady_clock::now();
    double spent = 0.0;
    const std::int64_t first = simulation.steps();
    while (spent < least_seconds / 3.0) {
      advance();
      spent = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    }
    least = std::min(least, spent / static_cast<double>(simulation.steps() - first));
  }
  return least;
}

scene::Body filament(double angle_stiffness) {
  scene::Body body{.material = {bond::Harmonic{0.26, 1.0}, angle_stiffness},
                   .network = solid::rod_lattice({2.5, 41, 1.0})};
  if (angle_stiffness > 0.0) solid::add_angles(body.network);
  body.substeps.count = 4;
  body.place = {16.0, 16.0, 6.0};
  return body;
}

Rates measured(int threads) {
  omp_set_num_threads(threads);
  Rates rates;
  for (std::size_t r = 0; r < 2; ++r) {
    for (std::size_t s = 0; s < 2; ++s) {
      for (std::size_t b = 0; b < 2; ++b) {
        const fluid::Spec spec{.grid = {boxes[b]},
                               .relaxation_time = r == 0 ? 0.9 : 1.0,
                               .storage = storages[s],
                               .representation = representations[r]};
        rates.nodes[r][s][b] = static_cast<double>(spec.grid.count()) / seconds_of_a_step({.fluid = spec});
      }
    }
  }
  for (std::size_t s = 0; s < 2; ++s) {
    const fluid::Spec spec{.grid = {boxes[1]}, .relaxation_time = 0.9, .storage = storages[s]};
    rates.at_once[s] = static_cast<double>(spec.grid.count()) /
                       seconds_of_a_step({.fluid = spec}, fluid::make_fluid(spec)->steps_at_once());
  }
  const scene::Body bare = filament(0.0), body = filament(0.025);
  const double of_bonds = seconds_of_a_step({.bodies = {bare}});
  const double of_body = seconds_of_a_step({.bodies = {body}});
  rates.bonds = 4.0 * static_cast<double>(bare.network.bonds.size()) / of_bonds;
  rates.angles = 4.0 * static_cast<double>(body.network.angles.size()) / std::max(of_body - of_bonds, 1e-12);

  scene::Scene coupled{.fluid = fluid::Spec{.grid = {{32, 32, 56}}, .relaxation_time = 0.9},
                       .bodies = {body}};
  const double of_fluid = seconds_of_a_step({.fluid = coupled.fluid});
  coupled.bodies[0].coupling.emplace();
  const auto markers = static_cast<double>(expected_work(coupled, 1)->counts.marker_interpolations);
  rates.markers = markers / std::max(seconds_of_a_step(coupled) - of_fluid - of_body, 1e-12);
  const auto start = std::chrono::steady_clock::now();
  scene::coupling_growth(*coupled.fluid, coupled.bodies[0]);
  rates.checked_nodes = static_cast<double>(body.network.node_count()) /
                        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return rates;
}

/// One list, so that a file is read as it was written.
std::vector<double*> values(Rates& rates) {
  std::vector<double*> all{&rates.at_once[0], &rates.at_once[1], &rates.bonds,
                           &rates.angles,     &rates.markers,    &rates.checked_nodes};
  for (auto& of_representation : rates.nodes) {
    for (auto& of_storage : of_representation) {
      for (double& rate : of_storage) all.push_back(&rate);
    }
  }
  return all;
}

std::optional<Rates> kept(const fs::path& file) {
  try {
    const std::vector<double> numbers = Json::parse(io::read_file(file)).get<std::vector<double>>();
    Rates rates;
    const std::vector<double*> all = values(rates);
    if (numbers.size() != all.size()) return std::nullopt;
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (!(numbers[i] > 0.0)) return std::nullopt;
      *all[i] = numbers[i];
    }
    return rates;
  } catch (const std::exception&) {  // there is none, or it is no list of numbers: measured again
    return std::nullopt;
  }
}

/// Empty where the environment names no place for it.
fs::path cache_folder() {
  const auto set = [](const char* name) {
    const char* value = std::getenv(name);
    return fs::path(value == nullptr ? "" : value);
  };
  if (const fs::path given = set("XDG_CACHE_HOME"); !given.empty()) return given / "veriflex";
  return set("HOME").empty() ? fs::path() : set("HOME") / ".cache" / "veriflex";
}

// Whether the fluid makes several steps in one call.
bool is_made_at_once(const scene::ExpectedWork& work) {
  const bool is_alone = work.counts.bond_evaluations == 0 && work.counts.marker_interpolations == 0;
  return is_alone && fluid::is_made_row_by_row(*work.fluid) &&
         fluid::representation_of(*work.fluid) == fluid::Representation::Populations;
}

}  // namespace

Rates rates(int threads) {
  const fs::path cache = cache_folder();
  const std::string machine = io::sha256(provenance(threads).machine + program()).substr(0, 16);
  const fs::path file = cache / fmt::format("rates-{}-{}.json", machine, threads);
  if (!cache.empty()) {
    if (const std::optional<Rates> known = kept(file)) return *known;
  }
  Rates now = measured(threads);
  if (cache.empty()) return now;
  try {
    Json numbers;
    for (const double* value : values(now)) numbers.push_back(*value);
    fs::create_directories(cache);
    io::write_file(file, numbers.dump(1) + "\n");
  } catch (const std::exception&) {
    // It is measured again next time.
  }
  return now;
}

double seconds_of(const scene::ExpectedWork& work, const Rates& rates) {
  const auto count = [](std::uint64_t n) { return static_cast<double>(n); };
  double seconds = count(work.counts.bond_evaluations) / rates.bonds +
                   count(work.counts.angle_evaluations) / rates.angles +
                   count(work.counts.marker_interpolations) / rates.markers +
                   work.checked_nodes / rates.checked_nodes;
  if (!work.fluid) return seconds;
  auto by_size = rates.nodes[fluid::representation_of(*work.fluid) == fluid::Representation::Moments]
                            [work.fluid->storage == fluid::Storage::Float];
  if (is_made_at_once(work)) by_size[1] = rates.at_once[work.fluid->storage == fluid::Storage::Float];
  // Between the two boxes by the logarithm of their nodes.
  const auto size = [](const std::array<std::int64_t, 3>& box) {
    return std::log(static_cast<double>(box[0] * box[1] * box[2]));
  };
  const double share = std::clamp(
      (size(work.fluid->grid.size) - size(boxes[0])) / (size(boxes[1]) - size(boxes[0])), 0.0, 1.0);
  return seconds + count(work.counts.node_updates) / (by_size[0] + share * (by_size[1] - by_size[0]));
}

}  // namespace veriflex::engine
