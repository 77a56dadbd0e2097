// What surrounds a run: whatever ends it, its result is stored and says so; nothing is lost or taken for
// another.
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/file.h>
#include <sys/stat.h>

#include <chrono>
#include <filesystem>
#include <limits>
#include <new>
#include <nlohmann/json.hpp>
#include <thread>

#include "base/stop.hpp"
#include "catch.hpp"
#include "engine/baseline.hpp"
#include "engine/result.hpp"
#include "engine/stored_result.hpp"
#include "io/file.hpp"
#include "io/hdf5.hpp"
#include "measures/drivers.hpp"
#include "observe/interrupted.hpp"
#include "observe/run.hpp"
#include "repository.hpp"
#include "unit/command.hpp"

using namespace veriflex;
using namespace veriflex::engine;
using Json = nlohmann::json;
namespace fs = std::filesystem;
using unit::Folder;
using unit::good_case;
using unit::Ran;
using unit::replaced;

namespace {

std::string named(const std::string& id) {
  return replaced(good_case, "id = \"bad\"", "id = \"" + id + "\"");
}

std::string shipped(const std::string& id) { return io::read_file(repository::cases() / (id + ".toml")); }

std::string attribute(const fs::path& result, const std::string& name) {
  return io::Hdf5File(result).attribute("/", name);
}

// One run of a fluid, without its sweep and checks.
std::string periodic_fluid(const std::string& id) {
  const std::string text = replaced(shipped("conservation-periodic"), "conservation-periodic", id);
  return text.substr(0, text.find("[sweep]"));
}

// That text with another value of its first key of this name.
std::string with_value(std::string text, const std::string& key, const std::string& value) {
  const std::size_t line = text.find("\n" + key + " = ");
  return text.replace(line, text.find('\n', line + 1) - line, "\n" + key + " = " + value);
}

// A fluid that moves for hours.
std::string endless() { return with_value(periodic_fluid("long"), "steps", "100000000"); }

// A fluid of 7.7 GB; not with sanitizers, which reserve more than any limit on memory.
[[maybe_unused]] std::string large(const std::string& id) {
  return with_value(periodic_fluid(id), "nodes", "[400, 400, 400]");
}

// The command as a process of its own, with the signals at their defaults.
class Process {
 public:
  Process(const Folder& folder, const std::string& arguments) {
    const std::string line = "cd '" + folder.path().string() + "' && exec '" + unit::command() + "' " +
                             arguments + " >.stdout 2>.stderr";
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    sigset_t signals;
    sigemptyset(&signals);
    for (const int one : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&signals, one);
    posix_spawnattr_setsigdefault(&attributes, &signals);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);
    std::string shell = "/bin/sh", option = "-c", command = line;
    char* const words[]{shell.data(), option.data(), command.data(), nullptr};
    REQUIRE(posix_spawn(&id_, "/bin/sh", nullptr, &attributes, words, environ) == 0);
    posix_spawnattr_destroy(&attributes);
  }

  // Once the file is there.
  void send_when(int signal, const fs::path& there) const {
    for (int i = 0; i < 6000 && !fs::exists(there); ++i) wait_a_little();
    for (int i = 0; i < 20; ++i) wait_a_little();
    kill(id_, signal);
  }

  int exit_code() const {
    int status = 0;
    waitpid(id_, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

 private:
  static void wait_a_little() { std::this_thread::sleep_for(std::chrono::milliseconds(10)); }
  pid_t id_ = 0;
};

template <class Throw>
Result run_that_ends_by(Throw end) {
  Case c{};
  c.id = "made-up";
  c.study.run = [end](observe::Observations& seen, Progress&, Cost&) {
    seen.metrics.push_back({"seen_before", 1.0, "1", "m"});
    end();
  };
  return run_case(c, 1);
}

}  // namespace

TEST_CASE("Whatever ends a run is a verdict with its kind, and keeps what was seen") {
  const auto kind_of = [](auto end) {
    const Result result = run_that_ends_by(end);
    CHECK(result.verdict == Verdict::error);
    CHECK_FALSE(result.error_message.empty());
    CHECK(result.seen.metric("seen_before") != nullptr);
    const Folder folder;
    write_result(result, folder.path());
    CHECK(attribute(folder.path() / "made-up.h5", "error_kind") == result.error_kind);
    return result.error_kind;
  };
  CHECK(kind_of([] { throw NumericalFailure("x"); }) == "numerical");
  CHECK(kind_of([] { throw observe::Interrupted(NumericalFailure("x"), {}); }) == "numerical");
  CHECK(kind_of([] { throw BadParameter("p", "x", "", ""); }) == "input");
  CHECK(kind_of([] { throw InputError({}, "x", "", ""); }) == "input");
  CHECK(kind_of([] { throw OutputError("f", "x", ""); }) == "output");
  CHECK(kind_of([] { throw std::bad_alloc(); }) == "memory");
  CHECK(kind_of([] {
          static_cast<void>(std::vector<double>(std::numeric_limits<std::size_t>::max() / 4));
        }) == "memory");
  CHECK(kind_of([] { static_cast<void>(fs::file_size("/nowhere")); }) == "input");
  CHECK(kind_of([] { static_cast<void>(std::string("x").at(7)); }) == "internal");
  CHECK(kind_of([] { throw 7; }) == "internal");
}

TEST_CASE("The last good state of a broken run stands once, and records have rows of equal length") {
  Case c{};
  c.id = "made-up";
  c.study.run = [](observe::Observations& seen, Progress&, Cost&) {
    seen.metrics.push_back({"last_good_step", 1.0, "1", "m"});
    seen.records.push_back({"ragged", "t", {{"x", "", "1", "m", {1.0, 2.0}}, {"y", "", "1", "m", {3.0}}}});
    throw observe::Interrupted(NumericalFailure("x"), {{}, {{"last_good_step", 2.0, "1", "m"}}});
  };
  const Folder folder;
  write_result(run_case(c, 1), folder.path());
  const io::Hdf5File file(folder.path() / "made-up.h5");
  CHECK(file.numbers("/metrics/value") == std::vector<double>{2.0});
  CHECK(file.numbers("/records/ragged/x") == std::vector<double>{1.0});
  CHECK(file.numbers("/records/ragged/y") == std::vector<double>{3.0});
}

TEST_CASE("A body that stands under its load from the start has lost no energy") {
  // Half way to where the load would hold it: what was put in is what the bond holds, and not what the load
  // has given up, which is four times that.
  constexpr double k = 0.26, F = 0.01;
  scene::Body pair{{bond::Harmonic{k, 1.0}, 0.0}, solid::cubic_lattice({{1, 1, 2}, 1.0}), {}, {8, 0.0}};
  pair.conditions.fixed = solid::FixedDofs::Constant(2, 3, true);
  pair.conditions.fixed(1, 2) = false;
  pair.conditions.load = pair.start.displacement = Positions::Zero(2, 3);
  pair.conditions.load(1, 2) = F;
  pair.start.displacement(1, 2) = 0.5 * F / k;
  scene::Simulation simulation({.bodies = {pair}});
  Progress progress{"test"};
  observe::Run run(simulation, {.every = 1, .bodies = {.energy_growth = 0.1}}, {}, "", progress);
  CHECK_NOTHROW(run.advance(40, 40));
}

TEST_CASE("A study that takes an interruption for its answer is believed nothing") {
  stop::signal = SIGTERM;
  const Result result = run_that_ends_by([] {
    try {
      stop_if_asked("step", 3);
    } catch (const NumericalFailure&) {  // "does not survive"
    }
  });
  stop::signal = 0;
  stop::forget();
  CHECK(result.verdict == Verdict::error);
  CHECK(result.error_kind == "interrupted");
  CHECK(result.seen.metrics.empty());
}

TEST_CASE("SIGTERM, SIGINT and a terminal that goes leave what was seen, and the cases that were not run") {
  for (const auto& [signal, name] : {std::pair{SIGTERM, "SIGTERM"}, {SIGINT, "SIGINT"}, {SIGHUP, "SIGHUP"}}) {
    const Folder folder;
    INFO(name);
    folder.write("long.toml", endless());
    folder.write("bad.toml", good_case);
    folder.write("out/bad.h5", "an earlier pass");
    const Process process(folder, "run long.toml bad.toml --out out --threads 1");
    process.send_when(signal, folder.path() / "out/long.h5");
    CHECK(process.exit_code() == 3);
    const io::Hdf5File cut(folder.path() / "out/long.h5");
    CHECK(cut.attribute("/", "verdict") == "error");
    CHECK(cut.attribute("/", "error_kind") == "interrupted");
    CHECK_THAT(cut.attribute("/", "error_message"), ContainsSubstring("interrupted by " + std::string(name)));
    CHECK_THAT(cut.attribute("/", "error_message"), ContainsSubstring("step"));
    const io::Hdf5File never(folder.path() / "out/bad.h5");
    CHECK(never.attribute("/", "verdict") == "error");
    CHECK_THAT(never.attribute("/", "error_message"), ContainsSubstring("not run: interrupted by"));
  }
}

TEST_CASE("Newton's steps and the pieces of a study stop too") {
  const Folder folder;
  folder.write("bad.toml",
               replaced(replaced(good_case, "[2, 2, 4]", "[12, 12, 200]"), "\"fixed\"", "\"free\""));
  const Process process(folder, "run bad.toml --out out --threads 1");
  process.send_when(SIGTERM, folder.path() / "out/bad.h5");
  CHECK(process.exit_code() == 3);
  CHECK(attribute(folder.path() / "out/bad.h5", "error_kind") == "interrupted");
}

TEST_CASE("A program started with hang-ups ignored goes on ignoring them") {
  const Folder folder;
  folder.write("long.toml", endless());
  const Ran ran = folder.shell("trap '' HUP; \"$V\" run long.toml --out out --threads 1 & P=$!; " +
                               unit::until("[ -e out/long.h5 ]") + "; kill -HUP $P; kill -TERM $P; wait $P");
  CHECK(ran.code == 3);
  CHECK_THAT(attribute(folder.path() / "out/long.h5", "error_message"),
             ContainsSubstring("interrupted by SIGTERM"));
}

TEST_CASE("A killed run leaves no earlier pass in its place") {
  const Folder folder;
  folder.write("long.toml", endless());
  folder.write("out/long.h5", "an earlier pass");
  fs::remove(folder.path() / "out/long.h5");
  const Process process(folder, "run long.toml --out out --threads 1");
  process.send_when(SIGKILL, folder.path() / "out/long.h5");
  CHECK(process.exit_code() == 128 + SIGKILL);
  CHECK(attribute(folder.path() / "out/long.h5", "verdict") == "error");
  CHECK_THAT(attribute(folder.path() / "out/long.h5", "error_message"),
             ContainsSubstring("has not come to its end"));
  CHECK(folder.left_aside().empty());
}

TEST_CASE("Words that cannot be said cost no result, and standard output that cannot be written is exit 4") {
  const Folder folder;
  folder.write("bad.toml", good_case);
  folder.write("fails.toml", replaced(named("fails"), "target = 1021", "target = 1022"));
  for (const std::string line : {"list", "list --json", "plan bad.toml", "info bad.toml", "validate bad.toml",
                                 "claims --results .", "derive --epsilon 1 --sigma 1",
                                 "calibrate --young 0.26 --spacing 1 --poisson 0.3", "--help", "--version"}) {
    INFO(line);
    const Ran ran = folder.shell("\"$V\" " + line + " >/dev/full");
    CHECK(ran.code == 4);
    CHECK_THAT(ran.err, ContainsSubstring("standard output"));
  }
  for (const std::string stream : {">/dev/full", ">&-"}) {
    for (const std::string form : {"", "--json"}) {
      INFO(stream << form);
      fs::remove_all(folder.path() / "out");
      const Ran ran = folder.shell("\"$V\" run fails.toml bad.toml --out out " + form + " " + stream);
      CHECK(ran.code == 4);
      CHECK(attribute(folder.path() / "out/fails.h5", "verdict") == "fail");
      CHECK(attribute(folder.path() / "out/bad.h5", "verdict") == "pass");
    }
  }
  for (const std::string stream : {"2>/dev/full", "2>&-"}) {
    INFO(stream);
    fs::remove_all(folder.path() / "out");
    CHECK(folder.shell("\"$V\" run nowhere bad.toml --out out " + stream).code == 2);
    CHECK(attribute(folder.path() / "out/bad.h5", "verdict") == "pass");
  }
  folder.shell("(" + unit::until("[ -e nobody ]") +
               "; \"$V\" run bad.toml --out piped; echo $? >code) | (exec <&-; : >nobody); " +
               unit::until("[ -s code ]"));
  CHECK(unit::contents(folder.path() / "code") == "4\n");
  CHECK(attribute(folder.path() / "piped/bad.h5", "verdict") == "pass");
}

TEST_CASE("What a result file could not hold is refused before the run") {
  const Folder folder;
  const std::string target = R"(target = 1021.186296534041763399964
target_kind = "high-precision"
source = "40-digit arithmetic")";
  const std::string reference =
      "schema = 1\nid = \"ref\"\nkind = \"analytic\"\nsource = \"s\"\nobtained = "
      "\"o\"\n[values.young_modulus]\n"
      "value = 1021.186296534041763399964\ndimension = \"M L^-1 T^-2\"\nmeaning = \"m\"\n";
  const auto refused = [&](const std::string& text, const std::string& message) {
    INFO(message);
    folder.write("bad.toml", text);
    const Ran ran = folder.run({"run", "bad.toml", "--out", "out"});
    CHECK(ran.code == 2);
    CHECK_THAT(ran.err, ContainsSubstring(message));
  };
  folder.write("ref.toml", reference);
  refused(replaced(good_case, target, "reference = \"./ref\""),
          "bad.toml:29:13: reference './ref' is named with a '/'");
  std::string many = "c0";
  std::string numbers = "0";
  for (int i = 1; i <= 2000; ++i) {
    many += ",c" + std::to_string(i);
    numbers += ",0";
  }
  const std::vector<std::pair<std::string, std::string>> tables{
      {"a,a/b\n1,1\n", "a column is named 'a/b'"},
      {".,b\n1,1\n", "a column is named '.'"},
      {std::string("a\x01,b\n1,1\n"), "control characters"},
      {many + "\n" + numbers + "\n", "has 2001 columns"}};
  for (const auto& [csv, message] : tables) {
    folder.write("d.csv", csv);
    folder.write("ref.toml", reference + "[data]\nfile = \"d.csv\"\nsha256 = \"" + io::sha256(csv) + "\"\n");
    refused(replaced(good_case, target, "reference = \"ref\""), message);
  }
  std::string topics = "[";
  for (int i = 0; i <= 2000; ++i) topics += "\"t\", ";
  refused(replaced(good_case, "[\"tensile\"]", topics + "]"), "bad.toml:8:10: 'topics' holds 2001 texts");
  refused(replaced(good_case, "[\"tensile\"]", "[\"a\\u0000b\"]"), "holds a zero byte");
  folder.write("bad.toml", good_case);
  std::vector<std::string> words{"run", "bad.toml", "--out", "out"};
  for (int i = 0; i <= 2000; ++i) words.insert(words.end(), {"--set", "title=t"});
  CHECK_THAT(folder.run(words).err, ContainsSubstring("2001 times --set"));
  words.resize(words.size() - 2);
  CHECK(folder.run(words).code == 0);
}

TEST_CASE("Two cases of one id are refused, and a changed case has a result of its own") {
  const Folder folder;
  folder.write("bad.toml", good_case);
  folder.write("other/bad.toml", good_case);
  const Ran twice = folder.run({"run", "bad.toml", "other/bad.toml", "--out", "out"});
  CHECK(twice.code == 2);
  CHECK_THAT(twice.err, ContainsSubstring("case 'bad' stands here twice: as bad.toml and as other/bad.toml"));
  CHECK_FALSE(fs::exists(folder.path() / "out"));

  REQUIRE(folder.run({"run", "bad.toml", "--out", "out"}).code == 0);
  const std::string plain = unit::contents(folder.path() / "out/bad.h5");
  const Ran changed = folder.run({"run", "bad.toml", "--set", "bond.epsilon=2.0", "--out", "out"});
  CHECK(changed.code == 1);
  CHECK_THAT(changed.out, ContainsSubstring("changed: bad --set bond.epsilon=2.0"));
  CHECK(unit::contents(folder.path() / "out/bad.h5") == plain);
  const fs::path result = folder.path() / "out/bad+bond.epsilon=2.0.h5";
  CHECK(attribute(result, "id") == "bad+bond.epsilon=2.0");
  CHECK(attribute(result, "case_id") == "bad");
  CHECK(attribute(result, "variant") == "bond.epsilon=2.0");
  CHECK(attribute(folder.path() / "out/bad.h5", "variant").empty());
  REQUIRE(folder.run({"run", "derive-fene-lj", "--set", "title=x", "--out", "ledger"}).code == 0);
  const Ran claims = folder.run({"claims", "--results", "ledger"});
  CHECK_THAT(claims.err, ContainsSubstring("left out, its case was changed by --set title=x"));
  CHECK_THAT(claims.out, ContainsSubstring("not run  derive-fene-lj"));
  const Ran unread = folder.run({"run", "bad.toml", "--set", "bond.epsilon=-1", "--out", "out"});
  CHECK(unread.code == 2);
  CHECK(unit::contents(folder.path() / "out/bad.h5") == plain);
  folder.write("b+d.toml", replaced(good_case, "id = \"bad\"", "id = \"b+d\""));
  CHECK_THAT(folder.run({"validate", "b+d.toml"}).err, ContainsSubstring("b+d.toml:2:6: id 'b+d' has a '+'"));
}

TEST_CASE("Names of changed cases differ as what was set does, and suit a file system") {
  Case c{};
  c.id = "one";
  const auto name = [&](const std::vector<std::string>& overrides) {
    c.overrides = overrides;
    return c.name();
  };
  CHECK(name({}) == "one");
  CHECK(name({"a.b=1.5e-3"}) == "one+a.b=1.5e-3");
  CHECK(name({"a=1", "b=2"}) == "one+a=1+b=2");
  CHECK(name({"a=1", "b=2"}) != name({"a=1+b=2"}));
  CHECK(name({"a=[1, 2]"}) != name({"a=[1; 2]"}));
  CHECK(name({"a=/x"}).find('/') == std::string::npos);
  CHECK(name({std::string(5000, 'x') + "=1"}) != name({std::string(5000, 'x') + "=2"}));
  CHECK(name({std::string(5000, 'x') + "=1"}).size() < 200);
}

TEST_CASE("An override adds tables, and says that what stands in them comes from the command line") {
  const auto document = [](const std::vector<std::string>& set) {
    return io::parse_document("a = 1\n[[d]]\ne = 1\n", "t.toml", set);
  };
  CHECK(document({"b.c.x=5"}).table("b").table("c").number("x") == 5.0);
  CHECK(document({"d.1.e=2"}).tables("d").size() == 2);
  CHECK_THROWS_AS(document({"d.2.e=2"}), InputError);
  CHECK_THROWS_AS(document({"a.b=2"}), InputError);
  CHECK_THROWS_AS(document({"d..e=2"}), InputError);
  const io::Table top = document({"w={every=0, deep=[{x=1}]}", "b.c=2"});
  CHECK(to_string(top.table("w").place("every")) == "--set w={every=0, deep=[{x=1}]}");
  CHECK(to_string(top.table("w").tables("deep").front().place("x")) == "--set w={every=0, deep=[{x=1}]}");
  CHECK(to_string(top.table("w").place()) == "--set w={every=0, deep=[{x=1}]}");
  CHECK(to_string(top.table("b").place()) == "--set b.c=2");
  CHECK(to_string(top.place("a")) == "t.toml:1:5");
  CHECK(document({"b={c=1}", "b=3"}).number("b") == 3.0);
  const Folder folder;
  const Ran ran = folder.run({"run", "conservation-closed", "--set", "monitor={every=0}"});
  CHECK(ran.code == 2);
  CHECK_THAT(ran.err, ContainsSubstring("--set monitor={every=0}"));
}

TEST_CASE("A case without checks is measured, and a run tells its numbers and where they are") {
  const Folder folder;
  folder.write("bad.toml", good_case);
  const Ran judged = folder.run({"run", "bad.toml", "--out", "out"});
  CHECK(judged.code == 0);
  CHECK_THAT(judged.out, ContainsSubstring("young_modulus         1021.18629653"));
  CHECK_THAT(judged.out, ContainsSubstring("result out/bad.h5"));
  folder.write("bad.toml", good_case.substr(0, good_case.find("[[check]]")));
  const Ran ran = folder.run({"run", "bad.toml", "--out", "out"});
  CHECK(ran.code == 0);
  CHECK_THAT(ran.out, StartsWith("measured bad"));
  CHECK_THAT(ran.out, ContainsSubstring("young_modulus"));
  CHECK(attribute(folder.path() / "out/bad.h5", "verdict") == "measured");
  CHECK(folder.run({"validate", "bad.toml"}).code == 0);
}

TEST_CASE("A baseline is held against later runs by itself") {
  const Folder folder;
  folder.write("bad.toml", good_case);
  REQUIRE(folder.run({"accept", "bad.toml", "--reason", "first"}).code == 0);
  const fs::path path = folder.path() / "bad-baseline.toml";
  const Reference baseline = read_reference(path);
  const Ran same = folder.run({"run", "bad.toml", "--json"});
  CHECK(same.code == 0);
  CHECK(Json::parse(same.out)[0]["checks"].size() == 1 + baseline.values.size());

  const std::string text = unit::contents(path);
  const std::size_t at = text.find("value = ", text.find("[values.\"young_modulus\"]"));
  const std::string moved = text.substr(0, at) + "value = 1021.1863" + text.substr(text.find('\n', at));
  folder.write("bad-baseline.toml", moved);
  const Ran departed = folder.run({"run", "bad.toml"});
  CHECK(departed.code == 1);
  CHECK_THAT(departed.out, ContainsSubstring("as accepted on"));
  CHECK(folder.run({"run", "bad.toml", "--set", "title=x"}).code == 0);  // another case
  folder.write("bad-baseline.toml", replaced(moved, "relative = 1e-09", "relative = 1e-6"));
  CHECK(folder.run({"run", "bad.toml"}).code == 0);

  folder.write("bad-baseline.toml", replaced(text, "\"young_modulus\"", "\"young_modulos\""));
  const Ran unknown = folder.run({"run", "bad.toml"});
  CHECK(unknown.code == 2);
  CHECK_THAT(unknown.err, ContainsSubstring("holds 'young_modulos', which is no longer measured"));
}

TEST_CASE("A baseline that says infinite is held too, and one alone does not make a verdict") {
  const Folder folder;
  std::string text = replaced(shipped("derive-harmonic"), "id = \"derive-harmonic\"", "id = \"mine\"");
  folder.write("mine.toml", text.substr(0, text.find("[[check]]")));
  REQUIRE(folder.run({"accept", "mine.toml", "--reason", "first"}).code == 0);
  const std::string baseline = unit::contents(folder.path() / "mine-baseline.toml");
  REQUIRE(baseline.find("value = inf") != std::string::npos);
  CHECK_THAT(folder.run({"run", "mine.toml"}).out, StartsWith("measured"));
  folder.write("mine-baseline.toml", replaced(baseline, "value = inf", "value = 1.0"));
  CHECK(folder.run({"run", "mine.toml"}).code == 3);  // a number was accepted, infinity is measured
}

TEST_CASE("accept reads back what it writes, keeps what is there, and its tolerance") {
  const Folder folder;
  folder.write("bad.toml", good_case);
  REQUIRE(folder.run({"accept", "bad.toml", "--reason", "first"}).code == 0);
  const std::string first = unit::contents(folder.path() / "bad-baseline.toml");
  const Ran bytes = folder.run({"accept", "bad.toml", "--reason", "caf\xe9", "--replace"});
  CHECK(bytes.code == 2);
  CHECK_THAT(bytes.err, ContainsSubstring("could not be read again"));
  CHECK(unit::contents(folder.path() / "bad-baseline.toml") == first);
  CHECK(folder.run({"accept", "bad.toml", "--reason", "third"}).code == 0);  // nothing differs
  CHECK(unit::contents(folder.path() / "bad-baseline.toml") == first);
  folder.write("bad-baseline.toml", replaced(first, "relative = 1e-09", "relative = 1e-6"));
  CHECK(folder.run({"accept", "bad.toml", "--reason", "fourth", "--replace"}).code == 0);
  const Reference renewed = read_reference(folder.path() / "bad-baseline.toml");
  CHECK(renewed.origin->reason == "fourth");
  CHECK(renewed.origin->relative == 1e-6);
  folder.write("bad-baseline.toml", "broken");
  CHECK(folder.run({"accept", "bad.toml", "--reason", "fifth"}).code == 2);
  CHECK(folder.run({"accept", "bad.toml", "--reason", "fifth", "--replace"}).code == 0);
}

TEST_CASE(
    "What is in a file is listed by name from the first on, and what is not there is missing, groups on the "
    "way too") {
  const Folder folder;
  io::Hdf5Image image;
  for (const char* path : {"/data/c", "/data/a", "/data/b"}) image.numbers(path, std::vector{1.0});
  io::write_file(folder.path() / "x.h5", image.bytes());
  const io::Hdf5File file(folder.path() / "x.h5");
  CHECK(file.names("/data") == std::vector<std::string>{"a", "b", "c"});
  CHECK(file.holds("/data/a"));
  CHECK_FALSE(file.holds("/data/d"));
  CHECK_FALSE(file.holds("/nothing/a"));
  CHECK_FALSE(file.holds("/nothing/at/all"));
}

TEST_CASE("A file has the same bytes whenever it is made") {
  const auto made = [] {
    io::Hdf5Image image;
    image.numbers("/data/a", std::vector{1.0, 2.0});
    image.attribute("/data/a", "unit", std::string("m"));
    return image.bytes();
  };
  const std::vector<char> before = made();
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // times in HDF5 are whole seconds
  CHECK((made() == before));                                     // not to be printed
}

TEST_CASE("A damaged result is found by its checksum before the HDF5 library sees it") {
  const Folder folder;
  folder.write("bad.toml", good_case);
  REQUIRE(folder.run({"run", "bad.toml", "--out", "out"}).code == 0);
  const std::string whole = unit::contents(folder.path() / "out/bad.h5");
  const fs::path path = folder.path() / "damaged.h5";
  const auto message = [&](const std::string& bytes) {
    folder.write("damaged.h5", bytes);
    try {
      const io::Hdf5File file(path);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("taken");
  };
  CHECK(message(whole) == "taken");
  for (std::size_t at = 0; at < whole.size(); at += 1 + at / 16) {
    std::string bytes = whole;
    bytes[at] = static_cast<char>(bytes[at] ^ 1);
    INFO(at);
    CHECK(message(bytes) != "taken");
  }
  CHECK_THAT(message(whole.substr(0, whole.size() - 1)), ContainsSubstring("does not match its checksum"));
  CHECK_THAT(message(whole + "x"), ContainsSubstring("does not match its checksum"));
  CHECK_THAT(message(whole.substr(512)), ContainsSubstring("one of an earlier version"));
  CHECK(message("") != "taken");
  fs::resize_file(path, std::uintmax_t{1} << 40);
  CHECK_THROWS_AS(io::Hdf5File(path), InputError);
  REQUIRE(mkfifo((folder.path() / "pipe.h5").c_str(), 0600) == 0);
  CHECK_THROWS_AS(io::Hdf5File(folder.path() / "pipe.h5"), InputError);
  fs::create_symlink("nowhere", folder.path() / "link.h5");
  CHECK_THROWS_AS(io::Hdf5File(folder.path() / "link.h5"), InputError);
  CHECK_THROWS_AS(io::Hdf5File(folder.path()), InputError);
}

TEST_CASE("A result with its checksum that is not as its schema says is refused by name") {
  // Nothing damages a file in this way: another program has written it.
  const auto message = [](const std::vector<std::string>& case_texts) {
    const Folder folder;
    io::Hdf5Image image;
    image.attribute("/", "schema", std::int64_t{2});
    image.attribute("/", "findings", std::int64_t{0});
    for (const char* name :
         {"id", "case_id", "variant", "title", "equation", "driver", "tier", "verdict", "outcome"})
      image.attribute("/", name, std::string("one"));
    for (const char* name : {"topics", "warnings"}) image.attribute("/", name, std::vector<std::string>{});
    image.texts("/case", case_texts);
    image.attribute("/case", "overrides", std::vector<std::string>{});
    io::write_file(folder.path() / "theirs.h5", image.bytes());
    try {
      read_result(folder.path() / "theirs.h5");
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("taken");
  };
  CHECK_THAT(message({}), ContainsSubstring("theirs.h5: 0 values in /case"));
  CHECK_THAT(message({"one", "two"}), ContainsSubstring("theirs.h5: 2 values in /case"));
  CHECK_THAT(message({"one"}), ContainsSubstring("no readable /plan/built/module"));
}

TEST_CASE("A file that is being written is not swept, what killed writers left is") {
  const Folder folder;
  const fs::path stale = folder.path() / ".veriflex-1-0.part";
  const fs::path held = folder.path() / ".veriflex-2-0.part";
  folder.write(".veriflex-1-0.part", "");
  for (const char* name : {"movie.part1", "movie.part", ".veriflex-notes"}) folder.write(name, "mine");
  const int file = open(held.c_str(), O_CREAT | O_WRONLY, 0600);
  REQUIRE(flock(file, LOCK_EX) == 0);
  io::write_file(folder.path() / "x", std::string("whole"));
  CHECK_FALSE(fs::exists(stale));
  CHECK(fs::exists(held));
  for (const char* name : {"movie.part1", "movie.part", ".veriflex-notes"})
    CHECK(fs::exists(folder.path() / name));
  close(file);
  folder.write("bad.toml", good_case);
  const Ran small = folder.shell("ulimit -f 8; \"$V\" run bad.toml --out small");
  CHECK(small.code == 4);
  CHECK(fs::is_empty(folder.path() / "small"));
}

TEST_CASE("Files replace files, never links, devices or pipes") {
  const Folder folder;
  folder.write("target", "mine");
  fs::create_symlink("target", folder.path() / "link");
  fs::create_symlink("nowhere", folder.path() / "dangling");
  REQUIRE(mkfifo((folder.path() / "pipe").c_str(), 0600) == 0);
  for (const char* name : {"link", "dangling", "pipe"}) {
    CHECK_THROWS_AS(io::write_file(folder.path() / name, std::string("x")), OutputError);
  }
  CHECK(fs::is_symlink(folder.path() / "link"));
  CHECK(unit::contents(folder.path() / "target") == "mine");
  CHECK(folder.left_aside().empty());
}

#ifndef __SANITIZE_ADDRESS__
TEST_CASE("Out of memory in one case of three: it is named and stored, the others run, the report is drawn") {
  const Folder folder;
  folder.write("cs/m.toml", large("m"));
  folder.write("cs/a.toml", named("a"));
  folder.write("cs/z.toml", named("z"));
  const Ran ran = folder.shell("ulimit -d 2000000; \"$V\" verify --cases cs --out o --threads 1");
  CHECK(ran.code == 3);
  CHECK_THAT(ran.err, ContainsSubstring("m.toml: out of memory"));
  CHECK(attribute(folder.path() / "o/m.h5", "error_kind") == "memory");
  CHECK(attribute(folder.path() / "o/z.h5", "verdict") == "pass");
  CHECK(fs::exists(folder.path() / "o/report.html"));
}

TEST_CASE("A box beyond the memory that a limit leaves to the process is refused by name") {
  const Folder folder;
  folder.write("box.toml", large("box"));
  const Ran ran = folder.shell("ulimit -v 4000000; \"$V\" run box.toml --out out");
  CHECK(ran.code == 2);
  CHECK_THAT(ran.err, ContainsSubstring("box.toml:12"));
  CHECK_THAT(ran.err, ContainsSubstring("GB are available"));
}

TEST_CASE("Threads that cannot be had are done without") {
  const Folder folder;
  folder.write("bad.toml", good_case);
  const Ran ran = folder.shell("ulimit -v 1500000; \"$V\" run bad.toml --out o --threads 1000");
  CHECK(ran.code == 0);
  CHECK_THAT(ran.err, ContainsSubstring("threads instead of 1000"));
  CHECK(attribute(folder.path() / "o/bad.h5", "verdict") == "pass");
}
#endif

TEST_CASE("Places that are none: one message each, no abort") {
  const Folder folder;
  folder.write("bad.toml", good_case);
  folder.write("broken.toml", "x");
  const std::string too_long(300, 'a');
  CHECK(folder.run({"run", "broken.toml", "--out", too_long}).code == 4);
  CHECK(folder.run({"run", "bad.toml", "--out", too_long}).code == 4);
  CHECK(folder.run({"run", "bad.toml", "--out", "/dev/null"}).code == 4);
  CHECK(folder.run({"report", too_long}).code == 2);
  CHECK(folder.run({"list", "--cases", too_long}).code == 2);
  CHECK(folder.run({"validate", too_long}).code == 2);
  const Ran gone = folder.shell("mkdir gone; cd gone; rmdir ../gone; \"$V\" list --json");
  CHECK(gone.code < 5);
}
