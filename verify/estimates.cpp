#include "estimates.hpp"

#include <numeric>

#include "base/error.hpp"
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

}  // namespace

std::optional<double> estimated_seconds(const engine::Case& c, int threads) {
  if (!c.study.expects || c.study.of_many_runs) return std::nullopt;
  const std::optional<scene::ExpectedWork> work = c.study.expects();
  return work ? std::optional(engine::seconds_of(*work, engine::rates(threads))) : std::nullopt;
}

std::vector<std::optional<double>> expected_seconds(const std::vector<std::string>& names,
                                                    const Options& options) {
  std::vector<std::optional<double>> all;
  const int threads = usable_threads(options.threads);
  for (const std::string& name : names) {
    std::optional<double>& one = all.emplace_back(took(fs::path(name).stem().string(), options));
    if (one) continue;
    try {
      const fs::path path = engine::case_named(name, options.case_folder);
      one = estimated_seconds(read_without_baseline(path, options), threads);
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
      const std::vector<std::string>& variant = record.find("variant")->texts;
      const observe::Column* origin = record.find("origin");
      const observe::Column* change = record.find("moved");
      for (std::size_t i = 0; origin != nullptr && change != nullptr && i < variant.size(); ++i)
        if (origin->texts[i] == "offered") moved[variant[i]] = change->values[i];
    } catch (const InputError&) {  // a damaged result, or one of another form, says nothing
    }
  }
  return moved;
}

}  // namespace veriflex
