#include "engine/rates.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/say.hpp"
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
constexpr std::array<std::int64_t, 3> smallest_box{4, 4, 4};
constexpr std::array representations{fluid::Representation::Populations, fluid::Representation::Moments};
constexpr std::array storages{fluid::Storage::Double, fluid::Storage::Float};

/// Wall seconds since it was made, and whether this thread had the processor for most of them: it has not
/// where other programs keep the machine busy.
class Stopwatch {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  bool was_disturbed() const {
    constexpr double least_share = 0.7;
    return on_processor() - on_processor_ < least_share * seconds();
  }

 private:
  static double on_processor() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
  }

  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  double on_processor_ = on_processor();
};

/// Seconds of a step, of so many that are made in one call: the least of some measurements, since whatever
/// disturbs one makes it longer. Sets `disturbed` where that one was.
double seconds_of_a_step(bool& disturbed, const scene::Scene& scene, std::int64_t at_once = 1,
                         double at_least = least_seconds) {
  scene::Simulation simulation(scene);
  const auto advance = [&] {
    for (std::int64_t made = 0; made < std::max<std::int64_t>(4, at_once); made += at_once)
      simulation.advance(at_once);
  };
  advance();
  double least = std::numeric_limits<double>::infinity();
  bool least_was_disturbed = false;
  for (int measurement = 0; measurement < 3; ++measurement) {
    const Stopwatch watch;
    const std::int64_t first = simulation.steps();
    while (watch.seconds() < at_least / 3.0) advance();
    const bool is_disturbed = watch.was_disturbed();
    const double of_step = watch.seconds() / static_cast<double>(simulation.steps() - first);
    if (of_step < least) {
      least = of_step;
      least_was_disturbed = is_disturbed;
    }
  }
  disturbed = disturbed || least_was_disturbed;
  return least;
}

scene::Body filament(double angle_stiffness, std::int64_t sections = 41) {
  scene::Body body{.material = {bond::Harmonic{0.26, 1.0}, angle_stiffness},
                   .network = solid::rod_lattice({2.5, sections, 1.0})};
  if (angle_stiffness > 0.0) solid::add_angles(body.network);
  body.substeps.count = 4;
  body.place = {16.0, 16.0, 6.0};
  return body;
}

Rates measured(int threads, bool& disturbed) {
  omp_set_num_threads(threads);
  Rates rates;
  for (std::size_t r = 0; r < 2; ++r) {
    fluid::Spec spec{
        .grid = {smallest_box}, .relaxation_time = r == 0 ? 0.9 : 1.0, .representation = representations[r]};
    rates.step[r] = seconds_of_a_step(disturbed, {.fluid = spec});
    for (std::size_t s = 0; s < 2; ++s) {
      spec.storage = storages[s];
      for (std::size_t b = 0; b < 2; ++b) {
        spec.grid.size = boxes[b];
        rates.nodes[r][s][b] = static_cast<double>(spec.grid.count()) /
                               std::max(seconds_of_a_step(disturbed, {.fluid = spec}) - rates.step[r], 1e-12);
      }
    }
  }
  for (std::size_t s = 0; s < 2; ++s) {
    const fluid::Spec spec{.grid = {boxes[1]}, .relaxation_time = 0.9, .storage = storages[s]};
    rates.at_once[s] =
        static_cast<double>(spec.grid.count()) /
        seconds_of_a_step(disturbed, {.fluid = spec}, fluid::make_fluid(spec)->steps_at_once());
  }
  const scene::Body bare = filament(0.0), body = filament(0.025);
  const double of_bonds = seconds_of_a_step(disturbed, {.bodies = {bare}});
  const double of_body = seconds_of_a_step(disturbed, {.bodies = {body}});
  rates.bonds = 4.0 * static_cast<double>(bare.network.bonds.size()) / of_bonds;
  rates.angles = 4.0 * static_cast<double>(body.network.angles.size()) / std::max(of_body - of_bonds, 1e-12);

  for (std::size_t r = 0; r < 2; ++r) {
    scene::Scene coupled{.fluid = fluid::Spec{.grid = {{32, 32, 56}},
                                              .relaxation_time = r == 0 ? 0.9 : 1.0,
                                              .representation = representations[r]},
                         .bodies = {body}};
    const double of_fluid = seconds_of_a_step(disturbed, {.fluid = coupled.fluid});
    coupled.bodies[0].coupling.emplace();
    const auto markers = static_cast<double>(expected_work(coupled, 1)->counts.marker_interpolations);
    rates.markers[r] = markers / std::max(seconds_of_a_step(disturbed, coupled) - of_fluid - of_body, 1e-12);
  }
  // A shorter one where the force follows the sub-steps, which takes twenty times as long.
  for (const bool subcycled : {false, true}) {
    scene::Body checked = filament(0.025, subcycled ? 11 : 51);
    checked.coupling.emplace();
    checked.coupling->subcycled = subcycled;
    const auto nodes = static_cast<double>(checked.network.node_count());
    const fluid::Spec around{.grid = {{32, 32, 56}}, .relaxation_time = 0.9};
    const Stopwatch watch;
    scene::coupling_growth(around, checked);
    disturbed = disturbed || watch.was_disturbed();
    const double seconds = watch.seconds();
    (subcycled ? rates.checked_substeps : rates.checked_nodes) =
        nodes * (subcycled ? checked.substeps.count : 1) / seconds;
  }
  return rates;
}

/// One list, so that a file is read as it was written.
std::vector<double*> values(Rates& rates) {
  std::vector<double*> all{&rates.step[0],       &rates.step[1],         &rates.at_once[0], &rates.at_once[1],
                           &rates.bonds,         &rates.angles,          &rates.markers[0], &rates.markers[1],
                           &rates.checked_nodes, &rates.checked_substeps};
  for (auto& of_representation : rates.nodes) {
    for (auto& of_storage : of_representation) {
      for (double& rate : of_storage) all.push_back(&rate);
    }
  }
  return all;
}

// Nothing where there are not so many positive numbers.
std::optional<std::vector<double>> kept(const fs::path& file, std::size_t count) {
  try {
    std::vector<double> numbers = Json::parse(io::read_file(file)).get<std::vector<double>>();
    const bool are_rates = numbers.size() == count &&
                           std::all_of(numbers.begin(), numbers.end(), [](double n) { return n > 0.0; });
    return are_rates ? std::optional(std::move(numbers)) : std::nullopt;
  } catch (const std::exception&) {  // there is none, or it is no list of numbers
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

bool has_moments(const scene::ExpectedWork& work) {
  return work.fluid && fluid::representation_of(*work.fluid) == fluid::Representation::Moments;
}

// Whether the fluid makes several steps in one call, beside a body too.
bool is_made_at_once(const scene::ExpectedWork& work) {
  return fluid::is_made_row_by_row(*work.fluid) && !has_moments(work);
}

fs::path file_of(const std::string& what, int threads) {
  const fs::path cache = cache_folder();
  if (cache.empty()) return {};
  const std::string machine = io::sha256(provenance(threads).machine + program()).substr(0, 16);
  return cache / fmt::format("{}-{}-{}.json", what, machine, threads);
}

bool is_recent(const fs::path& file) {
  using namespace std::chrono_literals;
  std::error_code none;
  const fs::file_time_type written = fs::last_write_time(file, none);
  return !none && fs::file_time_type::clock::now() - written < 10min;
}

// Numbers that are measured once and kept in that file, unless it has no name. What a busy machine shows is
// not what it can: that is kept beside it, and good for ten minutes.
std::vector<double> kept_or(const fs::path& file, std::size_t count,
                            const std::function<std::vector<double>(bool& disturbed)>& measure) {
  const auto tell = [] {
    static bool told = false;
    if (!std::exchange(told, true))
      complain("other programs keep this machine busy: times are estimated from how fast it is beside them");
  };
  if (!file.empty()) {
    if (const auto known = kept(file, count)) return *known;
  }
  const fs::path while_busy = file.empty() ? file : fs::path(file).replace_extension(".busy.json");
  if (is_recent(while_busy)) {
    if (const auto known = kept(while_busy, count)) {
      tell();
      return *known;
    }
  }
  bool disturbed = false;
  std::vector<double> now = measure(disturbed);
  if (disturbed) tell();
  if (file.empty()) return now;
  try {
    fs::create_directories(file.parent_path());
    io::write_file(disturbed ? while_busy : file, Json(now).dump(1) + "\n");
  } catch (const std::exception&) {
    // It is measured again next time.
  }
  return now;
}

// The box of that work, cut off along z where it is larger than a cache can hold many times over. An obstacle
// is left out: only that steps are made one by one with it counts.
double rate_of_box(const scene::ExpectedWork& work, int threads) {
  constexpr std::int64_t most_nodes = 1 << 21;
  fluid::Spec spec = *work.fluid;
  auto& size = spec.grid.size;
  size[2] = std::min(size[2], std::max<std::int64_t>(8, most_nodes / (size[0] * size[1])));
  spec.obstacle.clear();
  std::string name = fmt::format(
      "{}x{}x{}-{}-{}-{}", size[0], size[1], size[2], has_moments(work) ? "moments" : "populations",
      spec.storage == fluid::Storage::Float ? "float" : "double", spec.is_forced() ? "forced" : "free");
  for (const auto& walls : spec.walls) name += walls ? "-walls" : "-periodic";
  return kept_or(file_of(name, threads), 1,
                 [&](bool& disturbed) {
                   omp_set_num_threads(threads);
                   const std::int64_t at_once =
                       is_made_at_once(work) ? fluid::make_fluid(spec)->steps_at_once() : 1;
                   return std::vector{static_cast<double>(spec.grid.count()) /
                                      seconds_of_a_step(disturbed, {.fluid = spec}, at_once, 0.06)};
                 })
      .front();
}

}  // namespace

Rates rates(int threads) {
  Rates found;
  const std::vector<double*> all = values(found);
  const std::vector<double> numbers = kept_or(file_of("rates", threads), all.size(), [&](bool& disturbed) {
    Rates now = measured(threads, disturbed);
    std::vector<double> list;
    for (const double* value : values(now)) list.push_back(*value);
    return list;
  });
  for (std::size_t i = 0; i < all.size(); ++i) *all[i] = numbers[i];
  return found;
}

Rates rates_for(const scene::ExpectedWork& work, int threads) {
  constexpr double worth_measuring = 0.05;  // [s]
  Rates found = rates(threads);
  scene::ExpectedWork of_fluid{.fluid = work.fluid, .counts = {}};
  of_fluid.counts.node_updates = work.counts.node_updates;
  if (work.fluid && seconds_of(of_fluid, found) >= worth_measuring) found.of_box = rate_of_box(work, threads);
  return found;
}

double seconds_of(const scene::ExpectedWork& work, const Rates& rates) {
  const auto count = [](std::uint64_t n) { return static_cast<double>(n); };
  double seconds = count(work.counts.bond_evaluations) / rates.bonds +
                   count(work.counts.angle_evaluations) / rates.angles +
                   count(work.counts.marker_interpolations) / rates.markers[has_moments(work)] +
                   work.checked_nodes / rates.checked_nodes + work.checked_substeps / rates.checked_substeps;
  if (!work.fluid) return seconds;
  if (rates.of_box) return seconds + count(work.counts.node_updates) / *rates.of_box;
  auto by_size = rates.nodes[has_moments(work)][work.fluid->storage == fluid::Storage::Float];
  if (is_made_at_once(work)) by_size[1] = rates.at_once[work.fluid->storage == fluid::Storage::Float];
  // Between the two boxes by the logarithm of their nodes.
  const auto size = [](const std::array<std::int64_t, 3>& box) {
    return std::log(static_cast<double>(box[0] * box[1] * box[2]));
  };
  const double share = std::clamp(
      (size(work.fluid->grid.size) - size(boxes[0])) / (size(boxes[1]) - size(boxes[0])), 0.0, 1.0);
  const double updates = count(work.counts.node_updates);
  return seconds + updates / static_cast<double>(work.fluid->grid.count()) * rates.step[has_moments(work)] +
         updates / (by_size[0] + share * (by_size[1] - by_size[0]));
}

}  // namespace veriflex::engine
