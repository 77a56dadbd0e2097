#include "engine/result.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/resource.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <fstream>
#include <new>
#include <system_error>

#include "base/mutant.hpp"
#include "base/reduce.hpp"
#include "base/stop.hpp"
#include "engine/columns.hpp"
#include "io/document.hpp"
#include "io/file.hpp"
#include "io/hdf5.hpp"
#include "observe/interrupted.hpp"
#include "revision.hpp"

namespace veriflex::engine {

namespace {

std::string processor_name() {
  std::ifstream cpuinfo("/proc/cpuinfo");
  for (std::string line; std::getline(cpuinfo, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown";
}

// Writes equal-length columns below `group` in the order they are given.
class Table {
 public:
  Table(io::Hdf5Image& file, std::string group) : file_(file), group_(std::move(group)) {
    file_.group(group_);
  }
  void column(const std::string& name, const std::vector<double>& values) {
    file_.numbers(group_ + "/" + name, values);
    names_.push_back(name);
  }
  void column(const std::string& name, const std::vector<std::string>& values) {
    file_.texts(group_ + "/" + name, values);
    names_.push_back(name);
  }
  template <class Row, class Get>
  void column(const std::string& name, const std::vector<Row>& rows, Get get) {
    std::vector<std::decay_t<decltype(get(rows.front()))>> values;
    for (const Row& row : rows) values.push_back(get(row));
    column(name, values);
  }
  // Throws as column() does, unless an exception is on its way already.
  ~Table() noexcept(false) {
    if (std::uncaught_exceptions() == exceptions_) file_.attribute(group_, "columns", names_);
  }
  Table(const Table&) = delete;
  Table& operator=(const Table&) = delete;

 private:
  io::Hdf5Image& file_;
  std::string group_;
  std::vector<std::string> names_;
  int exceptions_ = std::uncaught_exceptions();
};

void write_head(io::Hdf5Image& file, const Result& r) {
  file.attribute("/", "format", std::string("veriflex-result"));
  file.attribute("/", "schema", std::int64_t{2});
  file.attribute("/", "id", r.c.name());
  file.attribute("/", "variant", fmt::format("{}", fmt::join(r.c.overrides, ", ")));
  for (const auto& [name, value] : {std::pair{"case_id", &r.c.id},
                                    {"title", &r.c.title},
                                    {"question", &r.c.question},
                                    {"equation", &r.c.equation},
                                    {"driver", &r.c.driver},
                                    {"tier", &r.c.tier}}) {
    file.attribute("/", name, *value);
  }
  file.attribute("/", "topics", r.c.topics);
  file.attribute("/", "sources", r.c.sources);
  file.attribute("/", "verdict", to_string(r.verdict));
  file.attribute("/", "outcome", r.outcome());
  file.attribute("/", "findings", std::int64_t{r.findings()});
  std::vector<std::string> warnings = r.warnings;
  if (warnings.size() > io::longest_list) {
    warnings.resize(io::longest_list);
    warnings.back() = fmt::format("and {} more", r.warnings.size() - io::longest_list + 1);
  }
  file.attribute("/", "warnings", warnings);
  if (!r.has_answer()) {
    file.attribute("/", "error_kind", r.error_kind);
    file.attribute("/", "error_message", r.error_message);
  }
  file.text("/case", r.c.text);
  file.attribute("/case", "path", r.c.path.string());
  file.attribute("/case", "overrides", r.c.overrides);
}

void write_assumed(io::Hdf5Image& file, const Case& c) {
  Table table(file, "/assumed");
  table.column("path", c.assumed, [](const Assumption& a) { return a.path; });
  table.column("value", c.assumed, [](const Assumption& a) { return a.value; });
  table.column("why", c.assumed, [](const Assumption& a) { return a.why; });
}

void write_plan(io::Hdf5Image& file, const scene::Plan& plan) {
  {
    Table built(file, "/plan/built");
    built.column("module", plan.built, [](const scene::Built& b) { return b.module; });
    built.column("what", plan.built, [](const scene::Built& b) { return b.what; });
    built.column("memory_bytes", plan.built, [](const scene::Built& b) { return b.memory_bytes; });
  }
  Table left_out(file, "/plan/left_out");
  left_out.column("module", plan.left_out, [](const scene::LeftOut& l) { return l.module; });
  left_out.column("why", plan.left_out, [](const scene::LeftOut& l) { return l.why; });
}

void write_parts(io::Hdf5Image& file, const Result& r) {
  {
    Table table(file, "/parts");
    std::vector<std::string> names;
    std::vector<double> count, bytes;
    for (std::size_t k = 0; k < r.parts.size(); ++k) {
      if (r.parts[k].count == 0) continue;
      names.emplace_back(parts::kinds[k].id);
      count.push_back(static_cast<double>(r.parts[k].count));
      bytes.push_back(r.parts[k].bytes);
    }
    table.column("part", names);
    table.column("count", count);
    table.column("memory_bytes", bytes);
  }
  file.attribute("/parts", "peak_bytes", std::llround(r.peak.bytes));
  file.attribute("/parts", "allocated_bytes", std::llround(r.peak.allocated));
}

void write_observations(io::Hdf5Image& file, const observe::Observations& seen) {
  file.group("/records");
  for (const observe::Record& record : seen.records) {
    const std::string group = "/records/" + record.name;
    {
      // A run may break off in the middle of a row.
      std::size_t rows = record.columns.empty() ? 0 : record.columns.front().size();
      for (const observe::Column& column : record.columns) rows = std::min(rows, column.size());
      const auto first = [rows](const auto& all) {
        return std::decay_t<decltype(all)>(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(rows));
      };
      Table table(file, group);
      for (const observe::Column& column : record.columns) {
        if (column.texts.empty()) {
          table.column(column.name, first(column.values));
        } else {
          table.column(column.name, first(column.texts));
        }
      }
    }
    file.attribute(group, "title", record.title);
    for (const observe::Column& column : record.columns) {
      const std::string path = group + "/" + column.name;
      file.attribute(path, "symbol", column.symbol);
      file.attribute(path, "dimension", column.dimension);
      file.attribute(path, "meaning", column.meaning);
    }
  }
  Table metrics(file, "/metrics");
  metrics.column("name", seen.metrics, [](const observe::Metric& m) { return m.name; });
  metrics.column("value", seen.metrics, [](const observe::Metric& m) { return m.value; });
  metrics.column("dimension", seen.metrics, [](const observe::Metric& m) {
    return planted(Mutant::dimension_lost) ? std::string("1") : m.dimension;
  });
  metrics.column("meaning", seen.metrics, [](const observe::Metric& m) { return m.meaning; });
}

void write_checks(io::Hdf5Image& file, const Result& r) {
  Table table(file, "/checks");
  table.column("metric", r.outcomes, [](const Outcome& o) { return o.measure; });
  table.column("measured", r.outcomes, [](const Outcome& o) { return o.measured; });
  table.column("target", r.outcomes, [](const Outcome& o) { return o.target; });
  table.column("tolerance", r.outcomes, [](const Outcome& o) { return o.tolerance; });
  table.column("error", r.outcomes, [](const Outcome& o) { return o.error; });
  table.column("margin", r.outcomes, [](const Outcome& o) { return o.margin; });
  table.column("verdict", r.outcomes, [](const Outcome& o) { return to_string(o.verdict); });
  table.column("holds", r.outcomes,
               [](const Outcome& o) { return std::string(o.outside ? "outside" : "within"); });
  const auto half_width = [&](double Uncertainty::*side) {
    return [side](const Outcome& o) { return o.uncertainty ? (*o.uncertainty).*side : NAN; };
  };
  table.column("uncertainty_reference", r.outcomes, half_width(&Uncertainty::reference));
  table.column("uncertainty_numerical", r.outcomes, half_width(&Uncertainty::numerical));
  table.column("uncertainty_input", r.outcomes, half_width(&Uncertainty::input));
  // A run that ended in an error has no outcomes, and no row may be without one.
  const std::vector<Check> checks = r.outcomes.empty() ? std::vector<Check>{} : r.c.checks;
  table.column("kind", checks, [](const Check& c) { return to_string(c.kind); });
  table.column("statement", checks, [](const Check& c) { return c.statement; });
  table.column("tolerance_text", checks, [](const Check& c) { return c.tolerance.text; });
  table.column("reason", checks, [](const Check& c) { return c.tolerance.reason; });
  table.column("reference", checks,
               [&](const Check& c) { return c.reference ? r.c.references[*c.reference].id : std::string(); });
  table.column("target_kind", checks, [](const Check& c) { return c.target_kind; });
  table.column("source", checks, [](const Check& c) { return c.source; });
  table.column("claim", checks, [](const Check& c) { return fmt::format("{}", fmt::join(c.claims, " ")); });
}

void write_references(io::Hdf5Image& file, const Case& c) {
  file.group("/references");
  for (const Reference& reference : c.references) {
    const std::string group = "/references/" + reference.id;
    {
      Table table(file, group);
      for (const io::CsvColumn& column : reference.columns) table.column(column.name, column.values);
    }
    file.attribute(group, "kind", reference.kind);
    file.attribute(group, "source", reference.source);
    file.attribute(group, "obtained", reference.obtained);
    file.attribute(group, "command", reference.command);
    file.attribute(group, "sha256", reference.sha256);
  }
}

void write_circumstances(io::Hdf5Image& file, const Result& r) {
  file.group("/provenance");
  const Provenance& p = r.provenance;
  for (const auto& [name, value] : {std::pair{"version", &p.version},
                                    {"revision", &p.revision},
                                    {"program", &program()},
                                    {"compiler", &p.compiler},
                                    {"flags", &p.flags},
                                    {"build_type", &p.build_type},
                                    {"machine", &p.machine},
                                    {"operating_system", &p.operating_system},
                                    {"date", &p.date}}) {
    file.attribute("/provenance", name, *value);
  }
  if (r.c.study.other_code) {
    file.attribute("/provenance", "other_code", r.c.study.other_code->name);
    file.attribute("/provenance", "other_code_obtained", r.c.study.other_code->obtained);
    file.attribute("/provenance", "other_code_case", r.c.study.other_code->of_case);
  }
  file.attribute("/provenance", "threads", std::int64_t{p.threads});
  file.attribute("/provenance", "machine_memory_bytes",
                 std::int64_t{sysconf(_SC_PHYS_PAGES)} * std::int64_t{sysconf(_SC_PAGESIZE)});
  file.group("/work");
  for (const work::Field& field : work::fields) {
    file.attribute("/work", field.name, static_cast<std::int64_t>(r.work.*field.count));
  }
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  file.attribute("/provenance", "peak_memory_bytes", std::int64_t{used.ru_maxrss} * 1024);  // of the program
  Table timing(file, "/timing");
  timing.column("phase", r.cost.phases(), [](const Phase& phase) { return phase.name; });
  timing.column("wall_seconds", r.cost.phases(), [](const Phase& phase) { return phase.wall_seconds; });
  timing.column("cpu_seconds", r.cost.phases(), [](const Phase& phase) { return phase.cpu_seconds; });
  Table repeats(file, "/repeats");
  repeats.column("wall_seconds", r.repeats, [](const Phase& run) { return run.wall_seconds; });
  repeats.column("cpu_seconds", r.repeats, [](const Phase& run) { return run.cpu_seconds; });
}

}  // namespace

const std::string& program() {
  static const std::string name = [] {
    const std::string revision = build::revision;
    const bool says_all = revision.find_first_not_of("0123456789abcdef") == std::string::npos;
    std::string is = says_all ? revision : revision + ' ' + io::sha256(io::read_file("/proc/self/exe"));
    for (const Named<Mutant>& mutant : mutants) {
      if (planted(mutant.value)) is += fmt::format(" with {}", mutant.name);
    }
    return is;
  }();
  return name;
}

Provenance provenance(int threads) {
  utsname system{};
  uname(&system);
  return {.version = build::version,
          .revision = build::revision,
          .compiler = build::compiler,
          .flags = build::flags,
          .build_type = build::type,
          .machine = processor_name(),
          .operating_system = fmt::format("{} {} {}", system.sysname, system.release, system.machine),
          .date = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr))),
          .threads = threads};
}

int Result::findings() const {
  return static_cast<int>(std::count_if(outcomes.begin(), outcomes.end(),
                                        [](const Outcome& o) { return o.verdict == Verdict::finding; }));
}

double Result::worst_margin() const {
  double worst = 0.0;
  for (const Outcome& outcome : outcomes) {
    if (outcome.verdict != Verdict::finding) worst = worse(worst, outcome.margin);
  }
  return worst;
}

namespace {

// Adds the last good state; a name stands once in a result file.
template <class Named>
void put_in(std::vector<Named>& seen, const std::vector<Named>& last) {
  for (const Named& one : last) {
    const auto same =
        std::find_if(seen.begin(), seen.end(), [&](const Named& n) { return n.name == one.name; });
    if (same == seen.end()) {
      seen.push_back(one);
    } else {
      *same = one;
    }
  }
}

}  // namespace

Failure current_failure() {
  const std::string memory = "out of memory. Use a smaller scene (see veriflex plan)";
  try {
    throw;
  } catch (const NumericalFailure& failure) {
    if (stop::was_thrown()) return {"interrupted", failure.what()};
    return {"numerical", failure.what(), to_string(failure.mode)};
  } catch (const InputError& error) {
    return {"input", error.what()};
  } catch (const BadParameter& bad) {
    return {"input", bad.what()};
  } catch (const OutputError& error) {
    return {"output", error.what()};
  } catch (const std::bad_alloc&) {
    return {"memory", memory};
  } catch (const std::length_error&) {  // more elements than there can be addresses
    return {"memory", memory};
  } catch (const std::filesystem::filesystem_error& error) {
    return {"input", error.what()};
  } catch (const std::exception& error) {
    return {"internal",
            fmt::format("{}. This should not happen: please report it with the case", error.what())};
  } catch (...) {
    return {"internal", "an exception without words. This should not happen: please report it with the case"};
  }
}

std::string Result::outcome() const {
  if (has_answer()) return "completed";
  if (verdict == Verdict::skipped) return "skipped";
  if (error_kind == "input") return "refused";
  return error_kind == "numerical" ? error_mode : error_kind;
}

void Result::fail(const Failure& failure) {
  outcomes.clear();
  verdict = failure.kind == "lacking" ? Verdict::skipped : Verdict::error;
  error_kind = failure.kind;
  error_message = failure.message;
  error_mode = failure.mode;
}

namespace {

// One run whose numbers nobody wants, over as many as fill a time that the clock resolves.
Phase time_of_a_run(const Case& c) {
  constexpr double resolved = 0.02;  // [s]
  Progress silent(c.id);
  Cost cost;
  int runs = 0;
  do {
    observe::Observations unused = begin(c.study);
    Cost phases;
    c.study.run(unused, silent, phases);
    cost.finish("run");
    ++runs;
  } while (cost.phases().front().wall_seconds < resolved);
  const Phase& all = cost.phases().front();
  return {"run", all.wall_seconds / runs, all.cpu_seconds / runs};
}

}  // namespace

Result run_case(const Case& c, int threads, int repeats, Checkpoints* checkpoints) {
  Result result{.c = c,
                .provenance = provenance(threads),
                .seen = begin(c.study),
                .outcomes = {},
                .verdict = Verdict::error,
                .error_kind = {},
                .error_message = {},
                .error_mode = {},
                .warnings = {},
                .cost = {}};
  if (!c.study.lacks.empty()) {
    result.seen = {};
    result.fail({"lacking", c.study.lacks});
    return result;
  }
  Progress progress(c.id);
  stop::forget();
  const work::Counts before = work::done();
  parts::restart();
  try {
    if (checkpoints != nullptr) {
      c.study.run_with_checkpoints(result.seen, progress, result.cost, *checkpoints);
    } else {
      c.study.run(result.seen, progress, result.cost);
    }
    if (stop::was_thrown()) {
      // The study took the interruption for an answer, say "does not survive": its numbers are worth nothing.
      result.seen = {};
      throw Stopped(stop::reason());
    }
    hold_to_declaration(c.study, result.seen);
    hold_to_plan(c.study);
    for (const Check& check : c.checks) result.outcomes.push_back(judge(check, c, result.seen));
    result.verdict = overall(result.outcomes);
    const bool only_baseline = std::all_of(c.checks.begin(), c.checks.end(),
                                           [](const Check& k) { return k.target_kind == "baseline"; });
    if (only_baseline && result.verdict == Verdict::pass) result.verdict = Verdict::measured;
  } catch (const observe::Interrupted& interrupted) {
    put_in(result.seen.records, interrupted.seen.records);
    put_in(result.seen.metrics, interrupted.seen.metrics);
    result.fail(current_failure());
  } catch (...) {
    result.fail(current_failure());
  }
  std::erase_if(result.seen.records, [](const observe::Record& record) {  // declared, and never filled
    return record.columns.empty() || record.columns.front().size() == 0;
  });
  result.warnings = progress.warnings();
  result.cost.finish("judge");
  const work::Counts after = work::done();
  for (const work::Field& field : work::fields) {
    result.work.*field.count = after.*field.count - before.*field.count;
  }
  result.parts = parts::made();
  result.peak = parts::peak();
  try {
    while (result.has_answer() && repeats-- > 0) result.repeats.push_back(time_of_a_run(c));
  } catch (...) {
    result.fail(current_failure());
  }
  return result;
}

Result not_run(const std::filesystem::path& path, const std::vector<std::string>& overrides,
               const Failure& failure, int threads) {
  Case c{};
  c.id = path.stem().string();
  c.path = path;
  c.overrides = overrides;
  return {.c = c,
          .provenance = provenance(threads),
          .seen = {},
          .outcomes = {},
          .verdict = Verdict::error,
          .error_kind = failure.kind,
          .error_message = failure.message,
          .error_mode = failure.mode,
          .warnings = {},
          .cost = {}};
}

observe::Record read_table(const io::Hdf5File& file, const std::string& group) {
  const auto said = [&](const std::string& path, const std::string& name) {
    return file.has_attribute(path, name) ? file.attribute(path, name) : std::string();
  };
  observe::Record table{group.substr(group.rfind('/') + 1), said(group, "title"), {}};
  Columns columns(file, group);
  for (const std::string& column : file.attribute_texts(group, "columns")) {
    const std::string path = columns.path_of(column);
    table.columns.push_back(
        {column, said(path, "symbol"), said(path, "dimension"), said(path, "meaning"), {}});
    if (file.holds_texts(path)) {
      table.columns.back().texts = columns.words_of(column);
    } else {
      table.columns.back().values = columns.numbers_of(column);
    }
  }
  return table;
}

observe::Record read_record(const io::Hdf5File& file, const std::string& name) {
  return read_table(file, "/records/" + name);
}

std::filesystem::path result_path(const Case& c, const std::filesystem::path& folder) {
  return folder / (c.name() + ".h5");
}

void write_result(const Result& result, const std::filesystem::path& folder) {
  io::Hdf5Image file;
  write_head(file, result);
  write_assumed(file, result.c);
  write_plan(file, result.c.study.plan);
  write_parts(file, result);
  write_observations(file, result.seen);
  write_checks(file, result);
  write_references(file, result.c);
  write_circumstances(file, result);
  io::write_file(result_path(result.c, folder), file.bytes());
}

}  // namespace veriflex::engine
