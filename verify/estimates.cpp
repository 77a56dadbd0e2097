#include "estimates.hpp"

#include <numeric>

#include "base/error.hpp"
#include "engine/columns.hpp"
#include "engine/rates.hpp"
#include "engine/result.hpp"
#include "engine/stored_result.hpp"
#include "io/hdf5.hpp"
#include "run_cases.hpp"
#include "threads.hpp"

namespace veriflex {

namespace fs = std::filesystem;

namespace {

// What the case took when its result here was made; nothing where there is none.
std::optional<double> took(const std::string& id, const Options& options) {
  try {
    const std::string name = engine::name_of_variant(id, options.overrides);
    const io::Hdf5File file(fs::path(options.out) / (name + ".h5"));
    if (file.attribute("/", "outcome") != "completed") return std::nullopt;
    const std::vector<double> phases = file.numbers("/timing/wall_seconds");
    return std::accumulate(phases.begin(), phases.end(), 0.0);
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

std::optional<double> seconds_of_run(const engine::Study& run, int threads) {
  if (!run.expects) return std::nullopt;
  const std::vector<scene::ExpectedWork> scenes = run.expects();
  if (scenes.empty()) return std::nullopt;
  double seconds = 0.0;
  for (const scene::ExpectedWork& work : scenes)
    seconds += engine::seconds_of(work, engine::rates_for(work, threads));
  return seconds;
}

// A row that is refused, such as one of too high a Mach number, takes no time.
std::optional<double> seconds_of_row(const fs::path& path, const Options& options, int threads) {
  try {
    return seconds_of_run(read_without_baseline(path, options).study, threads);
  } catch (const InputError&) {
    return 0.0;
  }
}

// Nothing where one run's is not known.
std::optional<double> seconds_of_runs(const engine::Case& c, const engine::Runs& runs, const Options& options,
                                      int threads) {
  Options of_row = options;
  of_row.is_row = true;
  double sum = 0.0;
  for (const std::vector<std::string>& settings : runs.settings) {
    of_row.overrides = options.overrides;
    of_row.overrides.insert(of_row.overrides.end(), settings.begin(), settings.end());
    const std::optional<double> seconds = seconds_of_row(c.path, of_row, runs.side_by_side ? 1 : threads);
    if (!seconds) return std::nullopt;
    sum += *seconds;
  }
  return runs.times * (runs.side_by_side ? sum / threads : sum);
}

}  // namespace

std::optional<double> estimated_seconds(const engine::Case& c, const Options& options) {
  const int threads = usable_threads(options.threads);
  return c.study.runs ? seconds_of_runs(c, *c.study.runs, options, threads)
                      : seconds_of_run(c.study, threads);
}

std::vector<std::optional<double>> expected_seconds(const std::vector<std::string>& names,
                                                    const Options& options) {
  std::vector<std::optional<double>> all;
  for (const std::string& name : names) {
    std::optional<double>& one = all.emplace_back(took(fs::path(name).stem().string(), options));
    if (one) continue;
    try {
      const fs::path path = engine::case_named(name, options.case_folder);
      one = estimated_seconds(read_without_baseline(path, options), options);
    } catch (const std::exception&) {  // its own run will say what is wrong with it
    }
  }
  return all;
}

std::map<std::string, double> moved_by_offers(const std::string& id, const Options& options) {
  std::map<std::string, double> moved;
  std::error_code none;
  if (!fs::is_directory(options.out, none)) return moved;
  for (const fs::path& path : engine::result_files(options.out)) {
    if (!path.filename().string().starts_with(id)) continue;
    try {
      const io::Hdf5File file(path);
      if (file.attribute("/", "case_id") != id) continue;
      const observe::Record record = engine::read_record(file, "ablate");
      const std::vector<std::string>& variant = engine::words_in(record, "variant", file);
      const std::vector<std::string>& origin = engine::words_in(record, "origin", file);
      const std::vector<double>& change = engine::numbers_in(record, "moved", file);
      for (std::size_t i = 0; i < variant.size(); ++i)
        if (origin[i] == "offered") moved[variant[i]] = change[i];
    } catch (const InputError&) {  // a damaged result, or one of another form, says nothing
    }
  }
  return moved;
}

}  // namespace veriflex
