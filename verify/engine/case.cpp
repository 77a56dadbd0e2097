#include "engine/case.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <string_view>

#include "engine/asked.hpp"
#include "engine/ledger.hpp"
#include "engine/renamed.hpp"
#include "engine/symbols.hpp"
#include "io/file.hpp"

namespace veriflex::engine {

namespace fs = std::filesystem;

namespace {

Tolerance read_tolerance(const io::Table& check, bool curve) {
  const io::Table t = check.table("tolerance");
  std::vector<std::string> given;
  for (const char* form : {"absolute", "relative", "digits"}) {
    if (t.has(form)) given.emplace_back(form);
  }
  if (given.size() != 1) {
    check.fail("tolerance", fmt::format("tolerance has {} of: absolute, relative, digits", given.size()),
               "exactly one says how it is meant", "Write for example { relative = 1e-9, reason = \"...\" }");
  }
  Tolerance tolerance{};
  tolerance.reason = t.text("reason");
  if (given[0] == "digits") {
    const std::int64_t digits = t.integer("digits", -300, 300);
    tolerance.value = 0.5 * std::pow(10.0, -static_cast<double>(digits));
    tolerance.text = fmt::format("half a unit of decimal place {}", digits);
  } else {
    tolerance.relative = given[0] == "relative";
    tolerance.value = t.number(given[0]);
    tolerance.text = fmt::format("{} {}", tolerance.value, given[0]);
  }
  if (!(tolerance.value > 0.0)) {
    t.fail(given[0], fmt::format("tolerance is {}", tolerance.value), "it must be positive",
           "Give a positive number");
  }
  if (curve && !tolerance.relative) {
    t.fail(given[0], fmt::format("'{}' does not fit a curve", given[0]),
           "its errors are relative to max(|reference|, floor)",
           "Write { relative = ..., floor = ..., reason = ... }");
  }
  if (curve) {
    tolerance.floor = t.number("floor");
    if (!(tolerance.floor >= 0.0))
      t.fail("floor", "floor is negative", "it bounds |reference| from below", "Give 0 or more");
    tolerance.text = fmt::format("{} max(|reference|, {})", tolerance.value, tolerance.floor);
  }
  return tolerance;
}

// But for the target's own where a reference states it.
Uncertainty read_uncertainty(const io::Table& check, const Case& c) {
  const io::Table t = check.table("uncertainty");
  const auto half_width = [&](const std::string& key) {
    const double value = t.number(key);
    if (value < 0.0)
      t.fail(key, fmt::format("'{}' is {}", key, value), "it is a half-width, in the unit of the value",
             "Give 0 or more");
    return value;
  };
  Uncertainty uncertainty{};
  const bool by_study = t.has("gci_along");
  if (by_study == t.has("numerical")) {
    check.fail("uncertainty", by_study ? "both numerical and gci_along" : "neither numerical nor gci_along",
               "one says how far spacing, step and box may put the measured value off", "Keep one");
  }
  if (by_study) {
    const std::optional<Asked> gci = c.study.runs ? read_asked_gci(check) : std::nullopt;
    if (!gci) {
      t.fail("gci_along", "not of the values of a grid",
             "it is taken of the rows of a study, for one of them or their limit",
             "Give numerical, or ask of a [sweep] for a value or richardson");
    }
    uncertainty.gci = gci->name();
  } else {
    uncertainty.numerical = half_width("numerical");
  }
  if (t.has("input")) uncertainty.input = half_width("input");
  if (check.has("target")) uncertainty.reference = half_width("reference");
  return uncertainty;
}

// Where checks look up what they name.
struct Shelf {
  const fs::path& references;
  std::optional<Ledger> ledger, benchmarks;  // read when the first check asks for one
};

std::size_t index_of_reference(const std::string& id, Case& c, const Shelf& shelf, const Place& place) {
  if (id.find('/') != std::string::npos) {
    throw InputError(place, fmt::format("reference '{}' is named with a '/'", id),
                     "a reference lies beside the case or in reference/, and its name is its id",
                     "Put it there and write its name alone");
  }
  for (std::size_t i = 0; i < c.references.size(); ++i) {
    if (c.references[i].id == id) return i;
  }
  c.references.push_back(find_reference(id, c.path.parent_path(), shelf.references, place));
  return c.references.size() - 1;
}

// Of the reference's value that a metric is held against; a study's numbers (a boundary, an order) have none
// of their own.
void need_dimension(const std::string& dimension, const Check& check, const Case& c, const io::Table& s) {
  for (const observe::Metric& metric : measured(c.study)) {
    if (metric.name != check.measure || metric.dimension.empty() || metric.dimension == dimension) continue;
    s.fail("metric", fmt::format("'{}' has dimension {}", metric.name, metric.dimension),
           fmt::format("the reference's value has {}", dimension), "Compare numbers of the same dimension");
  }
}

void read_target(const io::Table& s, Check& check, Case& c, const Shelf& shelf) {
  if (s.has("target") == s.has("reference")) {
    throw InputError(s.place(),
                     s.has("target") ? "both target and reference" : "neither target nor reference",
                     "a check compares with one number",
                     "Give either reference (and quantity), or target, target_kind and source");
  }
  if (s.has("target")) {
    if (check.curve)
      s.fail("target", "a curve needs a reference", "its points stand in a table", "Name a reference");
    check.target = s.number("target");
    check.target_kind = s.choice("target_kind", target_kinds());
    check.source = s.text("source");
    return;
  }
  check.reference = index_of_reference(s.text("reference"), c, shelf, s.place("reference"));
  const Reference& reference = c.references[*check.reference];
  check.target_kind = reference.kind;
  check.source = reference.source;
  if (check.curve) {
    need_columns(reference, {check.curve->x, check.curve->y}, s, "curve");
    check.target = 0.0;
    return;
  }
  const std::string quantity = s.text("quantity", check.measure);
  const auto found = reference.values.find(quantity);
  if (found == reference.values.end()) {
    std::vector<std::string> names;
    for (const auto& [name, value] : reference.values) names.push_back(name);
    s.fail(s.has("quantity") ? "quantity" : "reference",
           fmt::format("reference '{}' has no value '{}'", reference.id, quantity),
           fmt::format("it has: {}", fmt::join(names, ", ")), "Name one of these with quantity = \"...\"");
  }
  if (!c.study.runs) need_dimension(found->second.dimension, check, c, s);
  check.target = found->second.value;
  if (check.uncertainty) check.uncertainty->reference = found->second.uncertainty;
  if (!std::isfinite(check.target)) {
    s.fail("reference", fmt::format("'{}' of reference '{}' is {}", quantity, reference.id, check.target),
           "no measured number lies at a distance from that", "Judge another quantity");
  }
  if (check.uncertainty) return;
  const double allowed = check.tolerance.value * (check.tolerance.relative ? std::abs(check.target) : 1.0);
  if (found->second.uncertainty > allowed) {
    s.fail("tolerance",
           fmt::format("tolerance {} is tighter than the reference's uncertainty {}", allowed,
                       found->second.uncertainty),
           "the reference cannot decide that", "Widen the tolerance or find a better reference");
  }
}

// The entries of a ledger that a check judges.
std::vector<std::string> read_cited(const io::Table& s, const std::string& key, const Ledger& ledger) {
  const std::vector<std::string> ids = s.has_list(key) ? s.texts(key) : std::vector{s.text(key)};
  if (ids.empty()) {
    s.fail(key, fmt::format("'{}' is empty", key), "it names at least one entry of the ledger",
           "Name one; see veriflex claims");
  }
  for (const std::string& id : ids) {
    const Entry& entry = find_entry(ledger, id, s.place(key));
    if (!is_judged(entry.kind)) {
      s.fail(key,
             fmt::format("the ledger calls '{}' {}", id,
                         entry.kind == not_decidable ? "not decidable" : "not compared"),
             entry.notes, "Judge another entry, or state in the ledger what a run could contradict");
    }
    if (std::count(ids.begin(), ids.end(), id) > 1) {
      s.fail(key, fmt::format("'{}' is named twice", id), "a check judges an entry once", "Remove one");
    }
  }
  return ids;
}

void read_benchmark(const io::Table& s, Check& check, Shelf& shelf) {
  if (!shelf.benchmarks) shelf.benchmarks = read_benchmarks(shelf.references);
  check.claims = read_cited(s, "benchmark", *shelf.benchmarks);
}

void read_claim(const io::Table& s, Check& check, Shelf& shelf) {
  if (!shelf.ledger) shelf.ledger = read_ledger(shelf.references);
  check.claims = read_cited(s, "claim", *shelf.ledger);
  if (s.flag("expected_to_hold", true)) return;
  const io::Table recorded = s.table("recorded");
  check.refuted = Recorded{recorded.number("value"), recorded.number("relative")};
  if (!(check.refuted->relative > 0.0)) {
    recorded.fail("relative", fmt::format("'relative' is {}", check.refuted->relative),
                  "it says how far a later measurement may depart", "Give a positive number");
  }
}

void check_uncertainty(const io::Table& s, const Check& check) {
  const auto refuse = [&](const std::string& problem) {
    s.fail("uncertainty", problem, "it says within what a number and a published number agree",
           "Give a tolerance with its reason");
  };
  if (check.target_kind != "published-number")
    refuse(fmt::format("an uncertainty against a target of kind '{}'", check.target_kind));
  if (check.curve) refuse("an uncertainty of a curve");
  if (check.outside) refuse("an uncertainty beside holds = \"outside\"");
  if (!check.uncertainty->gci && check.uncertainty->combined() == 0.0) refuse("all uncertainties are 0");
}

Check read_check(const io::Table& s, Case& c, Shelf& shelf) {
  Check check{};
  check.place = s.place();
  check.kind =
      s.choice("kind", {"verification", "claim"}) == "claim" ? CheckKind::claim : CheckKind::verification;
  check.statement = s.text("statement");
  if (s.has("curve") == s.has("metric")) {
    throw InputError(s.place(), s.has("curve") ? "both metric and curve" : "neither metric nor curve",
                     "a check judges one of them", "Keep one");
  }
  if (s.has("curve")) {
    const io::Table curve = s.table("curve");
    check.curve = Curve{curve.text("record"), curve.text("x"), curve.text("y")};
    if (c.study.runs && is_curve_of_numbers(s)) {
      const Asked asked = read_asked(s);
      check.curve = Curve{asked.name(), last_part(asked.across), asked.metric};
    }
    check.measure = check.curve->record + "." + check.curve->y;
  } else {
    check.measure = c.study.runs ? read_asked(s).name() : s.text("metric");
  }
  const std::vector<std::string> known = names_of(measured(c.study));
  if (std::find(known.begin(), known.end(), check.measure) == known.end()) {
    const std::string near = nearest_name(check.measure, known);
    s.fail(check.curve ? "curve" : "metric",
           fmt::format("driver '{}' does not measure '{}'", c.driver, check.measure),
           fmt::format("it measures: {}", fmt::join(known, ", ")),
           near.empty() ? "Choose one of these" : fmt::format("Did you mean '{}'?", near));
  }
  if (s.has("uncertainty") == s.has("tolerance")) {
    throw InputError(
        s.place(),
        s.has("tolerance") ? "both tolerance and uncertainty" : "neither tolerance nor uncertainty",
        "one of them says how near is near enough",
        "Give tolerance, or against a published value uncertainty");
  }
  if (s.has("uncertainty")) {
    check.uncertainty = read_uncertainty(s, c);
    check.tolerance.text = "combined uncertainty";
    check.tolerance.reason = s.table("uncertainty").text("reason");
  } else {
    check.tolerance = read_tolerance(s, check.curve.has_value());
  }
  check.outside = s.has("holds") && s.choice("holds", {"within", "outside"}) == "outside";
  read_target(s, check, c, shelf);
  if (check.uncertainty) check_uncertainty(s, check);
  if (check.tolerance.relative && !check.curve && check.target == 0.0) {
    s.fail("tolerance", "a relative tolerance of a target of zero", "nothing but exactly zero would pass",
           "Give an absolute tolerance");
  }
  if (check.kind == CheckKind::claim) {
    read_claim(s, check, shelf);
  } else if (s.has("benchmark")) {
    read_benchmark(s, check, shelf);
  }
  for (const Check& other : c.checks) {
    if (other.measure == check.measure && other.statement == check.statement && other.kind == check.kind) {
      s.fail("statement", fmt::format("the check of '{}' stands here twice", check.measure),
             "the first is at " + to_string(other.place),
             "Remove one, or say what it checks beyond the other");
    }
  }
  return check;
}

const Driver& find_driver(const io::Table& top, const std::vector<Driver>& drivers) {
  std::vector<std::string> names;
  for (const Driver& driver : drivers) names.push_back(driver.name);
  const std::string name = top.choice("driver", names);
  return *std::find_if(drivers.begin(), drivers.end(), [&](const Driver& d) { return d.name == name; });
}

// `whole`: each must stand in the case; a row of a study may have left the value out.
std::vector<Assumption> read_assumed(const io::Table& top, bool whole) {
  const io::Table table = top.table("assumed");
  std::vector<Assumption> all;
  for (const std::string& path : table.keys()) {
    const std::optional<std::string> value = top.shown(path);
    if (!value && !whole) {
      table.text(path);
      continue;
    }
    if (!value || path.starts_with("assumed")) {
      table.fail(path, fmt::format("the case has no value '{}'", path),
                 "[assumed] explains values that stand in the case",
                 "Write its dotted path in quotes, like \"bond.cutoff\" = \"...\", and the value itself in "
                 "its table");
    }
    all.push_back({path, *value, table.text(path)});
  }
  return all;
}

CaseHead head_of(const io::Table& top, const fs::path& path) {
  CaseHead head{path.stem().string(), "", "", "", {}, path, ""};
  const std::vector<InputError> old = old_names(top);
  if (!old.empty()) throw InputError(old.front());
  const std::string id = top.text("id");
  if (id != head.id) {
    top.fail("id", fmt::format("id '{}' differs from the file's name", id), "they must agree",
             fmt::format("Write id = \"{}\"", head.id));
  }
  if (id.find('+') != std::string::npos) {
    top.fail("id", fmt::format("id '{}' has a '+'", id), "it marks results of cases changed by --set",
             "Rename the case");
  }
  head.title = top.text("title");
  head.tier = top.choice("tier", tiers());
  head.driver = top.text("driver");
  head.topics = top.texts("topics");
  return head;
}

}  // namespace

std::string Case::name() const { return name_of_variant(id, overrides); }

std::string name_of_variant(const std::string& id, const std::vector<std::string>& overrides) {
  if (overrides.empty()) return id;
  constexpr std::size_t longest = 120;
  std::string said = id;
  bool whole = true;
  std::string given;
  for (const std::string& override : overrides) {
    given += override + '\n';
    said += '+';
    // Of a table its name, and the checksum tells it from others.
    const bool is_table = override.find("={") != std::string::npos;
    whole = whole && !is_table;
    for (const char c : is_table ? override.substr(0, override.find('=')) : override) {
      const bool suits = std::isalnum(static_cast<unsigned char>(c)) != 0 ||
                         std::string_view("._=,-").find(c) != std::string_view::npos;
      whole = whole && suits;
      said += suits ? c : '_';
    }
  }
  if (said.size() > id.size() + longest) {
    whole = false;
    said.resize(id.size() + longest);
  }
  return whole ? said : said + '+' + io::sha256(given).substr(0, 8);
}

std::string to_string(CheckKind kind) { return kind == CheckKind::claim ? "claim" : "verification"; }

const std::vector<std::string>& tiers() {
  static const std::vector<std::string> names{"quick", "full", "paper"};
  return names;
}

namespace {

void read_into(Case& c, const io::Table& top, const fs::path& path, const Readers& readers,
               const fs::path& reference_folder, std::vector<InputError>& problems) {
  // Whether `read` came to its end; a table whose reader broke off has no unknown keys.
  const auto attempt = [&problems](const io::Table& table, const auto& read) {
    try {
      read();
      return true;
    } catch (const InputError& error) {
      problems.push_back(error);
      table.abandon();
      return false;
    }
  };
  c.path = path;
  attempt(top, [&] { problems = old_names(top); });
  if (!problems.empty()) return;  // an old name would be said to be missing, too
  attempt(top, [&] {
    CaseHead head = head_of(top, path);
    c.id = std::move(head.id);
    c.title = std::move(head.title);
    c.tier = std::move(head.tier);
    c.topics = std::move(head.topics);
    c.question = top.text("question");
    c.equation = top.text("equation");
    c.sources = top.texts("sources");
    c.sources_at = top.place("sources");
  });
  const bool has_study = attempt(top, [&] {
    const Driver& driver = find_driver(top, readers.drivers);
    c.driver = driver.name;
    c.study = driver.read(top);
    if (!readers.study) return;
    c.study = readers.study(top, readers.with_checks ? top.tables("check") : std::vector<io::Table>{}, c,
                            std::move(c.study));
  });
  if (top.has("assumed")) attempt(top, [&] { c.assumed = read_assumed(top, readers.with_checks); });
  if (!has_study) return;  // what its checks may ask for is not known
  attempt(top, [&] {
    Shelf shelf{reference_folder, {}, {}};
    for (const io::Table& check : top.tables("check")) {
      if (readers.with_checks) {
        attempt(check, [&] { c.checks.push_back(read_check(check, c, shelf)); });
      } else {
        check.abandon();
      }
    }
  });
  for (const InputError& error : top.unknown_keys()) problems.push_back(error);
}

}  // namespace

Case read_parts(const io::Table& top, const fs::path& path, const Readers& readers,
                const fs::path& reference_folder, std::vector<InputError>& problems) {
  Case c;
  read_into(c, top, path, readers, reference_folder, problems);
  return c;
}

Case read_case(const fs::path& path, const std::vector<std::string>& overrides, const Readers& readers,
               const fs::path& reference_folder) {
  if (overrides.size() > io::longest_list) {
    throw InputError({}, fmt::format("{} times --set", overrides.size()),
                     fmt::format("a result file keeps {} of them", io::longest_list),
                     "Write a case file of your own");
  }
  const std::string text = io::read_file(path);
  std::vector<InputError> problems;
  Case c;
  c.text = text;
  c.overrides = overrides;
  read_into(c, parse_case(text, path.string(), overrides), path, readers, reference_folder, problems);
  if (!problems.empty()) throw problems.front();
  return c;
}

CaseHead read_head(const fs::path& path) {
  try {
    return head_of(parse_case(io::read_file(path), path.string()), path);
  } catch (const InputError& error) {
    return {path.stem().string(), "", "", "", {}, path, error.what()};
  }
}

fs::path case_named(const std::string& name, const fs::path& folder) {
  std::error_code impossible;  // such as a name too long for the file system: there is no such file
  if (fs::exists(name, impossible)) return name;
  const fs::path in_folder = folder / (name + ".toml");
  if (name.find('/') == std::string::npos && fs::exists(in_folder, impossible)) return in_folder;
  std::vector<std::string> ids;
  if (fs::is_directory(folder, impossible)) {
    for (const CaseHead& head : find_cases(folder)) ids.push_back(head.id);
  }
  const std::string near = nearest_name(fs::path(name).stem().string(), ids);
  throw InputError({}, fmt::format("no case '{}'", name),
                   fmt::format("neither a file nor an id in {}", folder.string()),
                   near.empty() ? "See veriflex list" : fmt::format("Did you mean '{}'?", near));
}

std::vector<CaseHead> find_cases(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    throw InputError({folder.string()}, "no such folder of cases", "cases are sought there",
                     "Give another with --cases");
  }
  std::vector<CaseHead> heads;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().extension() == ".toml") heads.push_back(read_head(entry.path()));
  }
  if (error) {
    throw InputError({folder.string()}, "cannot be read", error.message(), "Look at its permissions");
  }
  std::sort(heads.begin(), heads.end(), [](const CaseHead& a, const CaseHead& b) { return a.id < b.id; });
  return heads;
}

}  // namespace veriflex::engine
