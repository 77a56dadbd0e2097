// Each way in which a run leaves its validity, through the real command: it stops with exit code 3, the
// message has step, place, value and bound, and the result holds the last good state.
#include <regex>

#include "catch.hpp"
#include "command.hpp"
#include "io/file.hpp"
#include "io/hdf5.hpp"
#include "repository.hpp"

using namespace veriflex;
using unit::Folder;
using unit::Ran;
using unit::replaced;

namespace {

/// A short filament in a small box, driven hard.
const std::string filament = unit::case_head("bad", "filament") + R"(
[bond]
law = "fene-lj"
epsilon = 0.000287
sigma = 1.0407

[compared_bond]
law = "harmonic"
bond_stiffness = 0.26
rest_length = 1.0

[angle]
stiffness = 0.025

[solid]
shape = "rod"
radius = 1.0
sections = 8
spacing = 1.0

[fluid]
nodes = [16, 20, 24]
relaxation_time = 1.0

[filament]
node_mass = 1.0
substeps = 4
amplitude = 5.0
reynolds = 10.0
periods = 2

[monitor]
every = 5
mach_limit = 0.3

[[check]]
kind = "verification"
statement = "it runs"
metric = "period"
target = 1.0
target_kind = "analytic"
source = "none"
tolerance = { relative = 1e9, reason = "never reached" }
)";

const std::string harmonic = replaced(filament, "law = \"fene-lj\"\nepsilon = 0.000287\nsigma = 1.0407",
                                      "law = \"harmonic\"\nbond_stiffness = 0.26\nrest_length = 1.0");

const std::string result = "out/bad.h5";

/// Runs the case, which must break off with a message like `pattern`, in the result too.
void break_off(const Folder& folder, const std::string& text, const std::string& pattern) {
  folder.write("bad.toml", text);
  const Ran ran = folder.run({"run", "bad.toml", "--out", "out"});
  INFO(ran.err);
  REQUIRE(ran.code == 3);
  CHECK(std::regex_search(ran.err, std::regex(pattern)));
  const io::Hdf5File file(folder.path() / result);
  CHECK(file.attribute("/", "verdict") == "error");
  CHECK(file.attribute("/", "error_kind") == "numerical");
  CHECK(std::regex_search(file.attribute("/", "error_message"), std::regex(pattern)));
  CHECK(file.texts("/checks/verdict").empty());
}

double metric(const io::Hdf5File& file, const std::string& name) {
  const std::vector<std::string> names = file.texts("/metrics/name");
  const auto found = std::find(names.begin(), names.end(), name);
  REQUIRE(found != names.end());
  return file.numbers("/metrics/value")[static_cast<std::size_t>(found - names.begin())];
}

/// The step that the message names.
double step_of(const io::Hdf5File& file) {
  std::smatch found;
  const std::string message = file.attribute("/", "error_message");
  REQUIRE(std::regex_search(message, found, std::regex("step ([0-9]+)")));
  return std::stod(found[1]);
}

void check_last_good_stroke(const io::Hdf5File& file) {
  CHECK(metric(file, "last_good_step") < step_of(file));
  CHECK(metric(file, "last_good_mach") < 1e3);
  CHECK(metric(file, "last_good_min_density") > 0.0);
  CHECK(metric(file, "coupling_growth") > 0.0);
  const std::vector<double> z = file.numbers("/records/last_good_nodes/z");
  CHECK(z.size() == 8 * 5);
  for (const double each : z) CHECK(std::isfinite(each));
  CHECK(file.numbers("/records/stroke/time").size() == file.numbers("/records/stroke/force").size());
}

}  // namespace

TEST_CASE(
    "A bond at its limit stops the run with its nodes, length and bound, and the last good state is kept") {
  const Folder folder;
  break_off(folder, replaced(filament, "mach_limit = 0.3", "mach_limit = 1.0"),
            "fene-lj: step [0-9]+: bond of nodes [0-9]+ and [0-9]+ has length [0-9.]+, "
            "fene-lj is defined between 0 and [0-9.]+");
  const io::Hdf5File file(folder.path() / result);
  check_last_good_stroke(file);
  CHECK(metric(file, "last_good_step") > 0.0);
  CHECK(file.numbers("/records/stroke/time").size() > 2);
}

TEST_CASE("A fluid faster than the limit stops the run with its node, Mach number and bound") {
  const Folder folder;
  break_off(folder, replaced(filament, "mach_limit = 0.3", "mach_limit = 0.1"),
            "step [0-9]+, node \\([0-9]+, [0-9]+, [0-9]+\\): the Mach number is [0-9.]+, "
            "the limit is 0.1 \\(monitor.mach_limit\\)");
  const io::Hdf5File file(folder.path() / result);
  check_last_good_stroke(file);
  CHECK(metric(file, "last_good_mach") <= 0.1);
}

TEST_CASE("monitor.every says how often the fluid is checked") {
  const Folder folder;
  const std::string slow = replaced(filament, "mach_limit = 0.3", "mach_limit = 0.1");
  const std::string pattern = "the Mach number is";
  for (const int every : {5, 7}) {
    break_off(folder, replaced(slow, "every = 5", "every = " + std::to_string(every)), pattern);
    const io::Hdf5File file(folder.path() / result);
    CHECK(std::fmod(step_of(file), every) == 0.0);
    CHECK(metric(file, "last_good_step") == step_of(file) - every);
  }
}

TEST_CASE("A density that is not positive stops the run with its node, value and bound") {
  const Folder folder;
  // A fluid of hardly any viscosity, in which a node without angles is dragged to and fro.
  std::string text = replaced(harmonic, "relaxation_time = 1.0", "relaxation_time = 0.5001");
  text = replaced(replaced(text, "reynolds = 10.0", "reynolds = 100000.0"), "stiffness = 0.025",
                  "stiffness = 0.0");
  break_off(
      folder, replaced(text, "mach_limit = 0.3", "mach_limit = 1e9"),
      "step [0-9]+, node \\([0-9]+, [0-9]+, [0-9]+\\): the density is -[0-9.e+]+, it must stay above 0");
  const io::Hdf5File file(folder.path() / result);
  check_last_good_stroke(file);
}

TEST_CASE(
    "A filament whose stroke takes a support beyond a walled box is refused with its place and the box") {
  const Folder folder;
  folder.write("bad.toml", replaced(replaced(harmonic, "nodes = [16, 20, 24]", "nodes = [16, 20, 13]"),
                                    "[filament]", "walls_z = {}\n\n[filament]"));
  const Ran ran = folder.run({"run", "bad.toml", "--out", "out"});
  CHECK(ran.code == 2);
  CHECK(std::regex_search(ran.err,
                          std::regex("bad.toml:[0-9]+:[0-9]+: the filament leaves the fluid on its way "
                                     "along z \\(marker [0-9]+ is at z = [-0-9.]+: its support reaches "
                                     "node -?[0-9]+, beyond the walled box of nodes 0 to 12\\)")));
}

TEST_CASE("A velocity that is no number stops the run with its node, and the last good fluid is kept") {
  const Folder folder;
  std::string text = io::read_file(repository::cases() / "conservation-periodic.toml");
  text = replaced(replaced(text, "id = \"conservation-periodic\"", "id = \"bad\""), "velocity = 0.01",
                  "velocity = 0.05");
  text = replaced(text.substr(0, text.find("[sweep]")), "relaxation_time = 0.8", "relaxation_time = 0.5001");
  break_off(folder, text + "\n[monitor]\nevery = 500\nmach_limit = 1e300\n",
            "step 500, node \\([0-9]+, [0-9]+, [0-9]+\\): the velocity is -?nan, not a finite number");
  const io::Hdf5File file(folder.path() / result);
  CHECK(metric(file, "last_good_step") == 0.0);
  CHECK(metric(file, "last_good_min_density") > 0.0);
}

TEST_CASE("The report shows why a run broke off and where it stood last") {
  const Folder folder;
  break_off(folder, replaced(filament, "mach_limit = 0.3", "mach_limit = 0.1"), "the Mach number is");
  const Ran ran = folder.run({"report", "out"});
  CHECK(ran.code == 0);
  const std::string page = unit::contents(folder.path() / "out/report.html");
  CHECK(page.find("the limit is 0.1 (monitor.mach_limit)") != std::string::npos);
  CHECK(page.find("last_good_step") != std::string::npos);
}

TEST_CASE(
    "An unstable coupling is refused with its growth and a remedy, and runs when forced, with a warning") {
  const Folder folder;
  const std::string heavy = replaced(filament, "node_mass = 1.0", "node_mass = 0.2");
  folder.write("bad.toml", heavy);
  const Ran refused = folder.run({"run", "bad.toml", "--out", "out"});
  INFO(refused.err);
  CHECK(refused.code == 2);
  CHECK(std::regex_search(refused.err,
                          std::regex("bad.toml:[0-9]+:[0-9]+: the coupling of the fene-lj body "
                                     "to the fluid is unstable: perturbations grow by [0-9.]+ a step")));
  CHECK(refused.err.find("Use a node mass above") != std::string::npos);

  break_off(folder, replaced(heavy, "[filament]", "[coupling]\nallow_unstable = true\n\n[filament]"),
            "step [0-9]+");
  const io::Hdf5File file(folder.path() / result);
  CHECK(metric(file, "coupling_growth") > 1.1);
  CHECK(folder.run({"report", "out"}).code == 0);
  CHECK(unit::contents(folder.path() / "out/report.html").find("the coupling of the harmonic body to the") !=
        std::string::npos);
}

TEST_CASE(
    "A coupling that the fluid's own motion may stabilise is warned of, on standard error and in the "
    "report") {
  const Folder folder;
  std::string text =
      replaced(replaced(harmonic, "node_mass = 1.0", "node_mass = 0.6"), "periods = 2", "periods = 1");
  text = replaced(replaced(text, "amplitude = 5.0", "amplitude = 0.5"), "reynolds = 10.0", "reynolds = 1.0");
  folder.write("bad.toml", text);
  const Ran ran = folder.run({"run", "bad.toml", "--out", "out"});
  INFO(ran.err);
  CHECK(ran.code == 0);
  CHECK(std::regex_search(
      ran.err,
      std::regex(
          "bad: warning: the coupling of the harmonic body to the fluid is unstable: perturbations grow by "
          "1\\.0[0-9]+ a step, .*Use a node mass above 0\\.6")));
  CHECK(folder.run({"report", "out"}).code == 0);
  CHECK(unit::contents(folder.path() / "out/report.html")
            .find("Warning:</strong> the coupling of the harmonic") != std::string::npos);
}
