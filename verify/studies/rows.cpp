#include "studies/rows.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gsl/gsl_statistics_double.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <numeric>
#include <optional>

#include "base/error.hpp"
#include "base/mutant.hpp"
#include "base/stop.hpp"
#include "engine/child.hpp"
#include "engine/columns.hpp"
#include "engine/only.hpp"
#include "engine/result.hpp"
#include "io/hdf5.hpp"

namespace veriflex::studies {

namespace fs = std::filesystem;

namespace {

using Settings = std::vector<std::string>;

Settings all_settings(const Base& base, const Settings& row) {
  Settings all = base.overrides;
  all.insert(all.end(), row.begin(), row.end());
  return all;
}

// Rounds after the first have folders of their own, for their times alone.
fs::path folder_of_round(const fs::path& folder, std::size_t round) {
  return round == 0 ? folder : folder / fmt::format("round-{}", round + 1);
}

fs::path result_of(const Base& base, const Settings& row, const fs::path& folder) {
  return folder / (engine::name_of_variant(base.id, all_settings(base, row)) + ".h5");
}

// What does not depend on the case may come out otherwise next time.
bool is_final(const std::string& outcome) {
  return outcome != "interrupted" && outcome != "memory" && outcome != "output" && outcome != "internal" &&
         outcome != "skipped";
}

// The row as one program ran it, which is the whole row or a round of it; nothing when the result file is of
// another case or program. With repeats its time is that of the second run in that program.
std::optional<Row> read_row(const Base& base, const Settings& settings, int repeats, const fs::path& path) {
  const io::Hdf5File file(path);
  const std::string all = fmt::format("{}", fmt::join(all_settings(base, settings), ", "));
  const bool same =
      engine::only(file.texts("/case"), path.string(), "/case") == base.text &&
      file.attribute("/", "variant") == all &&
      (file.attribute("/provenance", "program") == engine::program() || planted(Mutant::rows_of_any_program));
  if (!same) return std::nullopt;
  Row row{
      .settings = settings, .outcome = file.attribute("/", "outcome"), .message = {}, .seen = {}, .work = {}};
  if (row.outcome != "completed") row.message = file.attribute("/", "error_message");
  row.seen.metrics = engine::read_metrics(file, "/metrics");
  engine::Columns repeated(file, "/repeats");
  const std::vector<double> wall = repeated.numbers_of("wall_seconds"),
                            cpu = repeated.numbers_of("cpu_seconds");
  if (row.outcome == "completed" && wall.size() != static_cast<std::size_t>(repeats)) return std::nullopt;
  const auto sum = [](const std::vector<double>& phases) {
    return std::accumulate(phases.begin(), phases.end(), 0.0);
  };
  row.wall_seconds = wall.empty() ? sum(file.numbers("/timing/wall_seconds")) : wall.front();
  row.cpu_seconds = cpu.empty() ? sum(file.numbers("/timing/cpu_seconds")) : cpu.front();
  row.min_wall_seconds = row.max_wall_seconds = row.wall_seconds;
  for (const work::Field& field : work::fields) {
    row.work.*field.count = static_cast<std::uint64_t>(file.integer("/work", field.name));
  }
  row.parts_bytes = static_cast<double>(file.integer("/parts", "peak_bytes"));
  engine::Columns built(file, "/parts");
  const std::vector<std::string> part = built.words_of("part");
  const std::vector<double> count = built.numbers_of("count"), bytes = built.numbers_of("memory_bytes");
  for (std::size_t i = 0; i < part.size(); ++i) {
    for (std::size_t k = 0; k < parts::kinds.size(); ++k) {
      if (parts::kinds[k].id == part[i])
        row.parts[k] = {engine::count_of(count[i], file, "/parts/count"), bytes[i]};
    }
  }
  row.peak_memory_bytes = static_cast<double>(file.integer("/provenance", "peak_memory_bytes"));
  return row;
}

std::optional<Row> kept_row(const Base& base, const Settings& settings, int repeats, const fs::path& path) {
  std::error_code unknown;
  if (!fs::is_regular_file(path, unknown)) return std::nullopt;
  try {
    // Another program's numbers stand in files that may have changed since.
    if (io::Hdf5File(path).has_attribute("/provenance", "other_code")) return std::nullopt;
    std::optional<Row> row = read_row(base, settings, repeats, path);
    if (!row || !is_final(row->outcome)) return std::nullopt;
    return row;
  } catch (const InputError&) {  // damaged: it is run again
    return std::nullopt;
  }
}

// One row out of its rounds: numbers of the first, which all of them have, and medians of their times.
Row joined(std::vector<Row> rounds) {
  const auto failed = std::find_if(rounds.begin(), rounds.end(),
                                   [](const Row& round) { return round.outcome != "completed"; });
  if (failed != rounds.end()) return std::move(*failed);
  std::vector<double> wall, cpu;
  for (const Row& round : rounds) {
    wall.push_back(round.wall_seconds);
    cpu.push_back(round.cpu_seconds);
  }
  std::sort(wall.begin(), wall.end());
  std::sort(cpu.begin(), cpu.end());
  Row row = std::move(rounds.front());
  row.min_wall_seconds = wall.front();
  row.max_wall_seconds = wall.back();
  row.wall_seconds = gsl_stats_median_from_sorted_data(wall.data(), 1, wall.size());
  row.cpu_seconds = gsl_stats_median_from_sorted_data(cpu.data(), 1, cpu.size());
  return row;
}

// The program that makes one row. What it has to say stands in its result.
std::vector<std::string> row_command(const Base& base, const Settings& settings, const Workspace& workspace,
                                     const fs::path& folder, int threads, int repeats) {
  std::vector<std::string> words{
      workspace.program.string(), "row",       base.path.string(),     "--out", folder.string(), "--threads",
      std::to_string(threads),    "--repeats", std::to_string(repeats)};
  for (const std::string& one : all_settings(base, settings)) words.insert(words.end(), {"--set", one});
  return words;
}

// Repeats are taken in rounds over all rows, so that a machine that becomes slower or faster meanwhile does
// so to all of them, not to those at one end of an axis.
class Runner {
 public:
  Runner(const Base& base, const std::vector<Settings>& settings, const Workspace& workspace,
         const Timing& timing)
      : base_(base),
        settings_(settings),
        workspace_(workspace),
        folder_(folder_of_rows(base, workspace, timing.timed)),
        at_once_(timing.timed ? 1 : std::max(1, workspace.threads)),
        threads_(timing.timed ? workspace.threads : 1),
        repeats_(std::min(timing.repeats, 1)),
        rounds_(static_cast<std::size_t>(std::max(timing.repeats, 1))),
        rows_(settings.size()) {}

  std::vector<Row> run(const std::string& phase, Progress& progress) {
    const std::vector<Place> todo = take_kept();
    auto next = todo.begin();
    while (next != todo.end() || !running_.empty()) {
      while (next != todo.end() && !stop::asked() && running_.size() < static_cast<std::size_t>(at_once_)) {
        if (may_be_timed_again(*next)) start(*next);
        ++next;
      }
      if (running_.empty()) break;
      wait_for_one();
      const auto left = static_cast<std::size_t>(todo.end() - next);
      progress.show(phase, todo.size() - running_.size() - left, todo.size());
    }
    stop_if_asked("row", static_cast<std::int64_t>(next - todo.begin()));
    std::vector<Row> rows;
    for (std::vector<Row>& rounds : rows_) rows.push_back(joined(std::move(rounds)));
    return rows;
  }

 private:
  struct Place {
    std::size_t round, row;
    auto operator<=>(const Place&) const = default;
  };

  fs::path path(const Place& at) const {
    return result_of(base_, settings_[at.row], folder_of_round(folder_, at.round));
  }

  // Round by round what is left to run.
  std::vector<Place> take_kept() {
    std::vector<Place> todo;
    for (std::size_t round = 0; round < rounds_; ++round) {
      for (std::size_t i = 0; i < settings_.size(); ++i) {
        std::optional<Row> kept =
            workspace_.fresh ? std::nullopt : kept_row(base_, settings_[i], repeats_, path({round, i}));
        if (kept) {
          rows_[i].push_back(std::move(*kept));
        } else {
          todo.push_back({round, i});
        }
      }
    }
    return todo;
  }

  // A row that failed fails again.
  bool may_be_timed_again(const Place& at) const {
    return at.round == 0 || std::all_of(rows_[at.row].begin(), rows_[at.row].end(),
                                        [](const Row& round) { return round.outcome == "completed"; });
  }

  void start(const Place& at) {
    running_.try_emplace(at,
                         row_command(base_, settings_[at.row], workspace_, folder_of_round(folder_, at.round),
                                     threads_, repeats_),
                         engine::Streams{}, "Let the system have more processes");
  }

  // Until a child ends, or until it is time to look whether the study is to stop.
  void wait_for_one() {
    std::vector<const engine::Child*> children;
    for (const auto& [at, child] : running_) children.push_back(&child);
    std::size_t k = 0;
    const std::vector<bool> ended = engine::wait_for_any(children, asked_to_stop_);
    for (auto at = running_.begin(); at != running_.end(); ++k) {
      if (!ended[k]) {
        ++at;
        continue;
      }
      finish(at->first, at->second.wait());
      at = running_.erase(at);
    }
  }

  void finish(const Place& at, int status) {
    if (WIFSIGNALED(status)) {
      Row killed{.settings = settings_[at.row], .outcome = "killed", .message = {}, .seen = {}, .work = {}};
      killed.message = fmt::format("killed by signal {} ({})", WTERMSIG(status), strsignal(WTERMSIG(status)));
      rows_[at.row].push_back(std::move(killed));
      return;
    }
    std::optional<Row> row;
    try {
      row = read_row(base_, settings_[at.row], repeats_, path(at));
    } catch (const InputError& error) {
      throw OutputError(path(at).string(), fmt::format("a row was not stored there ({})", error.what()),
                        "Make room, and run the study again: rows that are there are kept");
    }
    if (!row) {
      throw InputError({base_.path.string()}, "the case was changed while its rows ran",
                       "they would not be rows of one study", "Run it again");
    }
    rows_[at.row].push_back(std::move(*row));
  }

  const Base& base_;
  const std::vector<Settings>& settings_;
  const Workspace& workspace_;
  fs::path folder_;
  int at_once_, threads_, repeats_;
  std::size_t rounds_;
  std::map<Place, engine::Child> running_;
  bool asked_to_stop_ = false;
  std::vector<std::vector<Row>> rows_;  // of each, its rounds
};

}  // namespace

fs::path folder_of_rows(const Base& base, const Workspace& workspace, bool timed) {
  return workspace.results / (base.name + (timed ? ".timed-rows" : ".rows"));
}

Timing read_timing(const io::Table& study) {
  const Timing timing{
      .timed = study.flag("timed", false),
      .repeats = study.has("repeats") ? static_cast<int>(study.integer("repeats", 1, 1000)) : 0};
  if (timing.repeats > 0 && !timing.timed) {
    study.fail("repeats", "the rows are not timed", "they run side by side, and their times mean nothing",
               "Add timed = true, or leave it out");
  }
  return timing;
}

std::vector<Row> run_rows(const Base& base, const std::vector<Settings>& settings, const Workspace& workspace,
                          const Timing& timing, const std::string& phase, Progress& progress) {
  return Runner(base, settings, workspace, timing).run(phase, progress);
}

std::vector<observe::Record> records_of(const Base& base, const Row& row, const Workspace& workspace,
                                        bool timed) {
  std::vector<observe::Record> records = base.records;
  if (records.empty()) return records;
  const io::Hdf5File file(result_of(base, row.settings, folder_of_rows(base, workspace, timed)));
  // What a run of other settings would have recorded, such as a film that is not asked for.
  std::erase_if(records, [&](const observe::Record& record) {
    return !file.has_attribute("/records/" + record.name, "columns");
  });
  for (observe::Record& record : records) {
    const observe::Record stored = engine::read_record(file, record.name);
    for (observe::Column& column : record.columns) {
      column.values = engine::numbers_in(stored, column.name, file);
    }
  }
  return records;
}

}  // namespace veriflex::studies
