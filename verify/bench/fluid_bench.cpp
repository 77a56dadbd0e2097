// How fast the fluid is, against what this machine's memory allows in the same minutes.
//
// The limit of an in-place kernel: every cache line of the populations is read once and written once per
// step, 240 bytes a node for double, 120 for float; of moments (tau = 1) 64 and 32. The machine's own rate
// for that is measured by updating a large array in place, alternately with the kernel, because shared
// machines change their speed within seconds.
//
// Where several steps are made at once the arithmetic is the other limit: the rate of a box that the largest
// cache holds. How many steps and rows follow from the cache's size; a short search says whether others would
// be faster.
#include <fmt/format.h>
#include <omp.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/memory.hpp"
#include "fluid/fluid.hpp"
#include "io/file.hpp"

namespace {

using namespace veriflex;

double seconds_of(const auto& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Bandwidth of long arrays, every line read and written once (update), or read here and written there
/// (copy).
class Memory {
 public:
  Memory() : from_(allocate_pages(bytes)), to_(allocate_pages(bytes)) {
    double* const a = from();
    double* const b = to();
#pragma omp parallel for schedule(static)
    for (std::int64_t i = 0; i < count; ++i) a[i] = b[i] = 1.0;
  }

  /// Best of some repeats so far  [GB/s], read plus written.
  void measure() {
    double* const a = from();
    double* const b = to();
    last_update = 2e-9 * bytes / seconds_of([=] {
#pragma omp parallel for simd schedule(static)
                    for (std::int64_t i = 0; i < count; ++i) a[i] = 0.999 * a[i] + 1e-3;
                  });
    update = std::max(update, last_update);
    copy = std::max(copy, 2e-9 * bytes / seconds_of([=] {
#pragma omp parallel for simd schedule(static)
                            for (std::int64_t i = 0; i < count; ++i) b[i] = a[i];
                          }));
  }

  static constexpr std::int64_t bytes = 1LL << 30;
  double update = 0.0, copy = 0.0, last_update = 0.0;

 private:
  static constexpr std::int64_t count = bytes / 8;
  double* from() const { return reinterpret_cast<double*>(from_.get()); }
  double* to() const { return reinterpret_cast<double*>(to_.get()); }
  Pages from_, to_;
};

struct Run {
  std::array<std::int64_t, 3> box;
  fluid::Storage storage;
  bool walls_and_force;
  fluid::Representation representation;
  std::optional<fluid::Blocking> blocking{};  // absent: one step after the other
};

std::string box_name(const Run& run) { return fmt::format("{}x{}x{}", run.box[0], run.box[1], run.box[2]); }

std::string blocking_name(const Run& run) {
  return run.blocking ? fmt::format(", {} x {} rows", run.blocking->steps, run.blocking->rows) : "";
}

fluid::Spec spec_of(const Run& run) {
  fluid::Spec spec{.grid = {run.box}, .relaxation_time = 1.0, .storage = run.storage};
  spec.representation = run.representation;
  spec.blocking = run.blocking;
  if (run.walls_and_force) {
    spec.body_force = {0.0, 0.0, 1e-7};
    for (auto& walls : spec.walls) walls = fluid::Walls{};
  }
  return spec;
}

/// A smooth flow that is different everywhere.
fluid::Populations start_at(const Grid& grid, std::int64_t node) {
  const auto [x, y, z] = grid.node(node);
  const double a = 0.1 * static_cast<double>(x);
  const double b = 0.07 * static_cast<double>(y);
  const double c = 0.05 * static_cast<double>(z);
  return fluid::equilibrium(1.0 + 1e-3 * std::sin(a + b + c),
                            {0.01 * std::sin(b), 0.01 * std::cos(c + a), 0.01 * std::sin(a - b)});
}

/// FNV-1a over the bits of all populations in the order of the nodes: the same for any number of threads.
std::string checksum(const fluid::Fluid& fluid) {
  const Grid& grid = fluid.spec().grid;
  const std::int64_t plane = grid.size[0] * grid.size[1];
  std::vector<std::int64_t> nodes(static_cast<std::size_t>(plane));
  std::vector<fluid::Populations> h(nodes.size());
  std::uint64_t hash = 14695981039346656037ULL;
  for (std::int64_t z = 0; z < grid.size[2]; ++z) {
    for (std::int64_t i = 0; i < plane; ++i) nodes[static_cast<std::size_t>(i)] = z * plane + i;
    fluid.populations(nodes, h);
    for (const fluid::Populations& node : h) {
      for (const double value : node) hash = (hash ^ std::bit_cast<std::uint64_t>(value)) * 1099511628211ULL;
    }
  }
  return fmt::format("{:016x}", hash);
}

/// One fluid that is stepped now and then between other measurements.
class Trial {
 public:
  explicit Trial(const Run& run) : run_(run), fluid_(fluid::make_fluid(spec_of(run))) {
    const Grid grid = fluid_->spec().grid;
    fluid_->start([&](std::int64_t node) { return start_at(grid, node); });
  }

  /// Blocks of steps, or pairs of steps, because odd and even ones move different data; as many as move what
  /// the memory's own measurement moves, for the best of longer spans would not be as good as that of short
  /// ones.
  void measure(const Memory& memory) {
    const auto nodes = static_cast<double>(fluid_->spec().grid.count());
    const auto pairs = std::max<std::int64_t>(1, std::llround(Memory::bytes / (nodes * bytes_per_node())));
    const std::int64_t steps = run_.blocking ? 2 * run_.blocking->steps : 2 * pairs;
    rates_.push_back(static_cast<double>(steps) * nodes * 1e-6 / seconds_of([&] {
                       if (run_.blocking) return fluid_->advance(steps);
                       for (std::int64_t step = 0; step < steps; ++step) fluid_->collide_and_stream();
                     }));
    fractions_.push_back(rates_.back() / limit(memory.last_update));
  }

  nlohmann::json report(const Memory& memory) const {
    const double mlups = *std::max_element(rates_.begin(), rates_.end());
    const double fraction = mlups / limit(memory.update);
    fmt::print(
        "{:>12} {:6} {:11}{:16}{:18} {:7.1f} MLUPS (median {:.1f})  {:5.1f} GB/s in place, {:5.1f} copied  "
        "fraction "
        "{:.3f} (median {:.3f})\n",
        box_name(run_), storage(), representation(), blocking_name(run_),
        run_.walls_and_force ? ", 6 walls, force" : "", mlups, median(rates_), memory.update, memory.copy,
        fraction, median(fractions_));
    return {{"box", box_name(run_)},
            {"storage", storage()},
            {"representation", representation()},
            {"threads", omp_get_max_threads()},
            {"blocked", run_.blocking.has_value()},
            {"steps_at_once", run_.blocking ? run_.blocking->steps : 1},
            {"tile_rows", run_.blocking ? run_.blocking->rows : 0},
            {"walls_and_force", run_.walls_and_force},
            {"mlups", mlups},
            {"mlups_median", median(rates_)},
            {"bytes_per_node", bytes_per_node()},
            {"update_bandwidth_gbs", memory.update},
            {"copy_bandwidth_gbs", memory.copy},
            {"fraction_of_limit", fraction},
            {"fraction_of_limit_median", median(fractions_)},
            {"checksum", checksum(*fluid_)}};
  }

  double median_rate() const { return median(rates_); }

  /// Speed over that of another, round by round: the median.
  double over(const Trial& other) const {
    std::vector<double> ratios;
    for (std::size_t i = 0; i < rates_.size(); ++i) ratios.push_back(rates_[i] / other.rates_[i]);
    return median(ratios);
  }

 private:
  std::string_view storage() const { return row_of(fluid::storages, run_.storage).name; }
  std::string_view representation() const { return row_of(fluid::representations, run_.representation).name; }
  /// Read and written a step.
  double bytes_per_node() const {
    const int numbers = run_.representation == fluid::Representation::Moments ? 4 : fluid::Q;
    return 2.0 * numbers * static_cast<double>(fluid::bytes_of(run_.storage));
  }
  /// [MLUPS] at a bandwidth in GB/s.
  double limit(double bandwidth) const { return bandwidth * 1e3 / bytes_per_node(); }

  static double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
  }

  Run run_;
  std::unique_ptr<fluid::Fluid> fluid_;
  std::vector<double> rates_;
  std::vector<double> fractions_;  // of the limit measured just before
};

std::int64_t row_bytes(const Run& run) { return fluid::Q * run.box[0] * fluid::bytes_of(run.storage); }

/// What the caches suggest; nothing where that is a step at a time.
std::optional<fluid::Blocking> suggested(const Run& run) {
  const fluid::Blocking blocking =
      fluid::blocking_for({run.box[1], run.box[2]}, row_bytes(run), omp_get_max_threads());
  return blocking.steps > 1 ? std::optional(blocking) : std::nullopt;
}

/// A box of the same rows that takes a third of the largest cache.
Run held_by_cache(Run run) {
  const auto rows = static_cast<double>(largest_cache().bytes / 3 / row_bytes(run));
  run.box[1] = run.box[2] = std::max<std::int64_t>(1, std::llround(std::sqrt(rows)));
  run.blocking = {};
  return run;
}

/// Half and twice the steps and the rows that the caches suggest: the median of three measurements each.
void search(const Run& run, const Memory& memory) {
  const fluid::Blocking from = *run.blocking;
  std::vector<std::pair<double, fluid::Blocking>> found;
  for (const std::int64_t steps : {from.steps / 2, from.steps, 2 * from.steps}) {
    for (const std::int64_t rows : {from.rows / 2, from.rows, 2 * from.rows}) {
      Run other = run;
      other.blocking = {std::max<std::int64_t>(2, steps), std::max<std::int64_t>(1, rows)};
      Trial trial(other);
      for (int repeat = 0; repeat < 3; ++repeat) trial.measure(memory);
      found.emplace_back(trial.median_rate(), *other.blocking);
    }
  }
  for (const auto& [rate, blocking] : found) {
    fmt::print("search: {} steps x {} rows {:.1f} MLUPS\n", blocking.steps, blocking.rows, rate);
  }
}

/// Populations and moments, bare and with walls and force, alternately with the memory. A fraction of the
/// limit is best over best; where the machine changes its speed meanwhile, the median over the rounds is to
/// be trusted.
void measure(const std::array<std::int64_t, 3>& box, fluid::Storage storage, bool is_searched, Memory& memory,
             nlohmann::json& runs) {
  constexpr auto populations = fluid::Representation::Populations;
  constexpr auto moments = fluid::Representation::Moments;
  Run run{box, storage, false, populations};
  Trial bare(run);
  Trial walled({box, storage, true, populations});
  Trial bare_moments({box, storage, false, moments});
  Trial walled_moments({box, storage, true, moments});
  std::vector trials{&bare, &bare_moments, &walled, &walled_moments};
  run.blocking = suggested(run);
  std::optional<Trial> blocked, blocked_walled, cached;
  if (run.blocking) {
    trials.push_back(&blocked.emplace(run));
    trials.push_back(&blocked_walled.emplace(Run{box, storage, true, populations, run.blocking}));
    trials.push_back(&cached.emplace(held_by_cache(run)));
  }
  memory.update = memory.copy = 0.0;
  for (int repeat = 0; repeat < 10; ++repeat) {
    for (Trial* trial : trials) {
      memory.measure();
      trial->measure(memory);
    }
  }
  for (const Trial* trial : trials) runs.push_back(trial->report(memory));
  nlohmann::json* const of = &runs[runs.size() - trials.size()];
  of[1]["over_populations"] = bare_moments.over(bare);
  of[3]["over_populations"] = walled_moments.over(walled);
  fmt::print("moments over populations, medians: bare {:.2f}, with walls and force {:.2f}\n",
             bare_moments.over(bare), walled_moments.over(walled));
  if (!run.blocking) return;
  of[4]["over_single_steps"] = blocked->over(bare);
  of[4]["over_cached"] = blocked->over(*cached);
  of[5]["over_single_steps"] = blocked_walled->over(walled);
  of[5]["over_bare"] = blocked_walled->over(*blocked);
  fmt::print(
      "{} steps at once by tiles of {} rows, medians: over single steps {:.2f}, over the rate in the cache "
      "{:.2f}; walls and force {:.2f} of bare\n",
      run.blocking->steps, run.blocking->rows, blocked->over(bare), blocked->over(*cached),
      blocked_walled->over(*blocked));
  if (is_searched) search(run, memory);
}

std::array<std::int64_t, 3> parse_box(const std::string& text) {
  std::array<std::int64_t, 3> box{};
  char x = 0;
  char y = 0;
  std::istringstream in(text);
  if (!(in >> box[0] >> x >> box[1] >> y >> box[2]) || x != 'x' || y != 'x' || !in.eof() ||
      *std::min_element(box.begin(), box.end()) < 1) {
    throw CLI::ValidationError("--box", fmt::format("'{}' is not a box. Write for example 64x416x400", text));
  }
  return box;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Speed of the fluid against the memory's");
  std::string box, storage, output;
  app.add_option("--box", box, "one box only, such as 64x416x400");
  app.add_option("--storage", storage, "one storage only")->check(CLI::IsMember({"double", "float"}));
  bool is_searched = false;
  app.add_flag("--search", is_searched, "look for better numbers of steps at once and of rows");
  app.add_option("--output", output, "JSON file");
  try {
    app.parse(argc, argv);
    std::vector<std::array<std::int64_t, 3>> boxes{
        {64, 64, 64}, {128, 128, 128}, {256, 256, 256}, {64, 416, 400}};
    if (!box.empty()) boxes = {parse_box(box)};
    Memory memory;
    nlohmann::json runs = nlohmann::json::array();
    double best = 0.0;
    for (const auto& size : boxes) {
      for (const fluid::Storage kind : {fluid::Storage::Double, fluid::Storage::Float}) {
        if (storage == (kind == fluid::Storage::Double ? "float" : "double")) continue;
        measure(size, kind, is_searched, memory, runs);
        best = std::max(best, memory.update);
      }
    }
    const nlohmann::json all{
        {"update_bandwidth_gbs", best}, {"threads", omp_get_max_threads()}, {"runs", runs}};
    if (!output.empty()) io::write_file(output, all.dump(2) + "\n");
  } catch (const CLI::Error& error) {
    return app.exit(error);
  } catch (const std::exception& error) {
    fmt::print(stderr, "fluid_bench: {}\n", error.what());
    return 2;
  }
  return 0;
}
