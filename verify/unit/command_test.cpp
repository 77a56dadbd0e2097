// The command line: which cases, how many at once, what is told of them.
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "catch.hpp"
#include "command.hpp"
#include "engine/total_progress.hpp"
#include "engine/units.hpp"
#include "io/csv.hpp"
#include "measures/drivers.hpp"

using namespace veriflex;
using nlohmann::json;
using unit::Folder;
using unit::Ran;
using unit::replaced;

namespace {

std::string case_called(const std::string& id) {
  return replaced(unit::good_case, "\"bad\"", '"' + id + '"');
}

std::string failing(const std::string& id) {
  return replaced(case_called(id), "target = 1021.", "target = 1022.");
}

// Three cases, of which one fails.
void write_cases(const Folder& folder) {
  folder.write("cases/a-one.toml", case_called("a-one"));
  folder.write("cases/a-two.toml", failing("a-two"));
  folder.write("cases/b-one.toml",
               replaced(case_called("b-one"), "topics = [\"tensile\"]", "topics = [\"cost\"]"));
}

std::vector<std::string> ids(const json& results) {
  std::vector<std::string> all;
  for (const json& one : results) all.push_back(one["id"]);
  return all;
}

using Ids = std::vector<std::string>;

// What does not depend on when and where it ran.
json timeless(const std::string& text) {
  json results = json::parse(text);
  for (json& one : results) {
    one.erase("wall_seconds");
    one.erase("result");
  }
  return results;
}

const std::string shear_wave = unit::case_head("wave") + R"(
[fluid]
nodes = [16, 4, 4]
relaxation_time = 0.8
initial = { flow = "shear-wave", velocity = [0.0, 0.01, 0.0], along = "x" }

[run]
steps = 3

[[observe]]
what = "energies"
every = 1
)";

double energy_of(const Folder& folder, const std::vector<std::string>& settings) {
  std::vector<std::string> words{"run", "wave.toml", "--json"};
  for (const std::string& one : settings) words.insert(words.end(), {"--set", one});
  const Ran ran = folder.run(words);
  INFO(ran.err);
  REQUIRE(ran.code == 0);
  const json said = json::parse(ran.out);
  for (const json& metric : said[0]["metrics"]) {
    if (metric["name"] == "energies.fluid_kinetic.last") return metric["value"];
  }
  FAIL("no energy");
  return 0.0;
}

}  // namespace

TEST_CASE("Patterns, tiers and topics stand for the cases that they match") {
  const Folder folder;
  write_cases(folder);
  const auto run = [&](std::vector<std::string> words) {
    words.insert(words.begin(), "run");
    words.insert(words.end(), {"--cases", "cases", "--json"});
    return folder.run(words);
  };
  CHECK(ids(json::parse(run({"a-*"}).out)) == Ids{"a-one", "a-two"});
  CHECK(ids(json::parse(run({"?-one", "a-*"}).out)) == Ids{"a-one", "b-one", "a-two"});
  CHECK(ids(json::parse(run({"--topic", "cost"}).out)) == Ids{"b-one"});
  CHECK(ids(json::parse(run({"a-*", "--tier", "quick"}).out)) == Ids{"a-one", "a-two"});
  const Ran none = run({"c-*"});
  CHECK(none.code == 2);
  CHECK_THAT(none.err, ContainsSubstring("'c-*' matches nothing"));
  CHECK(run({"--topic", "none"}).code == 2);
  CHECK(run({}).code == 2);
  const json verified = json::parse(folder.run({"verify", "b-*", "--cases", "cases", "--json"}).out);
  CHECK(ids(verified) == Ids{"b-one"});
}

TEST_CASE("Cases side by side have the results, the order and the exit code of cases one after another") {
  const Folder folder;
  write_cases(folder);
  folder.write("cases/c-bad.toml", "schema = 2\n");
  const Ran alone =
      folder.run({"run", "a-*", "c-bad", "b-one", "--cases", "cases", "--json", "--out", "one"});
  const Ran beside =
      folder.run({"run", "a-*", "c-bad", "b-one", "--cases", "cases", "--json", "--out", "many", "-j", "3"});
  CHECK(alone.code == 2);
  CHECK(beside.code == alone.code);
  CHECK(timeless(beside.out) == timeless(alone.out));
  CHECK_THAT(beside.err, ContainsSubstring("c-bad.toml"));
  for (const char* id : {"a-one", "a-two", "c-bad", "b-one"})
    CHECK(std::filesystem::exists(folder.path() / "many" / (std::string(id) + ".h5")));
  const Ran text = folder.run({"run", "a-*", "--cases", "cases", "-j", "2"});
  CHECK(text.code == 1);
  CHECK_THAT(text.out, ContainsSubstring("young_modulus"));
  CHECK_THAT(text.out, ContainsSubstring("pass     a-one"));
  CHECK_THAT(text.out, ContainsSubstring("fail     a-two"));
  CHECK(folder.left_aside().empty());
}

TEST_CASE("After a failure --fail-fast starts no other case, and keeps what these had") {
  const Folder folder;
  write_cases(folder);
  for (const char* jobs : {"1", "2"}) {
    INFO(jobs << " at once");
    const std::string out = std::string("out") + jobs;
    // With two at once the case that is timed waits for the others.
    const Ran ran =
        folder.run({"run", "a-two", "b-one", "--cases", "cases", "--fail-fast", "--out", out, "-j", jobs});
    CHECK(ran.code == 1);
    CHECK_THAT(ran.err, ContainsSubstring("1 of 2 cases were not run"));
    CHECK(std::filesystem::exists(folder.path() / out / "a-two.h5"));
    CHECK_FALSE(std::filesystem::exists(folder.path() / out / "b-one.h5"));
  }
}

TEST_CASE("The time left is that of the works that are not done, corrected by those that are") {
  using Seconds = std::vector<std::optional<double>>;
  CHECK_FALSE(engine::seconds_left(Seconds{{}, {}}, Seconds{{}, {}}));
  CHECK(engine::seconds_left(Seconds{10.0, 20.0}, Seconds{{}, {}}) == 30.0);
  CHECK(engine::seconds_left(Seconds{10.0, 20.0}, Seconds{15.0, {}}) == 30.0);  // all take half as long again
  CHECK(engine::seconds_left(Seconds{10.0, {}, 20.0}, Seconds{10.0, {}, {}}) == 35.0);  // unknown: the mean
  CHECK(engine::seconds_left(Seconds{{}, {}}, Seconds{4.0, {}}) == 4.0);
  CHECK(engine::clock_text(7.4) == "0:07");
  CHECK(engine::clock_text(725.0) == "12:05");
  CHECK(engine::clock_text(10931.0) == "3:02:11");
  CHECK(engine::TotalProgress({60.0, 120.0, 180.0}, 2).text() == "0/3 cases, about 3:00 left");
}

TEST_CASE("show gives back what a result holds, as text, CSV and JSON") {
  const Folder folder;
  folder.write("bad.toml", unit::good_case);
  REQUIRE(folder.run({"run", "bad.toml"}).code == 0);
  const Ran all = folder.run({"show", "bad"});
  CHECK(all.code == 0);
  for (const char* word : {"bad: ", "young_modulus", "stress_strain", "pass"})
    CHECK_THAT(all.out, ContainsSubstring(word));
  const json document = json::parse(folder.run({"show", "results/bad.h5", "--json"}).out);
  CHECK(document["verdict"] == "pass");
  CHECK(document["checks"][0]["metric"] == "young_modulus");
  const json record = json::parse(folder.run({"show", "bad", "stress_strain", "--json"}).out);
  const std::vector<io::CsvColumn> csv =
      io::parse_csv(folder.run({"show", "bad", "stress_strain", "--csv"}).out, "shown");
  REQUIRE(csv.size() == record["columns"].size());
  for (std::size_t c = 0; c < csv.size(); ++c) {
    CHECK(csv[c].name == record["columns"][c]["name"]);
    CHECK(csv[c].values == record["columns"][c]["values"].get<std::vector<double>>());
  }
  CHECK_THAT(folder.run({"show", "bad", "--csv"}).out, ContainsSubstring("name,value,dimension,meaning\n"));
  const Ran misspelt = folder.run({"show", "bad", "stress_stran"});
  CHECK(misspelt.code == 2);
  CHECK_THAT(misspelt.err, ContainsSubstring("Did you mean 'stress_strain'?"));
  CHECK_THAT(folder.run({"show", "bat"}).err, ContainsSubstring("Did you mean 'bad'?"));
}

TEST_CASE("A new case of every driver is valid, and called like its file") {
  const Folder folder;
  for (const engine::Driver& driver : measures::all()) {
    INFO(driver.name);
    const Ran made = folder.shell("\"$V\" new --driver " + driver.name + " > new-" + driver.name + ".toml");
    REQUIRE(made.code == 0);
    const Ran valid = folder.run({"validate", "new-" + driver.name + ".toml"});
    INFO(valid.err);
    CHECK(valid.code == 0);
  }
  const Ran named = folder.run({"new", "--driver", "tensile", "bar"});
  CHECK_THAT(named.out, ContainsSubstring("id = \"bar\""));
  CHECK_THAT(named.out, ContainsSubstring("# `displacement` or `load`"));
  CHECK(folder.run({"new", "--driver", "tensil"}).code == 2);
  CHECK(folder.run({"new", "--driver", "stability"}).code == 2);  // of a stream or of a coupling
  CHECK(folder.run({"new", "--driver", "wave", "mine"}).out ==
        folder.run({"new", "--driver", "plane-wave", "mine"}).out);
}

TEST_CASE("Completion and manual know every command and option") {
  const Folder folder;
  const Ran manual = folder.run({"manual"});
  const Ran completion = folder.run({"completion", "bash"});
  folder.write("completion", completion.out);
  for (const char* command : {"list", "run", "verify", "show", "new", "units", "sweep", "completion"}) {
    CHECK_THAT(manual.out, ContainsSubstring(std::string("\n.SS ") + command));
    CHECK_THAT(completion.out, ContainsSubstring(std::string("    ") + command + ") words="));
  }
  CHECK_THAT(manual.out, ContainsSubstring("\\-\\-fail\\-fast"));
  const auto completed = [&](const std::string& words) {
    folder.write("ask", ". ./completion\nCOMP_WORDS=(\"$V\" " + words +
                            ")\nCOMP_CWORD=$((${#COMP_WORDS[@]}-1))\n_veriflex\necho \"${COMPREPLY[@]}\"\n");
    return folder.shell("export V; bash ask").out;
  };
  CHECK(completed("verif") == "verify\n");
  CHECK(completed("run --top") == "--topic\n");
  CHECK(completed("run --tier p") == "paper\n");
  CHECK(completed("info tensile-section") == "tensile-section-convention\n");
}

TEST_CASE("Symbols of the field are other names of keys, in files, in --set and in studies") {
  const Folder folder;
  folder.write("wave.toml", shear_wave);
  const double energy = energy_of(folder, {"fluid.relaxation_time=0.9"});
  CHECK(energy_of(folder, {"fluid.tau=0.9"}) == energy);
  CHECK(energy_of(folder, {"fluid.relaxation_time=", "fluid.viscosity=0.2"}) ==
        energy_of(folder, {"fluid.tau=1.1"}));
  folder.write("wave.toml", replaced(shear_wave, "relaxation_time = 0.8", "tau = 0.9"));
  CHECK(energy_of(folder, {}) == energy);
  CHECK(energy_of(folder, {"fluid.relaxation_time=0.9"}) == energy);
  CHECK(folder.run({"sweep", "wave.toml", "--over", "fluid.tau=0.8,0.9"}).code == 0);
  CHECK(folder.run({"sweep", "wave.toml", "--over", "fluid.relaxation_time=0.8,0.9"}).code == 0);

  folder.write("wave.toml",
               replaced(shear_wave, "relaxation_time = 0.8", "relaxation_time = 0.8\ntau = 0.9"));
  const Ran both = folder.run({"run", "wave.toml"});
  CHECK(both.code == 2);
  CHECK_THAT(both.err,
             ContainsSubstring("wave.toml:14:7: both 'relaxation_time' and 'tau' (they are two names of "
                               "one parameter, the other stands at wave.toml:13:19). Keep one"));
  folder.write("wave.toml", replaced(shear_wave, "relaxation_time = 0.8", "relaxation_time = 0.8\nnu = 0.1"));
  CHECK_THAT(folder.run({"run", "wave.toml"}).err, ContainsSubstring("wave.toml:14:6: both viscosity and "
                                                                     "relaxation_time"));
}

TEST_CASE("A flow in SI becomes lattice values that say the same") {
  const engine::Physical flow{.viscosity = 1e-6,
                              .speed = 0.01,
                              .length = 1e-3,
                              .density = 1000.0,
                              .spacings = 20.0,
                              .young_modulus = 1e4,
                              .solid_density = 1100.0};
  for (const std::optional<double> tau : {std::optional<double>{}, std::optional(0.8)}) {
    engine::Physical asked = flow;
    asked.relaxation_time = tau;
    const engine::Lattice found = engine::lattice_of(asked);
    CHECK(found.units.spacing == Approx(5e-5).epsilon(1e-15));
    const double viscosity = (*found.told.relaxation_time - 0.5) / 3.0;
    CHECK(*found.told.speed * *found.told.length / viscosity == Approx(10.0).epsilon(1e-12));
    CHECK(found.told.bodies.front().density == Approx(1.1).epsilon(1e-15));
    for (const engine::Quantity& q : engine::quantities(found.told, found.units)) {
      if (q.symbol == "U") CHECK(*q.physical == Approx(0.01).epsilon(1e-13));
      if (q.symbol == "L") CHECK(*q.physical == Approx(1e-3).epsilon(1e-13));
      if (q.symbol == "nu") CHECK(*q.physical == Approx(1e-6).epsilon(1e-12));
      if (q.symbol == "E") CHECK(*q.physical == Approx(1e4).epsilon(1e-13));
      if (q.symbol == "rho_s") CHECK(*q.physical == Approx(1100.0).epsilon(1e-13));
      if (q.symbol == "Ma" && !tau) CHECK(q.lattice == Approx(0.05).epsilon(1e-13));
      if (q.symbol == "rho U^2/E") CHECK(q.lattice == Approx(1000.0 * 1e-4 / 1e4).epsilon(1e-13));
    }
    if (tau) CHECK(*found.told.relaxation_time == 0.8);
  }
  engine::Physical wrong = flow;
  wrong.length = 0.0;
  CHECK_THROWS_AS(engine::lattice_of(wrong), BadParameter);
}

TEST_CASE("What a fast flow is told to change is a slower lattice of the same viscosity") {
  // Mach 0.2: half the time step halves both Ma and tau - 1/2.
  const engine::Physical flow{
      .viscosity = 1e-6, .speed = 0.01, .length = 1e-3, .density = 1000.0, .spacings = 20.0, .mach = 0.2};
  engine::Physical slower = flow;
  slower.mach = 0.1;
  const double tau = *engine::lattice_of(flow).told.relaxation_time;
  CHECK(*engine::lattice_of(slower).told.relaxation_time - 0.5 == Approx((tau - 0.5) / 2.0).epsilon(1e-12));
  const std::vector<engine::Quantity> all = engine::quantities(engine::lattice_of(flow).told, std::nullopt);
  const auto mach = std::find_if(all.begin(), all.end(), [](const auto& q) { return q.name == "mach"; });
  REQUIRE(mach != all.end());
  CHECK(mach->remedy == "a time step 2 times shorter, tau - 1/2 smaller by the same factor");
}

TEST_CASE("Numbers outside of their good range are told with what to change") {
  const auto faults = [](const engine::Told& told) {
    std::set<std::string> found;
    for (const engine::Quantity& q : engine::quantities(told, std::nullopt)) {
      CHECK(q.fault.empty() == q.remedy.empty());
      if (!q.fault.empty()) found.insert(q.name);
    }
    return found;
  };
  using Names = std::set<std::string>;
  CHECK(faults({.relaxation_time = 0.8, .speed = 0.02, .length = 20.0}) == Names{});
  CHECK(faults({.relaxation_time = 0.501, .speed = 0.2, .length = 2.0}) ==
        Names{"relaxation_time", "mach", "grid_reynolds", "length"});
  CHECK(faults({.relaxation_time = 3.0}) == Names{"relaxation_time"});
  CHECK(faults({.relaxation_time = 0.8,
                .speed = 0.05,
                .bodies = {{.name = "rod", .young_modulus = 0.01, .density = 0.5, .is_coupled = true}}}) ==
        Names{"rod.density_ratio", "rod.cauchy"});
}

TEST_CASE("units tells a scene by its inflow or its force, and by what stands in it") {
  const Folder folder;
  const auto told = [&](const std::vector<std::string>& words) {
    const Ran ran = folder.run(words);
    REQUIRE(ran.code == 0);
    std::map<std::string, double> lattice;
    const json said = json::parse(ran.out);
    for (const json& q : said["quantities"]) lattice[q["name"]] = q["lattice"];
    return lattice;
  };
  std::map<std::string, double> cylinder = told({"units", "cylinder-in-channel", "--json"});
  CHECK(cylinder["length"] == 10.0);
  CHECK(cylinder["speed"] == 0.1);  // on the axis: 3/2 of the mean, of which Re = 20
  CHECK(cylinder["reynolds"] == Approx(30.0).epsilon(1e-12));
  std::map<std::string, double> plates = told({"units", "scene-poiseuille-alone", "--json"});
  CHECK(plates["length"] == 8.0);
  CHECK(plates["speed"] == Approx(1e-6 * 64.0 / (8.0 / 6.0)).epsilon(1e-12));
  CHECK(plates["mach"] == Approx(plates["speed"] * std::sqrt(3.0)).epsilon(1e-12));
}

TEST_CASE("units prints a scene's numbers in both systems") {
  const Folder folder;
  folder.write("wave.toml", replaced(shear_wave, "[run]",
                                     "[units]\nspacing = 1e-4\ntime_step = 1e-5\n"
                                     "density = 1000.0\nlength = 2e-3\n\n[run]"));
  const Ran ran = folder.run({"units", "wave.toml", "--json"});
  INFO(ran.err);
  REQUIRE(ran.code == 0);
  double reynolds = 0.0;
  const json said = json::parse(ran.out);
  for (const json& q : said["quantities"]) {
    if (q["name"] == "viscosity") {
      CHECK(q["physical"].get<double>() == Approx(1e-4).epsilon(1e-13));
      CHECK(q["unit"] == "m^2/s");
    }
    if (q["name"] == "speed") CHECK(q["physical"].get<double>() == Approx(0.1).epsilon(1e-13));
    if (q["name"] == "reynolds") reynolds = q["lattice"];
  }
  CHECK(reynolds == Approx(0.1 * 2e-3 / 1e-4).epsilon(1e-12));
  CHECK(folder.run({"run", "wave.toml"}).code == 0);
  CHECK(folder.run({"units"}).code == 2);
  CHECK(folder.run({"units", "tensile-fene-lj"}).code == 2);
  CHECK(folder.run({"units", "--viscosity", "1e-6", "--speed", "0.01", "--length", "1e-3"}).code == 2);
  folder.write("wave.toml", replaced(shear_wave, "[run]",
                                     "[units]\nspacing = 0.0\ntime_step = 1e-5\n"
                                     "density = 1000.0\n\n[run]"));
  CHECK_THAT(folder.run({"units", "wave.toml"}).err, ContainsSubstring("wave.toml:17:11: 'spacing' is 0"));
}
