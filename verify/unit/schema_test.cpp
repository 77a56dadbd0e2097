// The schema documents against the readers: every key that a reader knows is documented, and every documented
// key is read.
#include <algorithm>
#include <filesystem>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "bond/laws.hpp"
#include "catch.hpp"
#include "engine/case.hpp"
#include "engine/ledger.hpp"
#include "engine/reference.hpp"
#include "engine/symbols.hpp"
#include "engine/validate.hpp"
#include "io/file.hpp"
#include "repository.hpp"
#include "studies/studies.hpp"

using namespace veriflex;
namespace fs = std::filesystem;

namespace {

const fs::path& root = repository::root();
const fs::path references = root / "reference";

using Names = std::set<std::string>;

std::vector<std::smatch> all_matches(const std::string& text, const std::string& pattern) {
  const std::regex expression(pattern);
  return {std::sregex_iterator(text.begin(), text.end(), expression), {}};
}

// First cells of the tables, where they are code.
Names documented(const fs::path& document) {
  const std::string text = io::read_file(document);
  Names paths;
  for (const std::smatch& match : all_matches(text, "\\n\\| `([^`]+)`")) paths.insert(match[1]);
  return paths;
}

// `<name>` in a documented path stands for any one name, at its end for any dotted path.
bool matches(const std::string& documented_path, const std::string& asked) {
  std::string pattern = std::regex_replace(documented_path, std::regex("[.\\[\\]]"), "\\$&");
  pattern = std::regex_replace(pattern, std::regex("<[a-z]+>$"), ".+");
  pattern = std::regex_replace(pattern, std::regex("<[a-z]+>"), "[^.]+");
  return std::regex_match(asked, std::regex(pattern));
}

std::string leaf(const std::string& path) { return path.substr(path.rfind('.') + 1); }

std::vector<fs::path> files(const fs::path& folder, const std::string& extension) {
  std::vector<fs::path> all;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == extension) all.push_back(entry.path());
  }
  std::sort(all.begin(), all.end());
  return all;
}

void add(Names& to, const std::vector<std::string>& names) { to.insert(names.begin(), names.end()); }

// What the readers ask for when they read everything that is shipped.
Names asked_of_cases() {
  Names asked;
  for (const fs::path& path : files(root / "cases", ".toml")) {
    const io::Table top = engine::parse_case(io::read_file(path), path.string());
    std::vector<InputError> problems;
    engine::read_parts(top, path, studies::readers(), references, problems);
    REQUIRE(problems.empty());
    add(asked, top.asked());
  }
  return asked;
}

Names asked_of_references() {
  Names asked;
  for (const fs::path& path : files(references, ".toml")) {
    const io::Table top = io::parse_document(io::read_file(path), path.string());
    engine::read_reference(top, path);
    add(asked, top.asked());
  }
  for (const fs::path& path : files(references / "claims", ".toml")) {
    const io::Table ledger = io::parse_document(io::read_file(path), path.string());
    engine::read_ledger(ledger);
    add(asked, ledger.asked());
  }
  return asked;
}

// Keys as they stand in the readers' sources, so that a branch that no shipped file takes is not missed.
struct ReadersSource {
  Names keys;
  Names computed;  // reading calls whose key is not spelt out
};

ReadersSource scan(const std::vector<fs::path>& sources) {
  const std::string reading =
      "\\b(\\w+\\.(?:number|number_if|number_or_infinity|integer|flag|text|texts|numbers|numbers_or_none|"
      "integers|table|"
      "tables|choice|"
      "has)\\()";
  ReadersSource found;
  for (const fs::path& source : sources) {
    const std::string text = io::read_file(source);
    for (const std::smatch& match : all_matches(text, reading + "\"([a-z_0-9]+)\""))
      found.keys.insert(match[2]);
    for (const std::smatch& match : all_matches(text, reading + "([^\")][^,)]*)")) {
      found.computed.insert(match.str(1) + match.str(2));
    }
  }
  return found;
}

std::string toml_block(const fs::path& document, const std::string& holding) {
  const std::string text = io::read_file(document);
  for (std::size_t at = text.find("```toml\n"); at != std::string::npos;
       at = text.find("```toml\n", at + 1)) {
    const std::size_t start = at + 8;
    const std::string block = text.substr(start, text.find("```", start) - start);
    if (block.find(holding) != std::string::npos) return block;
  }
  FAIL("no example with " << holding << " in " << document);
  return {};
}

std::vector<std::string> undocumented(const Names& asked, const Names& paths) {
  std::vector<std::string> missing;
  for (const std::string& key : asked) {
    const bool known =
        std::any_of(paths.begin(), paths.end(), [&](const std::string& p) { return matches(p, key); });
    if (!known) missing.push_back(key);
  }
  return missing;
}

std::vector<std::string> unread(const Names& paths, const Names& asked, const Names& spelt) {
  std::vector<std::string> missing;
  for (const std::string& path : paths) {
    const bool is_asked =
        std::any_of(asked.begin(), asked.end(), [&](const std::string& a) { return matches(path, a); });
    if (!is_asked && !spelt.contains(leaf(path))) missing.push_back(path);
  }
  return missing;
}

const std::vector<std::string> none;

}  // namespace

TEST_CASE("Every key that readers of cases ask for is in cases/README.md, and the other way round") {
  const Names paths = documented(root / "cases" / "README.md");
  const Names asked = asked_of_cases();
  CHECK(undocumented(asked, paths) == none);

  std::vector<fs::path> sources;
  for (const fs::directory_entry& subject : fs::directory_iterator(root / "verify" / "measures")) {
    if (!subject.is_directory()) continue;
    for (const fs::path& source : files(subject.path(), ".cpp")) {
      if (source.stem() != "scene_checkpoint") sources.push_back(source);  // reads no case
    }
  }
  for (const fs::path& study : files(root / "verify" / "studies", ".cpp")) sources.push_back(study);
  sources.push_back(root / "verify" / "engine" / "asked.cpp");
  sources.push_back(root / "verify" / "engine" / "case.cpp");
  sources.push_back(root / "verify" / "engine" / "read_scene.cpp");
  sources.push_back(root / "verify" / "engine" / "units.cpp");
  const ReadersSource source = scan(sources);
  Names leaves;
  for (const std::string& path : paths) leaves.insert(leaf(path));
  for (const std::string& key : source.keys) {
    INFO("cases/README.md lacks '" << key << "', which a reader knows");
    CHECK(leaves.contains(key));
  }
  // Keys that are computed: the forms of a tolerance, the parameters of the law, the points of a tensile
  // test, the paths in [assumed], walls of an axis, vectors, directions, lists of names, the place of what
  // cannot be planned. A new one needs its keys in the document and in a shipped case, and then its line
  // here.
  CHECK(source.computed == Names{"t.has(form",
                                 "t.number(given[0]",
                                 "table.has(parameter",
                                 "table.number_or_infinity(parameter",
                                 "table.number(missing.parameter",
                                 "exact.number(parameter",
                                 "exact.text(key",
                                 "table.text(key",
                                 "numbers.table(name",
                                 "t.has(points",
                                 "t.numbers(points",
                                 "table.text(path",
                                 "fluid.has(key",
                                 "fluid.table(key",
                                 "table.numbers(key",
                                 "table.integers(key",
                                 "table.has(key",
                                 "t.number(key",
                                 "t.integers(key",
                                 "top.table(bad.parameter.substr(0",
                                 "top.table(where",
                                 "s.text(key",
                                 "s.texts(key",
                                 "table.number(key",
                                 "check.has(key",
                                 "check.table(key",
                                 "study.tables(key",
                                 "top.has(kind.table",
                                 "top.table(found->table",
                                 "top.has(name",
                                 "top.table(name",
                                 "t.has(key",
                                 "table.choice(key",
                                 "walls.has(key",
                                 "walls.has(other",
                                 "walls.has(in",
                                 "walls.has(out",
                                 "walls.table(in",
                                 "walls.table(out"});
  Names spelt = source.keys;
  add(spelt, {"absolute",     "relative",     "digits",    "strains",        "stresses",      "<path>",
              "walls_x",      "walls_y",      "walls_z",   "low_velocity",   "high_velocity", "body_force",
              "direction",    "polarization", "centre",    "marker_spacing", "boxes",         "axes",
              "values",       "where",        "over",      "low_inflow",     "high_inflow",   "low_outflow",
              "high_outflow", "amplitude",    "wavenumber"});
  for (const bond::LawInfo& law : bond::laws()) {
    for (const bond::ParameterInfo& p : law.parameters) {
      INFO(law.name << " has " << p.name);
      CHECK(paths.contains("bond." + p.name));
      spelt.insert(p.name);
    }
  }
  for (const engine::Symbol& one : engine::symbols()) spelt.insert(one.symbol);
  CHECK(unread(paths, asked, spelt) == none);
}

TEST_CASE(
    "Every key that readers of references and the ledger ask for is in reference/README.md, and the other "
    "way round") {
  const Names paths = documented(references / "README.md");
  const Names asked = asked_of_references();
  CHECK(undocumented(asked, paths) == none);
  const fs::path engine = root / "verify" / "engine";
  const ReadersSource source = scan({engine / "reference.cpp", engine / "ledger.cpp"});
  CHECK(source.computed == Names{"values.table(name"});
  Names leaves;
  for (const std::string& path : paths) leaves.insert(leaf(path));
  leaves.insert("driver");  // by which a case is told from a reference
  for (const std::string& key : source.keys) {
    INFO("reference/README.md lacks '" << key << "', which a reader knows");
    CHECK(leaves.contains(key));
  }
  CHECK(unread(paths, asked, source.keys) == none);
}

TEST_CASE("The documents name every driver, law, tier and kind") {
  const std::string text = io::read_file(root / "cases" / "README.md");
  const engine::Readers readers = studies::readers();
  for (const engine::Driver& driver : readers.drivers)
    CHECK_THAT(text, ContainsSubstring("`" + driver.name + "`"));
  for (const std::string& law : bond::law_names()) CHECK_THAT(text, ContainsSubstring("`" + law + "`"));
  for (const std::string& tier : engine::tiers()) CHECK_THAT(text, ContainsSubstring("`" + tier + "`"));
  const std::string reference = io::read_file(references / "README.md");
  for (const std::string& kind : engine::reference_kinds()) {
    CHECK_THAT(reference, ContainsSubstring("`" + kind + "`"));
  }
  for (const std::string& kind : engine::claim_kinds()) {
    CHECK_THAT(reference, ContainsSubstring("`" + kind + "`"));
  }
}

TEST_CASE("The examples in the schema documents are valid") {
  std::vector<InputError> problems;
  const io::Table top = io::parse_document(toml_block(root / "cases" / "README.md", "[[check]]"), "example");
  const engine::Case c = engine::read_parts(top, "minimal.toml", studies::readers(), references, problems);
  for (const InputError& problem : problems) FAIL_CHECK(problem.what());
  CHECK(c.assumed.size() == 1);
  CHECK(c.assumed.front().value == "[ 4, 4, 12 ]");

  const io::Table reference =
      io::parse_document(toml_block(references / "README.md", "[values.rest_length]"), "example");
  CHECK(engine::read_reference(reference, "minimal-reference.toml").values.size() == 1);
  const io::Table ledger = io::parse_document(toml_block(references / "README.md", "[[claim]]"), "example");
  CHECK(engine::read_ledger(ledger).entries.size() == 1);
}

TEST_CASE("No table of a page is broken by an empty line") {
  std::vector<fs::path> pages = files(root / "docs", ".md");
  for (const fs::path& page : files(root / "docs" / "findings", ".md")) pages.push_back(page);
  for (const char* page :
       {"README.md", "ARCHITECTURE.md", "cases/README.md", "reference/README.md", "verify/README.md"})
    pages.push_back(root / page);
  for (const fs::path& page : pages) {
    std::vector<std::string> lines;
    std::istringstream text(io::read_file(page));
    for (std::string line; std::getline(text, line);) lines.push_back(line);
    lines.emplace_back();
    for (std::size_t i = 1; i + 1 < lines.size(); ++i) {
      const bool begins = lines[i].starts_with('|') && !lines[i - 1].starts_with('|');
      if (begins && !lines[i + 1].starts_with("|-"))
        FAIL_CHECK(page.string() << ":" << i + 1 << " begins a table without a head");
    }
  }
}

TEST_CASE("Cases, references, claims and bibliography of the repository agree") {
  CHECK(engine::problems_of_repository(root / "cases", references, studies::readers()) == none);
}

TEST_CASE("The ledger covers Eqs. 1-27, Figs. 1-8 and Appendix A") {
  std::string where;
  for (const engine::Entry& entry : engine::read_ledger(references).entries) where += " " + entry.where;
  std::set<int> equations, figures;
  for (const std::smatch& match : all_matches(where, "(Eqs?|Figs?)\\. ([0-9][-0-9, ]*)")) {
    const std::string numbers = match[2];
    for (const std::smatch& range : all_matches(numbers, "([0-9]+)(?:-([0-9]+))?")) {
      const int from = std::stoi(range[1]);
      const int to = range[2].matched ? std::stoi(range[2]) : from;
      for (int n = from; n <= to; ++n) (match.str(1)[0] == 'E' ? equations : figures).insert(n);
    }
  }
  for (int n = 1; n <= 27; ++n) CHECK(equations.contains(n));
  for (int n = 1; n <= 8; ++n) CHECK(figures.contains(n));
  CHECK_THAT(where, ContainsSubstring("Appendix A"));
}
