#include "engine/result.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/utsname.h>

#include <algorithm>
#include <fstream>

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
  ~Table() { file_.attribute(group_, "columns", names_); }
  Table(const Table&) = delete;
  Table& operator=(const Table&) = delete;

 private:
  io::Hdf5Image& file_;
  std::string group_;
  std::vector<std::string> names_;
};

void write_head(io::Hdf5Image& file, const Result& r) {
  file.attribute("/", "format", std::string("veriflex-result"));
  file.attribute("/", "schema", std::int64_t{1});
  for (const auto& [name, value] : {std::pair{"id", &r.c.id},
                                    {"title", &r.c.title},
                                    {"asks", &r.c.asks},
                                    {"equation", &r.c.equation},
                                    {"driver", &r.c.driver},
                                    {"tier", &r.c.tier}}) {
    file.attribute("/", name, *value);
  }
  file.attribute("/", "topics", r.c.topics);
  file.attribute("/", "sources", r.c.sources);
  file.attribute("/", "verdict", to_string(r.verdict));
  file.attribute("/", "findings", std::int64_t{r.findings()});
  file.attribute("/", "warnings", r.warnings);
  if (r.verdict == Verdict::error) {
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

void write_observations(io::Hdf5Image& file, const observe::Observations& seen) {
  file.group("/records");
  for (const observe::Record& record : seen.records) {
    const std::string group = "/records/" + record.name;
    {
      Table table(file, group);
      for (const observe::Column& column : record.columns) table.column(column.name, column.values);
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
  metrics.column("dimension", seen.metrics, [](const observe::Metric& m) { return m.dimension; });
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
  // A run that ended in an error has no outcomes, and no row may be without one.
  const std::vector<Check> checks = r.outcomes.empty() ? std::vector<Check>{} : r.c.checks;
  table.column("question", checks,
               [](const Check& c) { return std::string(c.question == Question::claim ? "claim" : "code"); });
  table.column("statement", checks, [](const Check& c) { return c.statement; });
  table.column("tolerance_text", checks, [](const Check& c) { return c.tolerance.text; });
  table.column("reason", checks, [](const Check& c) { return c.tolerance.reason; });
  table.column("reference", checks,
               [&](const Check& c) { return c.reference ? r.c.references[*c.reference].id : std::string(); });
  table.column("kind", checks, [](const Check& c) { return c.kind; });
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
                                    {"compiler", &p.compiler},
                                    {"flags", &p.flags},
                                    {"build_type", &p.build_type},
                                    {"machine", &p.machine},
                                    {"operating_system", &p.operating_system},
                                    {"date", &p.date}}) {
    file.attribute("/provenance", name, *value);
  }
  file.attribute("/provenance", "threads", std::int64_t{p.threads});
  Table timing(file, "/timing");
  timing.column("phase", r.cost.phases(), [](const Phase& phase) { return phase.name; });
  timing.column("wall_seconds", r.cost.phases(), [](const Phase& phase) { return phase.wall_seconds; });
  timing.column("cpu_seconds", r.cost.phases(), [](const Phase& phase) { return phase.cpu_seconds; });
}

}  // namespace

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
    if (outcome.verdict != Verdict::finding) worst = std::max(worst, outcome.margin);
  }
  return worst;
}

Result run_case(const Case& c, int threads) {
  Result result{.c = c,
                .provenance = provenance(threads),
                .seen = {},
                .outcomes = {},
                .verdict = Verdict::error,
                .error_kind = {},
                .error_message = {},
                .warnings = {},
                .cost = {}};
  Progress progress(c.id);
  try {
    c.study.run(result.seen, progress, result.cost);
    for (const Check& check : c.checks) result.outcomes.push_back(judge(check, c, result.seen));
    result.verdict = overall(result.outcomes);
  } catch (const NumericalFailure& failure) {
    if (const auto* interrupted = dynamic_cast<const observe::Interrupted*>(&failure)) {
      const observe::Observations& last = interrupted->seen;
      result.seen.records.insert(result.seen.records.end(), last.records.begin(), last.records.end());
      result.seen.metrics.insert(result.seen.metrics.end(), last.metrics.begin(), last.metrics.end());
    }
    result.outcomes.clear();
    result.error_kind = "numerical";
    result.error_message = failure.what();
  }
  result.warnings = progress.warnings();
  result.cost.finish("judge");
  return result;
}

Result unreadable(const std::filesystem::path& path, const std::string& message, int threads) {
  Case c{};
  c.id = path.stem().string();
  c.path = path;
  return {.c = c,
          .provenance = provenance(threads),
          .seen = {},
          .outcomes = {},
          .verdict = Verdict::error,
          .error_kind = "input",
          .error_message = message,
          .warnings = {},
          .cost = {}};
}

void write_result(const Result& result, const std::filesystem::path& folder) {
  io::Hdf5Image file;
  write_head(file, result);
  write_assumed(file, result.c);
  write_plan(file, result.c.study.plan);
  write_observations(file, result.seen);
  write_checks(file, result);
  write_references(file, result.c);
  write_circumstances(file, result);
  io::write_file(folder / (result.c.id + ".h5"), file.bytes());
}

}  // namespace veriflex::engine
