// What two runs say differently.
#include "engine/difference.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "catch.hpp"
#include "unit/command.hpp"

using namespace veriflex;
namespace fs = std::filesystem;
using engine::StoredCheck;
using engine::StoredResult;
using unit::Folder;
using unit::good_case;
using unit::Ran;
using unit::replaced;
using Json = nlohmann::json;

namespace {

StoredCheck check(const std::string& metric, const std::string& verdict, double margin) {
  StoredCheck made{};
  made.metric = metric;
  made.statement = metric + " is right";
  made.verdict = verdict;
  made.holds = "within";
  made.measured = margin;
  made.error = margin;
  made.tolerance = 1.0;
  made.margin = margin;
  return made;
}

StoredResult result(const std::string& id) {
  StoredResult made{};
  made.id = id;
  made.verdict = "pass";
  made.outcome = "completed";
  made.machine = "m";
  made.threads = 2;
  made.checks = {check("length", "pass", 0.5)};
  made.metrics = {{"length", 2.0, "L", ""}, {"mass", 3.0, "M", ""}};
  made.records = {{"path", "", {{"x", "", "L", "", {1.0, 2.0}}}}};
  return made;
}

}  // namespace

TEST_CASE("Two runs of the same numbers are the same, whatever their times") {
  StoredResult before = result("a"), after = result("a");
  before.wall_seconds = 1.0;
  after.wall_seconds = 1.2;
  after.date = "later";
  before.records.push_back({"sweep_cost", "", {{"wall_seconds", "", "s", "", {1.0}}}});
  after.records.push_back({"sweep_cost", "", {{"wall_seconds", "", "s", "", {2.0}}}});
  const engine::RunDifference d = engine::difference(std::vector{before}, std::vector{after});
  CHECK(d.is_same());
  CHECK(d.worse.empty());
  CHECK(d.cases[0].same_metrics == 2);
  CHECK(d.cases[0].same_checks == 1);
}

TEST_CASE("A change in the last bit is a change, and by how much is said") {
  StoredResult after = result("a");
  after.metrics[0].value = std::nextafter(2.0, 3.0);
  after.records[0].columns[0].values[1] = 2.5;
  const engine::CaseDifference d = engine::difference(result("a"), after);
  CHECK(!d.is_same());
  CHECK(d.worse.empty());
  REQUIRE(d.metrics.size() == 1);
  CHECK(d.metrics[0].relative == Approx(2.2e-16).epsilon(0.02));
  REQUIRE(d.records.size() == 1);
  CHECK(d.records[0].relative == Approx(0.2));
}

TEST_CASE("A check that measured another number is a change, though it passes as before") {
  StoredResult after = result("a");
  after.checks[0].measured = std::nextafter(0.5, 1.0);
  const engine::CaseDifference d = engine::difference(result("a"), after);
  CHECK(!d.is_same());
  CHECK(d.same_checks == 0);
  REQUIRE(d.checks.size() == 1);
  CHECK(!d.checks[0].verdict_changed());
  CHECK(!d.checks[0].requirement_changed());
  CHECK(d.worse.empty());
}

TEST_CASE("A new failure, a new error, a lost check and a lost case are worse") {
  const auto worse = [](const StoredResult& before, const StoredResult& after) {
    return engine::difference(std::vector{before}, std::vector{after}).worse;
  };
  StoredResult fails = result("a");
  fails.verdict = "fail";
  fails.checks[0] = check("length", "fail", 2.0);
  REQUIRE(worse(result("a"), fails).size() == 1);
  CHECK_THAT(worse(result("a"), fails)[0], ContainsSubstring("a: length fails, margin 2"));
  CHECK(worse(fails, fails).empty());
  CHECK(worse(fails, result("a")).empty());

  StoredResult error = result("a");
  error.verdict = "error";
  error.outcome = "mach";
  error.error_message = "too fast";
  error.checks.clear();
  REQUIRE(worse(result("a"), error).size() == 1);
  CHECK_THAT(worse(result("a"), error)[0], ContainsSubstring("error (mach): too fast"));
  CHECK(worse(error, fails).empty());  // there was no answer before

  StoredResult unjudged = result("a");
  unjudged.checks.clear();
  CHECK_THAT(worse(result("a"), unjudged)[0], ContainsSubstring("length is no longer judged"));
  CHECK_THAT(engine::difference(std::vector{result("a")}, std::vector<StoredResult>{}).worse[0],
             ContainsSubstring("a: has no result any more"));
  CHECK_THAT(engine::difference(std::vector<StoredResult>{}, std::vector{fails}).worse[0],
             ContainsSubstring("is new and fails"));
}

TEST_CASE("Checks of one metric are told apart by what they state") {
  StoredResult before = result("a"), after = result("a");
  StoredCheck other = check("length", "pass", 0.1);
  other.statement = "another";
  before.checks.push_back(other);
  after.checks.insert(after.checks.begin(), other);
  CHECK(engine::difference(before, after).is_same());
}

TEST_CASE("A wider tolerance, another reference and another plan are shown, and are no failure") {
  StoredResult before = result("a"), after = result("a");
  after.checks[0].tolerance = 10.0;
  before.references = {{"table", "analytic", "", "1234"}};
  after.references = {{"table", "analytic", "", "5678"}};
  before.plan = {{"fluid", "16 nodes", true}};
  after.plan = {{"fluid", "32 nodes", true}};
  const engine::CaseDifference d = engine::difference(before, after);
  REQUIRE(d.checks.size() == 1);
  CHECK(d.checks[0].requirement_changed());
  REQUIRE(d.references.size() == 1);
  CHECK(d.references[0].after == "5678");
  CHECK(d.plan == std::vector<std::string>{"- builds fluid: 16 nodes", "+ builds fluid: 32 nodes"});
  CHECK(d.worse.empty());
}

TEST_CASE("A run is slower where its repeats do not overlap, or where two long runs differ by half") {
  StoredResult before = result("a"), after = result("a");
  before.repeats = {1.0, 1.1, 1.2};
  after.repeats = {1.15, 1.3, 1.4};
  CHECK(!engine::difference(before, after).slow_down);
  after.repeats = {1.25, 1.3, 1.4};
  REQUIRE(engine::difference(before, after).slow_down);
  CHECK(engine::difference(before, after).is_same());
  after.threads = 1;
  CHECK(!engine::difference(before, after).slow_down);

  before = result("a");
  after = result("a");
  before.wall_seconds = before.cpu_seconds = 2.0;
  after.wall_seconds = 4.0;
  after.cpu_seconds = 2.1;  // something else had the machine
  CHECK(!engine::difference(before, after).slow_down);
  after.cpu_seconds = 4.0;
  CHECK(engine::difference(before, after).slow_down);
  before.wall_seconds = before.cpu_seconds = 0.01;
  CHECK(!engine::difference(before, after).slow_down);
}

TEST_CASE("diff says of the same runs that they are, and of others what is worse") {
  const Folder folder;
  folder.write("bad.toml", good_case);
  REQUIRE(folder.run({"run", "bad.toml", "--out", "one"}).code == 0);
  REQUIRE(folder.run({"run", "bad.toml", "--out", "two", "--threads", "1"}).code == 0);
  const Ran same = folder.run({"diff", "one", "two"});
  CHECK(same.code == 0);
  CHECK_THAT(same.out, ContainsSubstring("same, bit for bit, but for times"));

  folder.write("bad.toml", replaced(good_case, "target = 1021", "target = 1022"));
  CHECK(folder.run({"run", "bad.toml", "--out", "three"}).code == 1);
  const Ran worse = folder.run({"diff", "one", "three", "--html", "page/diff.html"});
  CHECK(worse.code == 1);
  CHECK_THAT(worse.out, ContainsSubstring("bad: young_modulus fails"));
  CHECK_THAT(worse.out, ContainsSubstring("changed targets and tolerances"));
  const std::string page = unit::contents(folder.path() / "page/diff.html");
  CHECK_THAT(page, ContainsSubstring("young_modulus fails"));
  CHECK(page.find("http") == std::string::npos);
  CHECK(page.find("src=") == std::string::npos);

  const Ran files = folder.run({"diff", "one/bad.h5", "three/bad.h5", "--json"});
  CHECK(files.code == 1);
  const Json json = Json::parse(files.out);
  CHECK(json["same"] == false);
  CHECK(json["cases"][0]["checks"][0]["before"]["verdict"] == "pass");
  CHECK(json["cases"][0]["checks"][0]["after"]["verdict"] == "fail");

  CHECK(folder.run({"diff", "three", "one"}).code == 0);  // better
}

TEST_CASE("diff refuses what is no run, and a damaged result counts for none") {
  const Folder folder;
  folder.write("bad.toml", good_case);
  REQUIRE(folder.run({"run", "bad.toml", "--out", "one"}).code == 0);
  CHECK_THAT(folder.run({"diff", "one", "nowhere"}).err, ContainsSubstring("it does not exist"));
  CHECK_THAT(folder.run({"diff", "one", "one/bad.h5"}).err, ContainsSubstring("two folders are compared"));
  fs::create_directories(folder.path() / "empty");
  CHECK_THAT(folder.run({"diff", "one", "empty"}).err, ContainsSubstring("holds no results"));
  folder.write("two/bad.h5", unit::contents(folder.path() / "one/bad.h5").substr(0, 3000));
  const Ran damaged = folder.run({"diff", "one", "two"});
  CHECK(damaged.code == 2);
  CHECK_THAT(damaged.err, ContainsSubstring("does not match its checksum"));
  CHECK_THAT(damaged.out, ContainsSubstring("bad: has no result any more"));
}
