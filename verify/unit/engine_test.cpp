#include <omp.h>

#include <bit>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "catch.hpp"
#include "engine/baseline.hpp"
#include "engine/ledger.hpp"
#include "engine/result.hpp"
#include "engine/stored_result.hpp"
#include "engine/validate.hpp"
#include "exit_code.hpp"
#include "io/csv.hpp"
#include "io/file.hpp"
#include "io/hdf5.hpp"
#include "measures/drivers.hpp"
#include "repository.hpp"
#include "studies/studies.hpp"
#include "unit/command.hpp"

using namespace veriflex;
using namespace veriflex::engine;
using Json = nlohmann::json;
using unit::Folder;
using unit::good_case;
using unit::Ran;
using unit::replaced;

namespace {

const std::filesystem::path& references = repository::references();
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

Check check_of(double target, double absolute) {
  Check check{};
  check.measure = "length";
  check.target = target;
  check.tolerance.value = absolute;
  return check;
}

Verdict judged(const Check& check, double measured) {
  observe::Observations seen;
  seen.metrics.push_back({"length", measured, "L", ""});
  return judge(check, Case{}, seen).verdict;
}

// A curve y(x) held against the points (1, 10) and (2, 0), relative to max(|y|, 1).
Case curve_case() {
  Case c{};
  c.references.emplace_back();
  c.references.front().id = "points";
  c.references.front().columns = {{"x", {1.0, 2.0}}, {"y", {10.0, 0.0}}};
  Check check = check_of(0.0, 0.01);
  check.measure = "bend.y";
  check.curve = Curve{"bend", "x", "y"};
  check.tolerance.relative = true;
  check.tolerance.floor = 1.0;
  check.reference = 0;
  c.checks.push_back(check);
  return c;
}

Outcome judged_curve(std::vector<double> x, std::vector<double> y) {
  const Case c = curve_case();
  observe::Observations seen;
  seen.records.push_back({"bend", "", {{"x", "", "1", "", std::move(x)}, {"y", "", "1", "", std::move(y)}}});
  return judge(c.checks.front(), c, seen);
}

bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](double p, double q) {
    return std::bit_cast<std::uint64_t>(p) == std::bit_cast<std::uint64_t>(q);
  });
}

Result run_with(const Case& c, int threads) {
  omp_set_num_threads(threads);
  Result result = run_case(c, threads);
  omp_set_num_threads(1);
  return result;
}

Case shipped(const std::string& id) {
  return read_case(repository::cases() / (id + ".toml"), {}, studies::readers(), references);
}

// As a row of its study reads it, where it has one.
Case one_run_of(const std::string& id) {
  return read_case(repository::cases() / (id + ".toml"), {}, studies::readers_of_row(), references);
}

std::string named(const std::string& text, const std::string& id) {
  return replaced(text, "id = \"bad\"", "id = \"" + id + "\"");
}

}  // namespace

TEST_CASE("A check holds within its tolerance, its end included") {
  CHECK(judged(check_of(2.0, 0.5), 2.25) == Verdict::pass);
  CHECK(judged(check_of(2.0, 0.5), 1.5) == Verdict::pass);
  CHECK(judged(check_of(2.0, 0.5), 2.75) == Verdict::fail);
  Check relative = check_of(-4.0, 0.25);
  relative.tolerance.relative = true;
  CHECK(judged(relative, -5.0) == Verdict::pass);
  CHECK(judged(relative, -5.5) == Verdict::fail);
}

TEST_CASE(
    "Against a published value a check holds within the root of the sum of squares of three uncertainties") {
  Check check = check_of(100.0, 0.0);
  check.uncertainty = Uncertainty{.reference = 3.0, .numerical = 4.0, .input = 12.0};
  CHECK(judged(check, 113.0) == Verdict::pass);
  CHECK(judged(check, 87.0) == Verdict::pass);
  CHECK(judged(check, 113.1) == Verdict::fail);

  check.uncertainty = Uncertainty{.reference = 3.0, .numerical = 0.0, .input = 0.0, .gci = "gci(length)"};
  CHECK_THROWS_AS(judged(check, 100.0), NumericalFailure);  // the study did not say it
  observe::Observations seen;
  seen.metrics = {{"length", 105.0, "L", ""}, {"gci(length)", 4.0, "L", ""}};
  const Outcome outcome = judge(check, Case{}, seen);
  CHECK(outcome.verdict == Verdict::pass);
  CHECK(outcome.tolerance == 5.0);
  CHECK(outcome.margin == 1.0);
  REQUIRE(outcome.uncertainty);
  CHECK(outcome.uncertainty->numerical == 4.0);
}

TEST_CASE("A check for outside holds where one for within does not") {
  Check check = check_of(2.0, 0.5);
  check.outside = true;
  CHECK(judged(check, 3.0) == Verdict::pass);
  CHECK(judged(check, 2.25) == Verdict::fail);
  CHECK(judged(check, 2.0) == Verdict::fail);
}

TEST_CASE("A refuted claim is a finding only while it stays refuted by as much") {
  Check check = check_of(2.0, 0.5);
  check.kind = CheckKind::claim;
  check.refuted = Recorded{3.0, 0.01};
  CHECK(judged(check, 3.0) == Verdict::finding);
  CHECK(judged(check, 3.02) == Verdict::finding);
  CHECK(judged(check, 3.2) == Verdict::fail);  // departed from what was recorded
  CHECK(judged(check, 2.2) == Verdict::fail);  // holds, though recorded as refuted
  check.refuted = Recorded{2.2, 0.01};
  CHECK(judged(check, 2.2) == Verdict::fail);  // as recorded, but that is no refutation
}

TEST_CASE("What was not measured, or is no number, is no verdict") {
  CHECK_THROWS_AS(judged(check_of(2.0, 0.5), not_a_number), NumericalFailure);
  CHECK_THROWS_AS(judge(check_of(2.0, 0.5), Case{}, {}), NumericalFailure);
}

TEST_CASE("A curve is judged by its largest error at the reference's points") {
  const Outcome good = judged_curve({2.0, 1.5, 1.0}, {0.005, 1e9, 10.05});
  CHECK(good.verdict == Verdict::pass);
  CHECK(good.measured == Approx(0.005));
  CHECK(judged_curve({1.0, 2.0}, {10.0, 0.02}).verdict == Verdict::fail);
  CHECK_THROWS_AS(judged_curve({1.0}, {10.0}), NumericalFailure);  // a point is missing
  CHECK_THROWS_AS(judged_curve({1.0, 2.0}, {10.0, not_a_number}), NumericalFailure);
  CHECK_THROWS_AS(judged_curve({1.0, 2.0}, {not_a_number, 0.0}), NumericalFailure);
  CHECK_THROWS_AS(judge(curve_case().checks.front(), curve_case(), {}), NumericalFailure);  // no record
  // Which of two values at one point would be meant is not known.
  CHECK_THROWS_WITH(judged_curve({1.0, 2.0, 1.0}, {10.0, 0.0, 11.0}), ContainsSubstring("more than once"));
}

TEST_CASE("Nothing measured where nothing is expected is no error, even without a floor") {
  Case c = curve_case();
  c.checks.front().tolerance.floor = 0.0;
  c.references.front().columns[1].values = {10.0, 0.0};
  observe::Observations seen;
  seen.records.push_back({"bend", "", {{"x", "", "1", "", {1.0, 2.0}}, {"y", "", "1", "", {10.0, 0.0}}}});
  CHECK(judge(c.checks.front(), c, seen).error == 0.0);
  seen.records.front().columns[1].values[1] = 1e-30;
  CHECK_THROWS_AS(judge(c.checks.front(), c, seen), NumericalFailure);  // endlessly far off
}

TEST_CASE("A case fails when a check fails, and findings are no failures") {
  Outcome passed{}, failed{}, finding{};
  passed.verdict = Verdict::pass;
  failed.verdict = Verdict::fail;
  finding.verdict = Verdict::finding;
  CHECK(overall({passed, finding}) == Verdict::pass);
  CHECK(overall({passed, failed, finding}) == Verdict::fail);
}

TEST_CASE("Exit codes: the first of 4, 2, 3, 1") {
  const std::vector<int> order{4, 2, 3, 1, 0};
  for (std::size_t i = 0; i < order.size(); ++i) {
    for (std::size_t j = i; j < order.size(); ++j) {
      CHECK(exit_code::first_of(order[i], order[j]) == order[i]);
      CHECK(exit_code::first_of(order[j], order[i]) == order[i]);
    }
  }
}

TEST_CASE("The same case gives the same bits, whatever the number of threads") {
  for (const std::string id :
       {"tensile-fene-lj-curve", "derive-fene-lj", "elastica-chain-fene-lj", "buckling-chain",
        "torsion-harmonic", "integrator-fene-lj", "dispersion-chain-fene-lj", "wave-sound-axis",
        "vortex-planes", "channel-womersley", "conservation-closed"}) {
    const Case c = one_run_of(id);
    const Result one = run_with(c, 1);
    const Result again = run_with(c, 1);
    const Result two = run_with(c, 2);
    for (const Result* other : {&again, &two}) {
      REQUIRE(other->seen.records.size() == one.seen.records.size());
      for (std::size_t r = 0; r < one.seen.records.size(); ++r) {
        for (const observe::Column& column : one.seen.records[r].columns) {
          INFO(id << " " << one.seen.records[r].name << "." << column.name);
          const observe::Column* same = other->seen.records[r].find(column.name);
          REQUIRE(same != nullptr);
          CHECK(same_bits(same->values, column.values));
        }
      }
      REQUIRE(other->seen.metrics.size() == one.seen.metrics.size());
      for (std::size_t m = 0; m < one.seen.metrics.size(); ++m) {
        CHECK(same_bits({other->seen.metrics[m].value}, {one.seen.metrics[m].value}));
      }
    }
  }
}

TEST_CASE("What a run declares and what it measures are the same, else the program is wrong") {
  const auto ends = [](auto run) {
    Case c{};
    c.id = "made-up";
    c.study.declares.metrics = {{"length", {}, "L", ""}};
    c.study.declares.records = {{"line", "", {{"x", "", "L", "", {}}}}};
    c.study.run = [run](observe::Observations& seen, Progress&, Cost&) { run(seen); };
    return run_case(c, 1);
  };
  const Result whole = ends([](observe::Observations& seen) { seen.set("length", 1.0); });
  CHECK(whole.verdict == Verdict::measured);
  CHECK(whole.seen.records.empty());  // nothing was put into the line
  const Result lacks = ends([](observe::Observations&) {});
  CHECK(lacks.error_kind == "internal");
  CHECK_THAT(lacks.error_message, ContainsSubstring("'length' is declared and was not measured"));
  const Result more = ends([](observe::Observations& seen) {
    seen.set("length", 1.0);
    seen.metrics.push_back({"width", 1.0, "L", ""});
  });
  CHECK_THAT(more.error_message, ContainsSubstring("'width' was measured and is not declared"));
}

TEST_CASE("A case that needs what the program lacks is skipped and never passes") {
  Case c{};
  c.id = "made-up";
  c.study.declares.metrics = {{"length", {}, "L", ""}};
  c.study.lacks = "this program was built without wings. Grow some";
  bool was_run = false;
  c.study.run = [&](observe::Observations& seen, Progress&, Cost&) {
    was_run = true;
    seen.set("length", 1.0);
  };
  c.checks.push_back(check_of(1.0, 0.5));
  const Result result = run_case(c, 1, 3);
  CHECK(!was_run);
  CHECK(result.verdict == Verdict::skipped);
  CHECK(result.outcome() == "skipped");
  CHECK(result.outcomes.empty());
  CHECK(result.seen.metrics.empty());
  const Folder folder;
  write_result(result, folder.path());
  const StoredResult stored = read_result(folder.path() / "made-up.h5");
  CHECK(stored.verdict == "skipped");
  CHECK(stored.outcome == "skipped");
  CHECK(stored.error_kind == "lacking");
  CHECK(stored.error_message == c.study.lacks);
  CHECK(exit_code::of_error(stored.error_kind) == exit_code::skipped);
  CHECK(exit_code::first_of(exit_code::skipped, exit_code::success) == exit_code::skipped);
  CHECK(exit_code::first_of(exit_code::skipped, exit_code::check_failed) == exit_code::check_failed);
}

TEST_CASE("The multirate case passes where SUNDIALS is built in and is skipped with the remedy elsewhere") {
  const Case c = shipped("oscillation-multirate");
  const Folder folder;
  const std::string id = "oscillation-multirate";
  const Ran ran = folder.run({"run", id, "--out", "out", "--junit", "junit.xml"});
  const std::string xml = unit::contents(folder.path() / "junit.xml");
  if (c.study.lacks.empty()) {
    CHECK(ran.code == exit_code::success);
    CHECK_THAT(ran.out, StartsWith("pass"));
    CHECK_THAT(xml, ContainsSubstring("skipped=\"0\""));
    return;
  }
  CHECK_THAT(c.study.lacks, ContainsSubstring("apt-get install libsundials-dev"));
  CHECK(ran.code == exit_code::skipped);
  CHECK_THAT(ran.out, StartsWith("skipped"));
  CHECK_THAT(ran.out, ContainsSubstring(c.study.lacks));
  CHECK(ran.err.empty());
  CHECK_THAT(xml, ContainsSubstring("errors=\"0\" skipped=\"1\""));
  CHECK_THAT(folder.run({"plan", id}).out, ContainsSubstring(c.study.lacks));
  const Ran verified = folder.run({"verify", id, "--out", "out"});
  CHECK(verified.code == exit_code::success);
  CHECK_THAT(verified.out, ContainsSubstring("0 pass, 0 fail, 0 error, 1 skipped"));
  // A sweep goes on with the other rows.
  const Ran swept = folder.run({"sweep", "oscillation-chain", "--out", "out", "--over",
                                "oscillation.integrator=\"leap-frog\",\"multirate\""});
  CHECK(swept.code == exit_code::success);
  CHECK_THAT(swept.out, ContainsSubstring("skipped"));
}

TEST_CASE("A result file gives back what was put in") {
  const Folder folder;
  const Result result = run_with(shipped("derive-fene-lj"), 1);
  write_result(result, folder.path());
  const io::Hdf5File file(folder.path() / "derive-fene-lj.h5");
  CHECK(file.attribute("/", "id") == "derive-fene-lj");
  CHECK(file.attribute("/", "verdict") == "pass");
  std::vector<double> values;
  std::vector<std::string> names, dimensions, meanings;
  for (const observe::Metric& metric : result.seen.metrics) {
    values.push_back(metric.value);
    names.push_back(metric.name);
    dimensions.push_back(metric.dimension);
    meanings.push_back(metric.meaning);
  }
  CHECK(same_bits(file.numbers("/metrics/value"), values));
  CHECK(file.texts("/metrics/name") == names);
  CHECK(file.texts("/metrics/dimension") == dimensions);
  CHECK(file.texts("/metrics/meaning") == meanings);
  CHECK(file.texts("/checks/verdict").size() == result.outcomes.size());
  for (const double none : file.numbers("/checks/uncertainty_numerical")) CHECK(std::isnan(none));
  CHECK_THROWS_AS(file.numbers("/checks/verdict"), InputError);
  CHECK_THROWS_AS(file.texts("/metrics/value"), InputError);
  CHECK_THROWS_AS(file.texts("/nothing"), InputError);
  CHECK_THROWS_AS(file.attribute("/", "schema"), InputError);
}

TEST_CASE("CSV: comments, spaces and line ends of both kinds") {
  const auto columns = io::parse_csv("# a table\r\n\r\n x , y \r\n1, -2.5e-3\r\n# between\n 3,4", "t.csv");
  REQUIRE(columns.size() == 2);
  CHECK(columns[0].name == "x");
  CHECK(columns[1].name == "y");
  CHECK(columns[0].values == std::vector<double>{1.0, 3.0});
  CHECK(columns[1].values == std::vector<double>{-2.5e-3, 4.0});
  const auto marked = io::parse_csv("\xEF\xBB\xBFx,y\n+1,+2.5e+3\n", "t.csv");  // as spreadsheets write it
  CHECK(marked[0].name == "x");
  CHECK(marked[0].values == std::vector<double>{1.0});
  CHECK(marked[1].values == std::vector<double>{2500.0});
  for (const std::string bad : {"x\n0x10\n", "x\n1 2\n", "x\n+-1\n", "x\n+\n", "x\ninf\n", "x\n1;2\n"}) {
    CHECK_THROWS_AS(io::parse_csv(bad, "t.csv"), InputError);
  }
}

TEST_CASE("SHA-256 of the standard's examples") {
  CHECK(io::sha256("") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  CHECK(io::sha256("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST_CASE(
    "Documents: dots within texts and comments are no parts of a key, whatever is escaped before them") {
  const std::string dots(100, '.');
  for (const std::string text :
       {"\"\\\\\"", "\"\\\"\"", "'\\'", "\"\"\"\\\\\"\"\"", "\"\"\"a\"b\"\"\"", "'''it's'''"}) {
    CAPTURE(text);
    const io::Table top =
        io::parse_document("a = [" + text + ", \"" + dots + "\"]  # " + dots + "\nb = 1\n", "t.toml");
    CHECK(top.shown("b") == "1");
  }
}

TEST_CASE("Documents: a key may have sixteen parts, and no more") {
  std::string key = "a";
  for (int part = 1; part < 16; ++part) key += ".a";
  CHECK(io::parse_document(key + " = 1\n", "t.toml").shown(key) == "1");
  CHECK_THROWS_WITH(io::parse_document(key + ".a = 1\n", "t.toml"), ContainsSubstring("more than 16 parts"));
  CHECK_THROWS_WITH(io::parse_document("x = 1\n\ny = \"\"\"of\ntwo\"\"\"\n" + key + ".a = 1\n", "t.toml"),
                    StartsWith("t.toml:5:"));
}

TEST_CASE("Documents: dotted paths show values, and every unknown key is named") {
  const io::Table top = io::parse_document("a = 1\n[b]\nc = [1, 2]\n[[d]]\ne = \"x\"\nf = 1\n", "t.toml");
  CHECK(top.shown("a") == "1");
  CHECK(top.shown("b.c") == "[ 1, 2 ]");
  CHECK(top.shown("b.c.1") == "2");
  CHECK(top.shown("d.0.e") == "'x'");
  for (const char* path : {"", "x", "a.b", "b.c.7", "d.e", "b.", ".b"}) CHECK_FALSE(top.shown(path));
  CHECK(top.tables("d").front().text("e") == "x");
  CHECK(top.unknown_keys().size() == 3);  // a, b, d.0.f
  CHECK(top.asked() == std::vector<std::string>{"d", "d[].e"});
}

TEST_CASE("run --json has the keys that programs rely on") {
  const Folder folder;
  folder.write("bad.toml", good_case);
  const Ran ran = folder.run({"run", "bad.toml", "derive-fene-lj", "--json", "--out", "out"});
  CHECK(ran.code == 0);
  const Json all = Json::parse(ran.out);
  REQUIRE(all.size() == 2);
  CHECK(all[0]["id"] == "bad");
  CHECK(all[0]["verdict"] == "pass");
  CHECK(all[0]["wall_seconds"].is_number());
  CHECK(all[0]["result"] == "out/bad.h5");
  CHECK(all[0]["warnings"].empty());
  CHECK(all[0]["checks"][0]["holds"] == "within");
  bool found = false;
  for (const Json& metric : all[0]["metrics"]) {
    for (const char* key : {"name", "value", "dimension", "meaning"}) CHECK(metric.contains(key));
    found =
        found || (metric["name"] == "young_modulus" && metric["value"] == all[0]["checks"][0]["measured"]);
  }
  CHECK(found);
  CHECK(all[1]["findings"] == 4);
  for (const char* key : {"metric", "measured", "target", "tolerance", "margin", "verdict"}) {
    CHECK(all[0]["checks"][0].contains(key));
  }
}

TEST_CASE("derive and calibrate --json have the same keys for every law, null for what it lacks") {
  const Folder folder;
  const std::vector<std::vector<std::string>> laws{
      {"--law", "fene-lj", "--epsilon", "1", "--sigma", "1"},
      {"--law", "harmonic", "--bond-stiffness", "1", "--rest-length", "1"},
      {"--law", "shifted-fene", "--bond-stiffness", "1", "--rest-length", "1", "--extension", "0.5"}};
  for (const std::vector<std::string>& law : laws) {
    INFO(law[1]);
    std::vector<std::string> arguments{"derive", "--json"};
    arguments.insert(arguments.end(), law.begin(), law.end());
    const Json derived = Json::parse(folder.run(arguments).out);
    for (const char* key :
         {"rest_length", "stiffness", "force_per_strain", "young_modulus", "stiffness_over_fene_k",
          "strain_at_r_max", "min_tangent_ratio", "min_tangent_strain", "validity"}) {
      CHECK(derived.contains(key));
    }
    CHECK(derived["stiffness_over_fene_k"].is_null() == (law[1] != "fene-lj"));
    CHECK(derived["strain_at_r_max"].is_null() == (law[1] == "harmonic"));
    CHECK(derived["validity"].size() == 3);
    const std::vector<std::string> shape = law[1] == "shifted-fene"
                                               ? std::vector<std::string>{"--extension", "0.5"}
                                               : std::vector<std::string>{};
    arguments = {"calibrate", "--young", "0.26",   "--spacing", "1",
                 "--poisson", "0.3",     "--json", "--law",     law[1]};
    arguments.insert(arguments.end(), shape.begin(), shape.end());
    const Ran ran = folder.run(arguments);
    INFO(ran.err);
    const Json calibrated = Json::parse(ran.out);
    for (const char* key :
         {"epsilon", "sigma", "bond_stiffness", "angle_stiffness", "rest_length", "validity"}) {
      CHECK(calibrated.contains(key));
    }
    CHECK(calibrated["epsilon"].is_null() == (law[1] != "fene-lj"));
    CHECK(calibrated["bond_stiffness"].is_null() == (law[1] == "fene-lj"));
    CHECK(calibrated["rest_length"].get<double>() == Approx(1.0));
  }
}

TEST_CASE("Several cases in one run: the exit code is the gravest, and every case has its say") {
  const Folder folder;
  folder.write("passes.toml", named(good_case, "passes"));
  folder.write("fails.toml", replaced(named(good_case, "fails"), "target = 1021", "target = 1022"));
  // The curve's point at strain 0.02 is not measured: the case cannot answer.
  folder.write("points.csv", "strain,stress\n0.02,1.0\n");
  folder.write(
      "points.toml",
      "schema = 1\nid = \"points\"\nkind = \"analytic\"\nsource = \"s\"\nobtained = \"o\"\n[data]\nfile = "
      "\"points.csv\"\nsha256 = \"" +
          io::sha256("strain,stress\n0.02,1.0\n") + "\"\n");
  const std::string check =
      "[[check]]\nkind = \"verification\"\nstatement = \"s\"\ncurve = { record = \"stress_strain\", x = "
      "\"strain\", y = "
      "\"stress\" }\nreference = \"points\"\ntolerance = { relative = 0.1, floor = 1.0, reason = \"r\" }\n";
  folder.write("errs.toml", named(good_case, "errs") + check);
  folder.write("broken.toml", "schema = 2\n");
  const auto code = [&](const std::vector<std::string>& cases, const std::string& out) {
    std::vector<std::string> arguments{"run", "--out", out};
    arguments.insert(arguments.end(), cases.begin(), cases.end());
    return folder.run(arguments).code;
  };
  CHECK(code({"passes.toml"}, "out") == 0);
  CHECK(code({"fails.toml", "passes.toml"}, "out") == 1);
  CHECK(code({"fails.toml", "errs.toml", "passes.toml"}, "out") == 3);
  CHECK(code({"errs.toml", "broken.toml", "fails.toml"}, "out") == 2);
  CHECK(code({"broken.toml", "passes.toml"}, "passes.toml/out") == 4);
  const io::Hdf5File error(folder.path() / "out/errs.h5");
  CHECK(error.attribute("/", "verdict") == "error");
  CHECK_THAT(error.attribute("/", "error_message"),
             ContainsSubstring("did not measure stress_strain.stress"));
  CHECK(io::Hdf5File(folder.path() / "out/broken.h5").attribute("/", "error_kind") == "input");
}

TEST_CASE("A case outside the repository with its reference beside it runs, and is told apart from one") {
  const Folder folder;
  folder.write("bad.toml", replaced(good_case,
                                    "target = 1021.186296534041763399964\ntarget_kind = "
                                    "\"high-precision\"\nsource = \"40-digit arithmetic\"",
                                    "reference = \"mine\""));
  folder.write("mine.toml",
               "schema = 1\nid = \"mine\"\nkind = \"peer-code\"\nsource = \"another program\"\nobtained = "
               "\"by running it\"\n"
               "[values.young_modulus]\nvalue = 1021.186296534\nuncertainty = 1e-9\ndimension = \"M L^-1 "
               "T^-2\"\nmeaning = \"E\"\n");
  const Ran ran = folder.run({"run", "bad.toml"});
  INFO(ran.err);
  CHECK(ran.code == 0);
  CHECK(io::Hdf5File(folder.path() / "results/bad.h5").texts("/checks/reference") ==
        std::vector<std::string>{"mine"});
  CHECK(folder.run({"validate", "bad.toml"}).code == 0);
}

TEST_CASE("info prints the rerun line, the checks and the provenance of references") {
  const Folder folder;
  folder.write("it's/bad.toml", good_case + "[assumed]\n\"solid.nodes\" = \"not given\"\n");
  const Ran ran = folder.run({"info", "it'\\''s/bad.toml"});
  CHECK(ran.code == 0);
  CHECK_THAT(ran.out, ContainsSubstring("veriflex run 'it'\\''s/bad.toml'"));
  CHECK_THAT(ran.out, ContainsSubstring("solid.nodes = [ 2, 2, 4 ]: not given"));
  CHECK_THAT(ran.out, ContainsSubstring("tolerance 1e-09 relative: differences of forces"));
  CHECK_THAT(folder.run({"info", "derive-fene-lj"}).out,
             ContainsSubstring("reference/fene_lj.py rest-state"));
}

TEST_CASE(
    "accept writes a baseline that a check can be held against, and renews it with the difference shown") {
  const Folder folder;
  folder.write("bad.toml", good_case);
  const std::string reason = "first \"light\"\tC:\\";
  CHECK(folder.run({"accept", "bad.toml", "--reason", reason}).code == 0);
  const Reference first = read_reference(folder.path() / "bad-baseline.toml");
  CHECK(first.kind == "baseline");
  CHECK(first.origin->reason == reason);
  const Result result =
      run_with(read_case(folder.path() / "bad.toml", {}, studies::readers(), references), 1);
  REQUIRE(first.values.size() == result.seen.metrics.size());
  for (const Change& change : changes(first, result.seen)) {
    REQUIRE((change.earlier && change.now));
    CHECK(same_bits({*change.earlier}, {*change.now}));
  }
  folder.write("bad.toml",
               replaced(replaced(good_case, "epsilon = 1.0", "epsilon = 2.0"),
                        "target = 1021.186296534041763399964", "target = 2042.372593068083526799928"));
  const Ran asked = folder.run({"accept", "bad.toml", "--reason", "twice as deep"});
  CHECK(asked.code == 2);
  CHECK_THAT(asked.out, ContainsSubstring("relative change"));
  CHECK_THAT(asked.err, ContainsSubstring("holds other values"));
  CHECK(read_reference(folder.path() / "bad-baseline.toml").origin->reason == reason);
  const Ran renewed = folder.run({"accept", "bad.toml", "--reason", "twice as deep", "--replace"});
  CHECK(renewed.code == 0);
  CHECK_THAT(renewed.out, ContainsSubstring("relative change"));
  CHECK(read_reference(folder.path() / "bad-baseline.toml").values.at("young_modulus").value ==
        Approx(2.0 * first.values.at("young_modulus").value));
}

TEST_CASE("accept refuses a case that does not pass, and leaves the earlier baseline") {
  const Folder folder;
  folder.write("bad.toml", good_case);
  REQUIRE(folder.run({"accept", "bad.toml", "--reason", "first"}).code == 0);
  const std::string earlier = unit::contents(folder.path() / "bad-baseline.toml");
  folder.write("bad.toml", replaced(good_case, "target = 1021", "target = 1022"));
  const Ran ran = folder.run({"accept", "bad.toml", "--reason", "x", "--replace"});
  CHECK(ran.code == 1);
  CHECK_THAT(ran.err, ContainsSubstring("not accepted, its verdict is fail"));
  CHECK(unit::contents(folder.path() / "bad-baseline.toml") == earlier);
}

TEST_CASE("The ledger shows what result files say, and what no case judges") {
  const Folder folder;
  REQUIRE(folder.run({"run", "derive-fene-lj", "--out", "results"}).code == 0);
  folder.write("more/derive-fene-lj.h5", "damaged");
  const Ran damaged = folder.run({"claims", "--results", "results", "more"});
  CHECK(damaged.code == 2);
  CHECK_THAT(damaged.err, ContainsSubstring("derive-fene-lj.h5"));
  CHECK_THAT(damaged.out, ContainsSubstring("rest-length: holds"));
  std::filesystem::remove_all(folder.path() / "more");
  REQUIRE(folder.run({"run", "derive-fene-lj", "derive-fene-lj-as-printed", "--out", "more"}).code == 0);
  const Ran both = folder.run({"claims", "--results", "results", "more"});
  CHECK(both.code == 0);
  CHECK_THAT(both.err, ContainsSubstring("left out"));
  CHECK_THAT(both.out, ContainsSubstring("fene-potential: refuted in part"));
  const Ran ran = folder.run({"claims", "--json"});
  CHECK(ran.code == 0);
  const Json ledger = Json::parse(ran.out);
  CHECK(ledger["citation"] == "wu-qi-2014");
  std::map<std::string, Json> entries;
  std::map<std::string, std::string> standings;
  int counted = 0;
  for (const Json& entry : ledger["claims"]) {
    entries[entry["id"]] = entry["judgements"];
    standings[entry["id"]] = entry["standing"];
  }
  for (const auto& [standing, count] : ledger["counts"].items()) counted += count.get<int>();
  CHECK(counted == static_cast<int>(entries.size()));
  CHECK(entries.at("rest-length")[0]["verdict"] == "pass");
  CHECK(entries.at("young-modulus").size() == 3);
  CHECK(entries.at("young-modulus")[0]["verdict"] == "finding");
  CHECK(entries.at("same-modulus")[0]["verdict"] == "not run");
  CHECK(entries.at("drive").empty());
  CHECK(standings.at("rest-length") == "holds");
  CHECK(standings.at("young-modulus") == "refuted in part");
  CHECK(standings.at("first-order") == "refuted");
  CHECK(standings.at("drive") == "not decidable");
  CHECK(standings.at("same-modulus") == "not run");
  const Json& far = entries.at("attraction-is-not-stiffness")[0];
  CHECK(far["holds"] == "outside");
  CHECK(far["target_kind"] == "analytic");
  const Ran text = folder.run({"claims"});
  CHECK(text.code == 0);
  CHECK_THAT(text.out, ContainsSubstring("not run  tensile-fene-lj"));
  CHECK_THAT(text.out, ContainsSubstring("must lie beyond 1 +- 0.1"));
  CHECK_THAT(text.out, ContainsSubstring("published 942.8515"));
  CHECK_THAT(text.out, ContainsSubstring("target 0.01"));
  CHECK_THAT(text.out, ContainsSubstring("duct: not run (exact-law; white-2006)"));
  CHECK_THAT(text.out, ContainsSubstring("turek-hron-fsi3: not run (not-compared"));
  const Ran nowhere = folder.run({"claims", "--results", "nowhere"});
  CHECK(nowhere.code == 2);
  CHECK_THAT(nowhere.err, ContainsSubstring("nowhere: no folder of results (it does not exist)"));
}

TEST_CASE("A benchmark says who agrees, within which tolerance and at which cost") {
  const Folder folder;
  REQUIRE(folder.run({"run", "channel-duct", "--out", "results"}).code == 0);
  const Ran text = folder.run({"claims"});
  CHECK_THAT(text.out, ContainsSubstring("duct: agrees"));
  CHECK_THAT(text.out, ContainsSubstring("% off, within 0.2 % (tolerance)"));
  const Json benchmarks = Json::parse(folder.run({"claims", "--json"}).out)["benchmarks"];
  const auto duct = std::find_if(benchmarks.begin(), benchmarks.end(),
                                 [](const Json& entry) { return entry["id"] == "duct"; });
  REQUIRE(duct != benchmarks.end());
  CHECK((*duct)["standing"] == "holds");
  const Json& found = (*duct)["judgements"][0];
  CHECK(found["case"] == "channel-duct");
  CHECK(found["is_uncertainty"] == false);
  CHECK(found["wall_seconds"].get<double>() > 0.0);
}

TEST_CASE("A ledger of benchmarks is held against its cases and the bibliography") {
  const Folder folder;
  const std::filesystem::path shelf = folder.path() / "reference";
  const std::string law =
      "schema = 1\n[[claim]]\nid = \"law\"\nwhere = \"derived here\"\nkind = \"exact-law\"\nstates = "
      "\"E\"\njudged_by = [\"bad\"]\n";
  const std::string open = replaced(replaced(law, "exact-law", "not-compared"), "[\"bad\"]", "[]");
  const auto problems = [&](const std::string& benchmark, const std::string& ledger) {
    folder.write("cases/bad.toml",
                 replaced(good_case, "kind = \"verification\"", "kind = \"verification\"\n" + benchmark));
    folder.write("reference/claims/benchmarks.toml", ledger);
    std::string text;
    for (const std::string& problem :
         problems_of_repository(folder.path() / "cases", shelf, studies::readers()))
      text += problem + "\n";
    return text;
  };
  folder.write("reference/bibliography.bib", "@article{wu-qi-2014,\n}\n");
  folder.write("reference/claims/wu-qi-2014.toml", "schema = 1\ncitation = \"wu-qi-2014\"\n");
  const std::string cited = "benchmark = \"law\"";
  CHECK(problems(cited, law).empty());
  CHECK_THAT(problems("", law), ContainsSubstring("'bad' does not judge 'law'"));
  CHECK_THAT(problems("benchmark = \"lav\"", law),
             ContainsSubstring("has no claim 'lav' (benchmarks stand in"));
  CHECK_THAT(problems(cited, replaced(law, "exact-law", "published-number")),
             ContainsSubstring("the bibliography has no 'derived'"));
  CHECK_THAT(problems("", open), ContainsSubstring("'law' is not compared without a reason"));
  const std::string said = replaced(open, "derived here", "wu-qi-2014") + "notes = \"no case\"\n";
  CHECK(problems("", said).empty());
  CHECK_THAT(problems(cited, said), ContainsSubstring("the ledger calls 'law' not compared (no case)"));
}

TEST_CASE("validate finds what is wrong between cases, references, ledger and bibliography") {
  const Folder folder;
  const std::filesystem::path cases = folder.path() / "cases";
  const std::filesystem::path shelf = folder.path() / "reference";
  const std::string claim =
      replaced(good_case, "kind = \"verification\"", "kind = \"claim\"\nclaim = \"modulus\"");
  const std::string ledger =
      "schema = 1\ncitation = \"wu-qi-2014\"\n[[claim]]\nid = \"modulus\"\nwhere = \"Eq. 1\"\nkind = "
      "\"reading\"\nstates = "
      "\"E\"\n"
      "judged_by = [\"bad\"]\n";
  const std::string reference =
      "schema = 1\nid = \"spare\"\nkind = \"analytic\"\nsource = \"s\"\nobtained = \"o\"\n[values.x]\nvalue "
      "= 1\n"
      "dimension = \"1\"\nmeaning = \"x\"\n";
  const auto problems = [&] {
    std::string text;
    for (const std::string& problem : problems_of_repository(cases, shelf, studies::readers()))
      text += problem + "\n";
    return text;
  };
  folder.write("cases/bad.toml", claim);
  folder.write("reference/bibliography.bib", "@article{wu-qi-2014,\n}\n");
  folder.write("reference/claims/wu-qi-2014.toml", ledger);
  CHECK(problems().empty());

  folder.write("reference/spare.toml", reference);
  CHECK_THAT(problems(), ContainsSubstring("spare.toml: no case uses this reference"));
  std::filesystem::remove(shelf / "spare.toml");

  folder.write("cases/bad.toml", replaced(claim, "wu-qi-2014, Eq. 13", "wu-qi-2041, Eq. 13"));
  CHECK_THAT(problems(), ContainsSubstring("bad.toml:6:11: the bibliography has no 'wu-qi-2041'"));
  folder.write("cases/bad.toml", good_case);
  CHECK_THAT(problems(), ContainsSubstring("wu-qi-2014.toml:8:13: 'bad' does not judge 'modulus'"));
  folder.write("cases/bad.toml", claim);
  folder.write("reference/claims/wu-qi-2014.toml", replaced(ledger, "[\"bad\"]", "[\"other\"]"));
  CHECK_THAT(problems(), ContainsSubstring("'bad' is missing in judged_by of 'modulus'"));
  folder.write("reference/claims/wu-qi-2014.toml", replaced(ledger, "[\"bad\"]", "[]"));
  CHECK_THAT(problems(), ContainsSubstring("no case judges 'modulus'"));
  const std::string open = replaced(ledger, "\"reading\"", "\"not-decidable\"");
  folder.write("reference/claims/wu-qi-2014.toml", open);
  CHECK_THAT(problems(), ContainsSubstring("cases judge 'modulus', which is not decidable"));
  folder.write("reference/claims/wu-qi-2014.toml", replaced(open, "[\"bad\"]", "[]"));
  CHECK_THAT(problems(), ContainsSubstring("'modulus' is not decidable without a reason"));
  folder.write("reference/claims/wu-qi-2014.toml", replaced(open, "[\"bad\"]", "[]\nnotes = \"a choice\""));
  CHECK_THAT(problems(), ContainsSubstring("the ledger calls 'modulus' not decidable (a choice)"));
  folder.write("reference/claims/wu-qi-2014.toml", ledger + ledger.substr(ledger.find("[[claim]]")));
  CHECK_THAT(problems(), ContainsSubstring("claim 'modulus' stands here twice"));
}
