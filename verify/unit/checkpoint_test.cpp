// Runs that leave checkpoints behind, and go on from them as if nothing had happened.
#include "engine/checkpoint.hpp"

#include <bit>
#include <csignal>
#include <map>

#include "base/parts.hpp"
#include "base/stop.hpp"
#include "catch.hpp"
#include "engine/result.hpp"
#include "io/file.hpp"
#include "measures/scene/scene.hpp"
#include "observe/attach.hpp"
#include "unit/command.hpp"

using namespace veriflex;
namespace fs = std::filesystem;
using unit::Folder;
using unit::Ran;
using unit::replaced;

namespace {

const std::string rod_in_channel = R"(
[fluid]
nodes = [10, 10, 12]
relaxation_time = 0.8
walls_x = {}
body_force = [0.0, 0.0, 1e-6]

[[body]]
name = "rod"
shape = { rod = { radius = 1.0, sections = 5 } }
place = [5.0, 5.0, 3.0]
bond = { law = "harmonic", bond_stiffness = 0.26, rest_length = 1.0 }
angle = { stiffness = 0.025 }
drive = { nodes = "first section", direction = "x", amplitude = 0.2, period = 100.0 }
substeps = "auto"
coupling = {}

[[observe]]
what = "momentum"
every = 7

[[observe]]
what = "forces"
every = 10

[[observe]]
what = "strain"
every = 13

[[observe]]
what = "rigid motion"

[[observe]]
what = "energies"
every = 9

[[observe]]
what = "slip"
every = 8

[[observe]]
what = "probe"
fields = ["density", "velocity", "stress"]
point = [{ node = [5, 2, 9] }]
every = 11

[[observe]]
what = "nodes"
body = "rod"
every = 30
)";

constexpr std::int64_t steps = 90;

/// A scene of a text that runs as the driver `scene` runs it.
struct Live {
  explicit Live(const std::string& text, const observe::MonitorSpec& monitor = {})
      : top(io::parse_document(text, "scene.toml")),
        scene(measures::read_fluid_and_bodies(top).scene),
        observations(measures::read_observations(top, scene, 100.0, steps)),
        simulation(scene),
        run(simulation, monitor, make_observers(), "", progress) {}

  std::vector<observe::Observer> make_observers() {
    std::vector<observe::Observer> observers;
    for (const measures::Observation& o : observations) {
      memories.push_back(measures::add_observers(o, scene, records, records.size(), observers));
      records.push_back(measures::empty_record(o, scene));
    }
    return observers;
  }

  measures::Running running() { return {simulation, run, records, memories, progress}; }

  io::Table top;
  scene::Scene scene;
  std::vector<measures::Observation> observations;
  std::vector<observe::Record> records;
  std::vector<std::shared_ptr<std::vector<double>>> memories;
  Progress progress{"test"};
  scene::Simulation simulation;
  observe::Run run;
};

bool same_bits(const std::vector<observe::Record>& a, const std::vector<observe::Record>& b) {
  for (std::size_t r = 0; r < a.size(); ++r) {
    for (std::size_t c = 0; c < a[r].columns.size(); ++c) {
      const std::vector<double>& one = a[r].columns[c].values;
      const std::vector<double>& other = b[r].columns[c].values;
      const auto same = [](double x, double y) {
        return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y);
      };
      if (!std::equal(one.begin(), one.end(), other.begin(), other.end(), same)) {
        UNSCOPED_INFO("record " << a[r].name << ", column " << a[r].columns[c].name);
        return false;
      }
    }
  }
  return a.size() == b.size() && !a.empty();
}

/// A run that would not end while a test looks on.
const std::string endless =
    unit::case_head("endless") + rod_in_channel + "[run]\nsteps = 100000000\ncheckpoint = 0.001\n";

engine::Case a_case() {
  engine::Case c{};
  c.id = "mine";
  c.text = "one\ntwo\nthree\n";
  c.path = "mine.toml";
  return c;
}

/// A checkpoint of that case as this program writes it.
fs::path write_checkpoint(const Folder& folder, const engine::Case& c) {
  const fs::path path = engine::checkpoint_path(c, folder.path());
  engine::Checkpoints checkpoints(path, c, false);
  checkpoints.write(7, [](io::Hdf5Image& image) { image.group("/simulation"); });
  return path;
}

std::string refusal(const fs::path& path, const engine::Case& c) {
  try {
    const engine::Checkpoints checkpoints(path, c, true);
  } catch (const InputError& error) {
    return error.what();
  }
  return "none";
}

}  // namespace

TEST_CASE("A scene that is put back from a checkpoint goes on bit by bit, with all its records") {
  const std::vector<std::string> texts{
      rod_in_channel, replaced(rod_in_channel, "relaxation_time = 0.8", "relaxation_time = 1.0"),
      replaced(rod_in_channel, "relaxation_time = 0.8", "relaxation_time = 0.8\nstorage = \"float\""),
      replaced(rod_in_channel, "substeps = \"auto\"", "substeps = 2\nmax_substeps = 16"),
      replaced(rod_in_channel, "walls_x = {}\n", "")};
  const std::string& text = texts[static_cast<std::size_t>(GENERATE(0, 1, 2, 3, 4))];
  const int before = GENERATE(1, 29, 89);
  CAPTURE(text, before);
  Live whole(text);
  whole.run.advance(steps, steps);
  whole.run.finish();

  const Folder folder;
  Live first(text);
  first.run.advance(before, steps);
  io::Hdf5Image image;
  first.running().put_in(image);
  io::write_file(folder.path() / "checkpoint", image.bytes(io::checkpoint_seal));

  Live second(text);
  second.running().take_from(io::Hdf5File(folder.path() / "checkpoint", io::checkpoint_seal));
  CHECK(second.simulation.steps() == before);
  second.run.advance(steps - before, steps);
  second.run.finish();
  CHECK(same_bits(whole.records, second.records));
}

TEST_CASE("Snapshots of a run that goes on are those of one that nobody disturbed, and so are their lists") {
  const std::string text =
      rod_in_channel +
      "[[observe]]\nwhat = \"body snapshot\"\nevery = 20\n"
      "[[observe]]\nwhat = \"fluid snapshot\"\nevery = 25\nfrom = [0, 0, 4]\nto = [9, 9, 4]\n";
  using Files = std::map<std::string, std::string>;
  const auto kept_in = [](Files& files) {
    return [&files](const std::string& name, std::string_view bytes) { files[name] = bytes; };
  };
  Files whole, parts;
  {
    const observe::Attaching attaching(kept_in(whole));
    Live live(text);
    live.run.advance(steps, steps);
    live.run.finish();
  }
  const observe::Attaching attaching(kept_in(parts));
  Live first(text);
  first.run.advance(45, steps);
  io::Hdf5Image image;
  first.running().put_in(image);
  const Folder folder;
  io::write_file(folder.path() / "checkpoint", image.bytes(io::checkpoint_seal));
  first.run.advance(10, steps);  // beyond the checkpoint, and killed there
  Live second(text);
  second.running().take_from(io::Hdf5File(folder.path() / "checkpoint", io::checkpoint_seal));
  second.run.advance(steps - 45, steps);
  second.run.finish();
  CHECK(whole.size() == 2 + 6 + 5);
  CHECK(parts == whole);
}

TEST_CASE("What a run knows of its last good state survives a checkpoint") {
  const std::string text = replaced(rod_in_channel, "relaxation_time = 0.8", "relaxation_time = 1.0");
  Live first(text);
  first.run.advance(5, steps);
  const Folder folder;
  io::Hdf5Image image;
  first.running().put_in(image);
  io::write_file(folder.path() / "checkpoint", image.bytes(io::checkpoint_seal));
  Live second(text);
  second.running().take_from(io::Hdf5File(folder.path() / "checkpoint", io::checkpoint_seal));
  const observe::Run::State one = first.run.state(), other = second.run.state();
  CHECK(one.checked == other.checked);
  REQUIRE(one.good.size() == other.good.size());
  for (std::size_t i = 0; i < one.good.size(); ++i) {
    CHECK(one.good[i].name == other.good[i].name);
    CHECK(one.good[i].value == other.good[i].value);
  }
  CHECK(one.good_nodes == other.good_nodes);
}

TEST_CASE("The largest work of each body's load so far survives a checkpoint") {
  const auto loaded = [](const std::string& name, const std::string& force) {
    return "[[body]]\nname = \"" + name +
           "\"\nshape = { rod = { radius = 1.0, sections = 5 } }\nplace = [5.0, 5.0, 3.0]\n" +
           "bond = { law = \"harmonic\", bond_stiffness = 0.26, rest_length = 1.0 }\nangle = { stiffness = "
           "0.025 }\n" +
           "clamped = \"first section\"\nload = { nodes = \"last section\", force = [" + force +
           ", 0.0, 0.0] }\n\n";
  };
  const std::string text = loaded("a", "1e-5") + loaded("b", "2e-5");
  const observe::MonitorSpec monitor{.every = 10, .bodies = {.energy_growth = 10.0}};
  Live first(text, monitor);
  first.run.advance(30, steps);
  const observe::Run::State before = first.run.state();
  REQUIRE(before.load_work.size() == 2);
  CHECK(before.load_work[0] > 0.0);
  CHECK(before.load_work[1] > 2.0 * before.load_work[0]);
  Live second(text, monitor);
  second.run.restore(before);
  CHECK(second.run.state().load_work == before.load_work);
  CHECK(before.checked == 30);
  CHECK(second.run.state().checked == before.checked);
}

TEST_CASE("What is built to put a state back does not count as built") {
  const Live live(replaced(rod_in_channel, "relaxation_time = 0.8", "relaxation_time = 1.0"));
  const parts::AllMade before = parts::made();
  {
    const parts::Aside aside;
    const parts::Built part(parts::Kind::Populations, 100.0);
  }
  const auto k = static_cast<std::size_t>(parts::Kind::Populations);
  CHECK(parts::made()[k].count == before[k].count);
}

TEST_CASE("A signal that comes while a step is held asks for a stop after it") {
  const stop::Handlers handlers;
  {
    const stop::Held whole_step;
    raise(SIGTERM);
    CHECK(!stop::asked());
  }
  CHECK(stop::asked());
  stop::signal = 0;
}

TEST_CASE("A checkpoint of another run is refused, and the message says what is not the same") {
  const Folder folder;
  engine::Case c = a_case();
  const fs::path path = write_checkpoint(folder, c);
  CHECK(refusal(path, c) == "none");
  c.text = "one\ntwo\nfour\n";
  CHECK_THAT(refusal(path, c), ContainsSubstring("the case file has changed since, from line 3 on"));
  c = a_case();
  c.overrides = {"run.steps=5"};
  CHECK_THAT(refusal(path, c), ContainsSubstring("it was changed by --set nothing, this run by run.steps=5"));

  io::Hdf5Image image;
  image.attribute("/", "schema", std::int64_t{1});
  image.attribute("/", "settings", std::string());
  image.attribute("/", "program", std::string("another"));
  image.text("/case", a_case().text);
  io::write_file(path, image.bytes(io::checkpoint_seal));
  CHECK_THAT(refusal(path, a_case()), ContainsSubstring("it was made by program another, this is"));

  io::write_file(path, image.bytes());  // sealed as a result
  CHECK_THAT(refusal(path, a_case()), ContainsSubstring("no veriflex-checkpoint"));
}

TEST_CASE("Numbers for which a scene has no place are refused by name") {
  const Folder folder;
  const fs::path path = folder.path() / "checkpoint";
  const auto refused = [&](const std::string& text, const io::Hdf5Image& image) {
    io::write_file(path, image.bytes(io::checkpoint_seal));
    Live live(text);
    try {
      live.running().take_from(io::Hdf5File(path, io::checkpoint_seal));
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  // What scenes with another fluid and another body have left.
  io::Hdf5Image whole;
  Live(rod_in_channel).running().put_in(whole);
  CHECK_THAT(refused(replaced(rod_in_channel, "[10, 10, 12]", "[10, 10, 13]"), whole),
             ContainsSubstring("18000 values in /simulation/fluid/populations, not 19500"));
  CHECK_THAT(refused(replaced(rod_in_channel, "sections = 5", "sections = 6"), whole),
             ContainsSubstring(" values in /simulation/body_0/displacement, not "));

  const std::string alone = rod_in_channel.substr(rod_in_channel.find("[[body]]"));
  const std::string text =
      replaced(alone.substr(0, alone.find("[[observe]]")), "substeps = \"auto\"\ncoupling = {}\n", "");
  const std::size_t numbers = 3 * static_cast<std::size_t>(Live(text).simulation.body().positions().rows());
  struct Left {
    std::size_t displacement, velocity, linearised_at, stiffest, substep;
    std::int64_t steps = 0, substeps = 1;
  };
  const auto of = [&](const Left& left, const std::vector<double>& warned = {}) {
    const std::string body = "/simulation/body_0/";
    io::Hdf5Image image;
    image.group("/simulation");
    image.attribute("/simulation", "steps", left.steps);
    image.group("/simulation/body_0");
    image.attribute("/simulation/body_0", "steps", left.steps);
    image.attribute("/simulation/body_0", "own_steps", left.steps);
    image.attribute("/simulation/body_0", "substeps", left.substeps);
    for (const auto& [name, count] :
         {std::pair{"displacement", left.displacement}, std::pair{"velocity", left.velocity},
          std::pair{"linearised_at", left.linearised_at}, std::pair{"stiffest", left.stiffest},
          std::pair{"substep", left.substep}}) {
      image.numbers(body + name, std::vector<double>(count));
    }
    if (!warned.empty()) {
      image.group("/run/good");
      image.attribute("/run", "checked", left.steps);
      for (const char* column : {"name", "dimension", "meaning"}) {
        image.texts(std::string("/run/good/") + column, {});
      }
      image.numbers("/run/good/value", {});
      image.numbers("/run/good_nodes/0", std::vector<double>(numbers));
      image.numbers("/run/load_work", {});
      image.numbers("/run/warned", warned);
    }
    return refused(text, image);
  };
  CHECK_THAT(of({numbers, numbers, 0, 1, 1}),
             ContainsSubstring("/run"));  // all is right but what is no more there
  CHECK_THAT(of({numbers, numbers, numbers, 1, 1}), ContainsSubstring("/run"));
  CHECK_THAT(of({numbers, numbers, 3, 1, 1}),
             ContainsSubstring("3 values in /simulation/body_0/linearised_at"));
  CHECK_THAT(of({0, numbers, 0, 1, 1}), ContainsSubstring("0 values in /simulation/body_0/displacement"));
  CHECK_THAT(of({numbers, numbers + 1, 0, 1, 1}), ContainsSubstring("values in /simulation/body_0/velocity"));
  CHECK_THAT(of({numbers, numbers, 0, 0, 1}),
             ContainsSubstring("0 values in /simulation/body_0/stiffest, not 1"));
  CHECK_THAT(of({numbers, numbers, 0, 1, 2}),
             ContainsSubstring("2 values in /simulation/body_0/substep, not 1"));
  CHECK_THAT(of({numbers, numbers, 0, 1, 1, -1}), ContainsSubstring("'steps' of /simulation is -1"));
  CHECK_THAT(of({numbers, numbers, 0, 1, 1, 0, 0}),
             ContainsSubstring("'substeps' of /simulation/body_0 is 0"));
  CHECK_THAT(of({numbers, numbers, 0, 1, 1}, {0.0}), ContainsSubstring("1 values in /run/warned"));
  CHECK_THAT(of({numbers, numbers, 0, 1, 1}, {0.0, 1.0}), ContainsSubstring("/warnings"));  // not there

  // What a series keeps: of one that keeps more, in the place of one with fewer columns.
  const auto observed = [&](const std::string& what) {
    return text + "[[observe]]\nwhat = \"" + what + "\"\nevery = 10\n";
  };
  io::Hdf5Image turned;
  Live(observed("rigid motion")).running().put_in(turned);
  CHECK(refused(observed("rigid motion"), turned) == "none");
  CHECK_THAT(refused(observed("strain"), turned), ContainsSubstring("3 values in /memories/0, not 2"));
}

TEST_CASE("A checkpoint that cannot be written does not end the run") {
  const Folder folder;
  folder.write("file", "");
  const engine::Case c = a_case();
  engine::Checkpoints checkpoints(folder.path() / "file" / "mine.checkpoint", c, false);
  CHECK_NOTHROW(checkpoints.write(1, [](io::Hdf5Image& image) { image.group("/simulation"); }));
  CHECK_NOTHROW(checkpoints.write(2, [](io::Hdf5Image&) { throw std::bad_alloc(); }));
}

TEST_CASE("A run that is asked to stop leaves a checkpoint and says how it goes on") {
  const Folder folder;
  folder.write("endless.toml", endless);
  const std::string run = "\"$V\" run endless.toml --out out --threads 1";
  const Ran stopped = folder.shell(run + " & P=$!; " + unit::until("[ -e out/endless.checkpoint ]") +
                                   "; kill -TERM $P; wait $P");
  CHECK(stopped.code == 3);
  CHECK_THAT(stopped.err, ContainsSubstring("interrupted by SIGTERM"));
  CHECK_THAT(stopped.err, ContainsSubstring("run it again with --resume"));
  const fs::path checkpoint = folder.path() / "out/endless.checkpoint";
  REQUIRE(fs::exists(checkpoint));
  const auto step = io::Hdf5File(checkpoint, io::checkpoint_seal).integer("/", "step");

  // One that is written anew is another file.
  const Ran further =
      folder.shell("ln out/endless.checkpoint earlier; " + run + " --resume & P=$!; " +
                   unit::until("! [ out/endless.checkpoint -ef earlier ]") + "; kill -HUP $P; wait $P");
  CHECK(further.code == 3);
  CHECK(io::Hdf5File(checkpoint, io::checkpoint_seal).integer("/", "step") > step);

  folder.write("endless.toml", replaced(endless, "title = \"t\"", "title = \"u\""));
  const Ran changed = folder.run({"run", "endless.toml", "--out", "out", "--resume"});
  CHECK(changed.code == 2);
  CHECK_THAT(changed.err, ContainsSubstring("is a checkpoint of another run"));

  folder.write("endless.toml", endless);
  std::string bytes = unit::contents(checkpoint);
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  folder.write("out/endless.checkpoint", bytes);
  const Ran damaged = folder.run({"run", "endless.toml", "--out", "out", "--resume"});
  CHECK(damaged.code == 2);
  CHECK_THAT(damaged.err, ContainsSubstring("does not match its checksum"));
}

TEST_CASE("A run without a checkpoint begins at its start, and one that has ended leaves none") {
  const Folder folder;
  folder.write("endless.toml", replaced(endless, "steps = 100000000", "steps = 50"));
  const Ran ran = folder.run({"run", "endless.toml", "--out", "out", "--resume"});
  CHECK(ran.code == 0);
  CHECK_THAT(ran.err, ContainsSubstring("the run begins at its start"));
  CHECK(!fs::exists(folder.path() / "out/endless.checkpoint"));

  const Ran other = folder.run({"run", "derive-fene-lj", "--out", "out", "--resume"});
  CHECK(other.code == 2);
  CHECK_THAT(other.err, ContainsSubstring("leaves no checkpoints"));
}
