// What a user can get wrong, each through the real command: one clear message, the right exit code, nothing
// half-written.
#include <fmt/format.h>

#include <cmath>

#include "catch.hpp"
#include "engine/columns.hpp"
#include "engine/result.hpp"
#include "io/file.hpp"
#include "io/hdf5.hpp"
#include "repository.hpp"
#include "unit/command.hpp"

using namespace veriflex;
namespace fs = std::filesystem;
using unit::Folder;
using unit::good_case;
using unit::Ran;
using unit::replaced;

namespace {

constexpr int input = 2;
constexpr int output = 4;

// Whether it reads `veriflex: place: problem (why). Suggestion`. By hand: std::regex takes the stack for long
// messages.
bool is_one_message(const std::string& text) {
  const std::string start = "veriflex: ";
  const std::size_t place = text.find(": ", start.size());
  if (!text.starts_with(start) || place == std::string::npos) return false;
  for (std::size_t at = text.find(". ", place); at != std::string::npos; at = text.find(". ", at + 1)) {
    const char next = at + 2 < text.size() ? text[at + 2] : ' ';
    if ((next >= 'A' && next <= 'Z') || next == '\'') return true;
  }
  return false;
}

void check_refusal(const Ran& ran, int code, const std::string& message) {
  INFO(ran.err);
  CHECK(ran.code == code);
  CHECK_THAT(ran.err, ContainsSubstring(message));
  CHECK(is_one_message(ran.err));
  CHECK(ran.err.find("terminate") == std::string::npos);
  CHECK(ran.err.find("Sanitizer") == std::string::npos);
}

struct Spoilt {
  std::string name;
  std::string text;     // of bad.toml
  std::string message;  // that must appear, with the place where it is known
};

std::string with(const std::string& from, const std::string& to) { return replaced(good_case, from, to); }
std::string and_then(const std::string& text) { return good_case + "\n" + text; }

const std::string tolerance = R"(tolerance = { relative = 1e-9, reason = "differences of forces" })";

std::string uncertainty(const std::string& numbers) {
  return "uncertainty = { reference = 0.1, " + numbers + ", reason = \"r\" }";
}

/// Against a published number, with this in the place of the tolerance.
std::string with_published(const std::string& uncertainty_of_it) {
  return replaced(with(tolerance, uncertainty_of_it), "target_kind = \"high-precision\"",
                  "target_kind = \"published-number\"");
}
const std::string target = R"(target = 1021.186296534041763399964
target_kind = "high-precision"
source = "40-digit arithmetic")";

std::vector<Spoilt> spoilt_cases() {
  const std::string claim = R"(kind = "claim"
claim = "young-modulus")";
  std::vector<Spoilt> all{
      {"misspelt key at the top", with("title", "titel"), "bad.toml:3:9: the file lacks 'title'"},
      {"misspelt key in a table", with("epsilon", "epislon"), "bad.toml:13:11: [bond] lacks 'epsilon'"},
      {"unknown key beside all known", with("lateral", "latteral = 1\nlateral"),
       "bad.toml:19:12: unknown key 'latteral'"},
      {"unknown table", and_then("[fluid]\ntau = 1"), "unknown key 'fluid' at the top level"},
      {"text for a number", with("epsilon = 1.0", "epsilon = \"1\""), "bad.toml:13:11: 'epsilon' is text"},
      {"number for a text", with("title = \"Bar of harmonic bonds\"", "title = 3"), "'title' is an integer"},
      {"table for a text", with("law = \"fene-lj\"", "law = {}"), "'law' is a table"},
      {"text for an array", with("[2, 2, 4]", "\"2 2 4\""), "bad.toml:18:9: 'nodes' is text"},
      {"text in an array of numbers", with("[-0.01, 0.01]", "[-0.01, \"a\"]"), "'strains' is text"},
      {"number for a table",
       with("tolerance = { relative = 1e-9, reason = \"differences of forces\" }", "tolerance = 1e-9"),
       "'tolerance' is a number"},
      {"negative eta", with("epsilon = 1.0", "epsilon = -1.0"), "bad.toml:13:11: 'epsilon' is -1"},
      {"zero sigma", with("sigma = 1.0", "sigma = 0.0"), "bad.toml:14:9: 'sigma' is 0"},
      {"infinite eta", with("epsilon = 1.0", "epsilon = inf"), "'epsilon' is inf"},
      {"NaN", with("epsilon = 1.0", "epsilon = nan"), "bad.toml:13:11: 'epsilon' is nan"},
      {"number beyond double precision", with("epsilon = 1.0", "epsilon = 1e999"), "bad.toml:13:"},
      {"integer beyond 64 bits", with("[2, 2, 4]", "[2, 2, 99999999999999999999]"), "bad.toml:18:"},
      {"numbers whose law leaves double precision", with("epsilon = 1.0", "epsilon = 1e308"),
       "bad.toml:11:1: 'fene_k' is inf"},
      {"Rc below the rest length", with("sigma = 1.0", "sigma = 1.0\ncutoff = 0.5"), "bad.toml:15:10:"},
      {"zero Rc", with("sigma = 1.0", "sigma = 1.0\ncutoff = 0.0"), "bad.toml:15:10: cutoff is not positive"},
      {"negative R0", with("sigma = 1.0", "sigma = 1.0\nr_max = -1.5"), "bad.toml:15:9: 'r_max' is -1.5"},
      {"parameter of another law", with("sigma = 1.0", "sigma = 1.0\nbond_stiffness = 1"),
       "unknown key 'bond_stiffness' at [bond]"},
      {"unknown law", with("fene-lj", "fene-jl"),
       "bad.toml:12:7: unknown bond law 'fene-jl' (known: harmonic, fene-lj, shifted-fene"},
      {"name near that of a law", with("fene-lj", "fene-jl"), "Did you mean 'fene-lj'?"},
      {"unknown driver", with("driver = \"tensile\"", "driver = \"tensil\""),
       "bad.toml:9:10: unknown driver 'tensil' (known: "},
      {"unknown shape", with("\"bar\"", "\"bra\""), "unknown shape 'bra'"},
      {"unknown tier", with("\"quick\"", "\"quik\""), "bad.toml:7:8: unknown tier 'quik'"},
      {"unknown kind", with("high-precision", "high-precison"), "unknown target_kind 'high-precison'"},
      {"unknown kind of check", with("\"verification\"", "\"verificaton\""), "unknown kind 'verificaton'"},
      {"two numbers for three nodes", with("[2, 2, 4]", "[2, 4]"), "'nodes' has 2 numbers"},
      {"no nodes along x", with("[2, 2, 4]", "[0, 2, 4]"), "'nodes' holds 0"},
      {"10^12 nodes", with("[2, 2, 4]", "[10000, 10000, 10000]"),
       "bad.toml:18:9: 10000 x 10000 x 10000 nodes are too many"},
      {"10^36 nodes", with("[2, 2, 4]", "[1000000000000, 1000000000000, 1000000000000]"),
       "nodes are too many"},
      {"R0 below the lattice spacing", with("[2, 2, 4]", "[2, 2, 4]\nspacing = 1.6"),
       "bad.toml:19:11: 'spacing' is 1.6 (bond law fene-lj is defined between 0 and 1.5)"},
      {"strain beyond the law's domain", with("[-0.01, 0.01]", "[0.6]"),
       "strain 0.6 is outside the domain of fene-lj"},
      {"strain of -100 %", with("[-0.01, 0.01]", "[-1.0]"), "strain -1 is outside the domain"},
      {"tolerance without reason", with(", reason = \"differences of forces\"", ""), "lacks 'reason'"},
      {"empty reason", with("differences of forces", ""), "'reason' is empty"},
      {"zero tolerance", with("relative = 1e-9", "relative = 0.0"), "tolerance is 0"},
      {"negative tolerance", with("relative = 1e-9", "relative = -1e-9"), "tolerance is -1e-09"},
      {"infinite tolerance", with("relative = 1e-9", "relative = inf"), "'relative' is inf"},
      {"two tolerances", with("relative = 1e-9", "relative = 1e-9, absolute = 1.0"), "tolerance has 2 of"},
      {"relative tolerance of zero", with("target = 1021.186296534041763399964", "target = 0.0"),
       "a relative tolerance of a target of zero"},
      {"NaN target", with("target = 1021.186296534041763399964", "target = nan"), "'target' is nan"},
      {"neither target nor reference", with(target, ""), "neither target nor reference"},
      {"both target and reference", with("target = ", "reference = \"x\"\ntarget = "),
       "both target and reference"},
      {"missing reference", with(target, "reference = \"fene-lj-rest-stat\""),
       "reference 'fene-lj-rest-stat' not found"},
      {"reference by a path that is too long", with(target, fmt::format("reference = \"{:r>5000}\"", "")),
       "not found"},
      {"reference without that value",
       with(target, "reference = \"fene-lj-rest-state\"\nquantity = \"young\""), "has no value 'young'"},
      {"tolerance tighter than the reference", with(target, "reference = \"wu-qi-2014-numbers\""),
       "is tighter than the reference's uncertainty"},
      {"uncertainty beside a tolerance", with("tolerance = {", "uncertainty = {}\ntolerance = {"),
       "both tolerance and uncertainty"},
      {"neither tolerance nor uncertainty", with(tolerance, ""), "neither tolerance nor uncertainty"},
      {"uncertainty against an exact law", with(tolerance, uncertainty("numerical = 0.1")),
       "an uncertainty against a target of kind 'high-precision'"},
      {"uncertainty without a numerical one", with_published(uncertainty("input = 0.1")),
       "neither numerical nor gci_along"},
      {"two numerical uncertainties",
       with_published(uncertainty("numerical = 0.1, gci_along = \"tensile.strains\"")),
       "both numerical and gci_along"},
      {"convergence index of one run", with_published(uncertainty("gci_along = \"tensile.strains\"")),
       "not of the values of a grid"},
      {"negative uncertainty", with_published(uncertainty("numerical = -0.1")), "'numerical' is -0.1"},
      {"nothing uncertain",
       with_published("uncertainty = { reference = 0.0, numerical = 0.0, reason = \"r\" }"),
       "all uncertainties are 0"},
      {"unknown metric", with("\"young_modulus\"", "\"young_modulu\""), "does not measure 'young_modulu'"},
      {"neither metric nor curve", with("metric = \"young_modulus\"", ""), "neither metric nor curve"},
      {"curve whose reference lacks the column",
       replaced(replaced(with("metric = \"young_modulus\"",
                              "curve = { record = \"stress_strain\", x = \"strain\", y = \"stress\" }"),
                         target, "reference = \"fene-lj-rest-state\""),
                "relative = 1e-9", "relative = 1e-9, floor = 1.0"),
       "has no column 'strain'"},
      {"curve without column",
       with("metric = \"young_modulus\"", "curve = { record = \"stress_strain\", x = \"strain\" }"),
       "lacks 'y'"},
      {"curve against a single target",
       replaced(with("metric = \"young_modulus\"",
                     "curve = { record = \"stress_strain\", x = \"strain\", y = \"stress\" }"),
                "relative = 1e-9", "relative = 1e-9, floor = 1.0"),
       "a curve needs a reference"},
      {"the same check twice", and_then(good_case.substr(good_case.find("[[check]]"))), "stands here twice"},
      {"claim without id", with("\"verification\"", "\"claim\""), "lacks 'claim'"},
      {"claim that the ledger lacks",
       replaced(with("kind = \"verification\"", claim), "young-modulus", "young-modulos"),
       "the ledger has no claim 'young-modulos' (claims of wu-qi-2014 stand in reference/claims). Did you "
       "mean 'young-modulus'?"},
      {"refuted without record",
       replaced(with("kind = \"verification\"", claim), "kind =", "expected_to_hold = false\nkind ="),
       "lacks 'recorded'"},
      {"record of a claim that is not refuted",
       replaced(with("kind = \"verification\"", claim),
                "kind =", "recorded = { value = 1, relative = 1e-9 }\nkind ="),
       "unknown key 'recorded'"},
      {"refutation of code", with("kind =", "expected_to_hold = false\nkind ="),
       "unknown key 'expected_to_hold'"},
      {"refutation that may depart by nothing",
       replaced(with("kind = \"verification\"", claim),
                "kind =", "expected_to_hold = false\nrecorded = { value = 1, relative = 0 }\nkind ="),
       "'relative' is 0"},
      {"assumption about nothing", and_then("[assumed]\n\"bond.cutof\" = \"not given\""),
       "the case has no value 'bond.cutof'"},
      {"assumption without a reason", and_then("[assumed]\n\"bond.epsilon\" = \"\""),
       "'bond.epsilon' is empty"},
      {"duplicate key", with("epsilon = 1.0", "epsilon = 1.0\nepsilon = 2.0"), "bad.toml:14:"},
      {"duplicate table", and_then("[bond]\nlaw = \"harmonic\""), "not valid TOML"},
      {"id that is not the file's name", with("id = \"bad\"", "id = \"good\""),
       "bad.toml:2:6: id 'good' differs from the file's name"},
      {"another schema", with("schema = 2", "schema = 3"),
       "bad.toml:1:10: 'schema' is 3 (this program reads schema 2). Write schema = 2"},
      {"an earlier schema", with("schema = 2", "schema = 1"),
       "bad.toml:1:10: 'schema' is 1 (this program reads schema 2). Write schema = 2"},
      {"an earlier schema with its names",
       replaced(replaced(with("schema = 2", "schema = 1"), "\nepsilon", "\ndepth"), "\nquestion", "\nasks"),
       "bad.toml:1:10: 'schema' is 1 (in schema 2, 'asks' is now 'question', 'depth' is now 'epsilon'). "
       "Write the "
       "new names and schema = 2"},
      {"an old key", with("epsilon", "depth"),
       "bad.toml:13:9: 'depth' is now 'epsilon' (since schema 2). Write the new name"},
      {"an old key of a check", with("target_kind", "kind"), "bad.toml"},
      {"an old kind of check", with("kind = \"verification\"", "question = \"code\""),
       "bad.toml:26:12: 'question' is now 'kind'"},
      {"an old table", and_then("[watch]\nevery = 5"), "bad.toml:34:1: 'watch' is now 'monitor'"},
      {"an old driver", with("driver = \"tensile\"", "driver = \"waves\""),
       "bad.toml:9:10: 'waves' is now 'dispersion'"},
      {"an old path in [assumed]", and_then("[assumed]\n\"bond.depth\" = \"not given\""),
       "'depth' is now 'epsilon'"},
      {"a symbol beside its name", with("epsilon = 1.0", "epsilon = 1.0\neta = 1.0"),
       "bad.toml:14:7: both 'epsilon' and 'eta' (they are two names of one parameter, the other stands at "},
      {"empty file", "", "bad.toml"},
      {"only a comment", "# nothing\n", "lacks 'schema'"},
      {"broken TOML", with("[solid]", "[solid"), "bad.toml:16:"},
      {"binary file",
       std::string("\x7f"
                   "ELF\0\1\2\xff\xfe",
                   9),
       "bad.toml:1:7: not valid TOML"},
      {"invalid UTF-8", with("Bar of", "Bar \xff\xfe of"), "bad.toml:3:"},
      {"zero byte in a text", with("Bar of", "Bar\\u0000of"), "holds a zero byte"},
      {"arrays nested beyond measure", and_then(fmt::format("x = {:[>100000}", "")), "not valid TOML"},
      {"inline tables nested beyond measure",
       [] {
         std::string deep;
         for (int i = 0; i < 100000; ++i) deep += "{a=";
         return and_then("x = " + deep);
       }(),
       "not valid TOML"},
      {"dotted key beyond measure",
       [] {
         std::string deep = "a";
         for (int i = 0; i < 300000; ++i) deep += ".a";
         return and_then(deep + " = 1");
       }(),
       "a key of more than 16 parts"},
      {"table name beyond measure",
       [] {
         std::string deep = "a";
         for (int i = 0; i < 300000; ++i) deep += ".'b,='";
         return and_then("[" + deep + "]");
       }(),
       "a key of more than 16 parts"},
  };
  return all;
}

struct Data {
  std::string name;
  std::string reference;  // text of table.toml; @SHA@ is the checksum of the data
  std::string csv;        // of table.csv; none when it starts with '!'
  std::string message;
};

const std::string table_reference = R"(schema = 1
id = "table"
kind = "analytic"
source = "U'(r)/r^2"
obtained = "by hand"

[data]
file = "table.csv"
sha256 = "@SHA@"
)";

const std::vector<Data> spoilt_references{
    {"wrong checksum", replaced(table_reference, "@SHA@", std::string(64, '0')), "strain,stress\n0.01,1\n",
     "does not match its checksum"},
    {"missing data file", table_reference, "!", "table.csv' does not exist"},
    {"text in the table", table_reference, "strain,stress\n0.01,abc\n",
     "table.csv:2:6: 'abc' is not a finite number"},
    {"NaN in the table", table_reference, "strain,stress\n0.01,nan\n",
     "table.csv:2:6: 'nan' is not a finite number"},
    {"huge number in the table", table_reference, "strain,stress\n0.01,1e999\n",
     "table.csv:2:6: '1e999' is not a finite number"},
    {"missing number", table_reference, "strain,stress\n0.01,\n", "table.csv:2:6: '' is not a finite number"},
    {"ragged rows", table_reference, "strain,stress\n0.01,1\n0.02\n",
     "table.csv:3:1: 1 fields (the table has 2 columns)"},
    {"column without name", table_reference, "strain,\n0.01,1\n", "table.csv:1:8: a column has no name"},
    {"column twice", table_reference, "strain,strain\n0.01,1\n", "column 'strain' twice"},
    {"no rows", table_reference, "strain,stress\n", "holds no table"},
    {"empty table", table_reference, "", "holds no table"},
    {"no data and no values", table_reference.substr(0, table_reference.find("[data]")), "!",
     "the reference holds neither values nor data"},
    {"unknown key in a reference", replaced(table_reference, "obtained", "uncertainty = 1\nobtained"),
     "strain,stress\n0.01,1\n", "unknown key 'uncertainty'"},
    {"unknown kind of reference", replaced(table_reference, "analytic", "analytical"),
     "strain,stress\n0.01,1\n", "table.toml:3:8: unknown kind 'analytical'"},
    {"published without citation", replaced(table_reference, "analytic", "published-curve"),
     "strain,stress\n0.01,1\n", "lacks 'citations'"},
    {"baseline without provenance", replaced(table_reference, "analytic", "baseline"),
     "strain,stress\n0.01,1\n", "lacks 'provenance'"},
    {"reference that is another", replaced(table_reference, "\"table\"", "\"other\""),
     "strain,stress\n0.01,1\n", "table.toml:2:6: id 'other' differs"},
    {"reference that is its own data", replaced(table_reference, "table.csv", "table.toml"), "!",
     "does not match its checksum"},
    {"data file that is a folder", replaced(table_reference, "table.csv", "."), "!", "does not exist"},
};

struct Line {
  std::string name;
  std::vector<std::string> arguments;
  int code;
  std::string message;
};

const std::vector<Line> lines{
    {"no command", {}, input, "command line: A subcommand is required"},
    {"unknown command", {"rum", "bad.toml"}, input, "Did you mean 'run'?"},
    {"unknown option", {"run", "bad.toml", "--treads", "2"}, input, "Did you mean '--threads'?"},
    {"option without value", {"run", "bad.toml", "--out"}, input, "command line: "},
    {"no case", {"run"}, input, "no case is named"},
    {"text for a number of threads", {"run", "bad.toml", "--threads", "two"}, input, "command line: "},
    {"no threads", {"run", "bad.toml", "--threads", "0"}, input, "command line: "},
    {"unknown tier", {"verify", "--tier", "quik"}, input, "command line: --tier"},
    {"missing case", {"run", "nowhere.toml"}, input, "command line: no case 'nowhere.toml'"},
    {"misspelt id", {"run", "derive-fene-jl"}, input, "Did you mean 'derive-fene-lj'?"},
    {"case name too long for a file", {"run", std::string(400, 'a')}, input, "command line: no case"},
    {"folder for a case", {"run", "."}, input, "is a folder"},
    {"device for a case", {"run", "/dev/zero"}, input, "is a device or pipe"},
    {"folder of no cases", {"list", "--cases", "nowhere"}, input, "no such folder of cases"},
    {"--set on an unknown key",
     {"run", "bad.toml", "--set", "bond.epsilno=1"},
     input,
     "--set bond.epsilno=1: unknown key 'epsilno' at [bond] (nothing reads it). Did you mean 'epsilon'?"},
    {"--set on an old key",
     {"run", "bad.toml", "--set", "bond.depth=1"},
     input,
     "--set bond.depth=1: 'depth' is now 'epsilon'"},
    {"--set on an unknown table",
     {"run", "bad.toml", "--set", "bnod.epsilon=1"},
     input,
     "unknown key 'bnod' at the top level (nothing reads it). Did you mean 'bond'?"},
    {"--set without value", {"run", "bad.toml", "--set", "bond.epsilon"}, input, "not of the form key=value"},
    {"--set without key", {"run", "bad.toml", "--set", "=1"}, input, "not of the form key=value"},
    {"--set of another type",
     {"run", "bad.toml", "--set", "bond.epsilon=deep"},
     input,
     "--set bond.epsilon=deep: 'epsilon' is text"},
    {"--set to a bad value",
     {"run", "bad.toml", "--set", "bond.epsilon=-1"},
     input,
     "--set bond.epsilon=-1: 'epsilon' is -1"},
    {"--set of more than one value",
     {"run", "bad.toml", "--set", "bond.epsilon=1\nx=2"},
     input,
     "more than one TOML value"},
    {"--set beyond the checks", {"run", "bad.toml", "--set", "check.7.target=1"}, input, "has no '7'"},
    {"a clamp as long as the rod",
     {"run", "crossflow-harmonic", "--set", "crossflow.clamped=60"},
     input,
     "60 of 21 sections are clamped"},
    {"a stream that nothing drives",
     {"run", "crossflow-harmonic", "--set", "fluid.body_force=[0.0,0.0,0.0]"},
     input,
     "does not drive a stream along z"},
    {"one box for a comparison",
     {"run", "immersed-rod", "--set", "immersed.boxes=[32]"},
     input,
     "fewer than two"},
    {"a rod that does not move",
     {"run", "immersed-rod", "--set", "immersed.amplitudes=[]"},
     input,
     "none, or one that is not positive"},
    {"nodes of a body without nodes",
     {"run", "immersed-rod", "--set", "coupling.nodes=[1]"},
     input,
     "the motion of these markers is given"},
    {"resolutions of a plate as a list",
     {"run", "immersed-plate", "--set", "immersed.resolutions=[16,32]"},
     input,
     "'immersed.resolutions' is now an axis of a sweep"},
    {"boxes that fall", {"run", "immersed-rod", "--set", "immersed.boxes=[32,16]"}, input, "they must rise"},
    {"moments of a fluid that keeps more",
     {"run", "scene-shear-wave-alone", "--set", "fluid.representation=\"moments\""},
     input,
     "moments alone are no state of this fluid"},
    {"moments at one of several relaxation times",
     {"run", "wave-shear-axis", "--set", "fluid.representation=\"moments\""},
     input,
     "only at tau = 1"},
    {"moments around bodies at another relaxation time",
     {"run", "immersed-spheres", "--set", "fluid.representation=\"moments\""},
     input,
     "'relaxation_time' is 0.8"},
    {"a representation that is none",
     {"run", "scene-shear-wave-alone", "--set", "fluid.representation=\"entropies\""},
     input,
     "known: auto, populations, moments"},
    {"a fluid without viscosity",
     {"run", "immersed-spheres", "--set", "fluid.relaxation_time=0.5"},
     input,
     "must be positive"},
    {"a variant that is no name",
     {"run", "filament-sensitivity-small", "--set", "variant.0.name=A-b"},
     input,
     "is no name for a metric"},
    {"a variant without sub-steps",
     {"run", "filament-sensitivity-small", "--set", "variant.0.filament.substeps=0"},
     input,
     "'substeps' is 0"},
    {"a filament without width",
     {"run", "filament-linear", "--set", "linear.hydrodynamic_radius=0"},
     input,
     "sections are rings of it"},
    {"unknown nodes of a point",
     {"run", "coupling-stability", "--set", "coupling.nodes=some"},
     input,
     "unknown nodes 'some'"},
    {"a body too light for its fluid",
     {"run", "filament-stroke", "--set", "filament.node_mass=0.2"},
     input,
     "--set filament.node_mass=0.2: the coupling of the fene-lj body"},
    {"output below a file",
     {"run", "bad.toml", "--out", "bad.toml/results"},
     output,
     "cannot be written (Not a directory). Choose another place with --out"},
    {"output below a device", {"run", "bad.toml", "--out", "/dev/null/results"}, output, "cannot be written"},
    {"output where nothing can be made",
     {"run", "bad.toml", "--out", "/proc/results"},
     output,
     "cannot be written"},
    {"output onto a folder",
     {"run", "bad.toml", "--out", "occupied"},
     output,
     "cannot be written (Is a directory)"},
    {"report on a folder without results", {"report", "empty"}, input, "no results"},
    {"report on no folder", {"report", "nowhere"}, input, "no results folder"},
    {"claims of a truncated result",
     {"claims", "--results", "truncated"},
     input,
     "bad.h5: does not match its checksum"},
    {"claims of another HDF5 file", {"claims", "--results", "not-hdf5"}, input, "bad.h5: has no checksum"},
    {"info on a missing case", {"info", "nowhere"}, input, "no case 'nowhere'"},
    {"validate of a missing case", {"validate", "nowhere"}, input, "no case 'nowhere'"},
    {"accept without reason", {"accept", "bad.toml"}, input, "--reason is required"},
    {"accept with an empty reason", {"accept", "bad.toml", "--reason", " "}, input, "command line: --reason"},
    {"accept over a reference",
     {"accept", "bad.toml", "--reason", "x"},
     input,
     "bad-baseline.toml: is no baseline"},
    {"derive of an unknown law", {"derive", "--law", "fene-jl"}, input, "--law: unknown bond law 'fene-jl'"},
    {"derive of a negative epsilon",
     {"derive", "--epsilon", "-1", "--sigma", "1"},
     input,
     "--epsilon: 'epsilon' is -1"},
    {"derive by an old option", {"derive", "--depth", "1"}, input, "'--depth' is now '--epsilon'"},
    {"derive of a parameter by name and symbol",
     {"derive", "--epsilon", "1", "--eta", "1", "--sigma", "1"},
     input,
     "command line: "},
    {"derive of text", {"derive", "--epsilon", "deep", "--sigma", "1"}, input, "command line: "},
    {"calibrate to a negative modulus",
     {"calibrate", "--young", "-1", "--spacing", "1", "--poisson", "0.3"},
     input,
     "--young"},
    {"calibrate to NaN",
     {"calibrate", "--young", "nan", "--spacing", "1", "--poisson", "0.3"},
     input,
     "--young"},
};

}  // namespace

TEST_CASE("Spoilt cases of waves, vortices and streams are refused with their place") {
  const Folder folder;
  const auto shipped = [](const std::string& id, const std::string& from, const std::string& to) {
    const std::string text = io::read_file(repository::cases() / (id + ".toml"));
    return replaced(replaced(text, "id = \"" + id + "\"", "id = \"bad\""), from, to);
  };
  const std::vector<Spoilt> all{
      {"a wave without direction", shipped("wave-shear-axis", "[1, 0, 0]", "[0, 0, 0]"),
       "bad.toml:17:13: 'direction' is no direction"},
      {"a shear wave that moves along itself", shipped("wave-shear-axis", "[0, 1, 0]", "[1, 1, 0]"),
       "it is not across 'direction'"},
      {"a wave without viscosity",
       shipped("wave-shear-axis", "relaxation_time = 0.8", "relaxation_time = 0.5"),
       "'relaxation_time' is 0.5"},
      {"a list of resolutions", shipped("vortex-taylor-green", "nodes = 32", "nodes = [16, 32]"),
       "bad.toml:16:9: 'nodes' is a list (a case measures one run, and its study makes many)"},
      {"the relaxation times of a wave",
       shipped("wave-shear-axis", "nodes = 32", "nodes = 32\nrelaxation_times = [0.6, 0.8]"),
       "'plane_wave.relaxation_times' is now an axis of a sweep"},
      {"resolutions of a channel", shipped("channel-duct", "nodes = 12", "resolutions = [12, 24]"),
       "Write [sweep] axes = [{ key = \"channel.nodes\""},
      {"time steps as a list", shipped("integrator-harmonic", "steps = 3200", "steps = [400, 800]"),
       "Write [sweep] axes = [{ key = \"integrator.steps\""},
      {"points of a boundary",
       shipped("coupling-stability", "[coupling]\n",
               "[[coupling_stability.point]]\nname = \"a\"\n[coupling]\n"),
       "Write [[ablate.variants]]"},
      {"a resolution without waves", shipped("vortex-taylor-green", "nodes = 32", "nodes = 2"),
       "'nodes' is 2"},
      {"a plane that is none", shipped("vortex-planes", "nodes = 32", "nodes = 32\nplane = \"zz\""),
       "unknown plane 'zz'"},
      {"a Reynolds number that is none", shipped("vortex-taylor-green", "reynolds = 10.0", "reynolds = -1.0"),
       "'reynolds' is -1"},
      {"a flow too fast", shipped("vortex-taylor-green", "reynolds = 10.0", "reynolds = 300.0"),
       "the flow would start at Mach number 1.62"},
      {"fluid that cannot leave", shipped("openings-channel", ", high_outflow = { density = 1.0 }", ""),
       "fluid enters the box and cannot leave it"},
      {"an inflow that flows out", shipped("openings-channel", "[0.005, 0.0", "[-0.005, 0.0"),
       "the fluid does not enter the box with it"},
      {"an inflow and a wall at one end",
       shipped("openings-channel", "walls_x = { ", "walls_x = { low_velocity = [0.0, 0.001, 0.0], "),
       "'low_inflow' and 'low_velocity' are both given"},
      {"an outflow of no density", shipped("openings-channel", "density = 1.0", "density = 0.0"),
       "'density' is 0"},
      {"walls around vortices", shipped("vortex-taylor-green", "[vortex]", "walls_y = {}\n[vortex]"),
       "this driver's box has no walls"},
      {"a force on vortices",
       shipped("vortex-taylor-green", "[vortex]", "body_force = [0, 0, 1e-6]\n[vortex]"),
       "this driver's flows have no force"},
      {"a stream too fast", shipped("galilean-taylor-green", "speed = 0.05", "speed = 0.2"),
       "'speed' is 0.2"},
      {"a period that has no eighths", shipped("channel-womersley", "period = 96", "period = 97"),
       "eighths of it are shown"},
      {"a channel that takes for ever", shipped("channel-duct", "nodes = 12", "nodes = 4000"),
       "a duct of 4000 nodes needs more than"},
  };
  for (const Spoilt& spoilt : all) {
    INFO(spoilt.name);
    folder.write("bad.toml", spoilt.text);
    check_refusal(folder.run({"run", "bad.toml"}), input, spoilt.message);
  }
}

TEST_CASE("A wave that is gone after one step is no rate but an error") {
  const Folder folder;
  std::string text = io::read_file(repository::cases() / "wave-shear-in-plane.toml");
  text = replaced(text.substr(0, text.find("[assumed]")), "id = \"wave-shear-in-plane\"", "id = \"bad\"");
  text =
      replaced(replaced(text, "relaxation_time = 0.8", "relaxation_time = 1.0"), "nodes = 32", "nodes = 4");
  folder.write("bad.toml", text);
  const Ran ran = folder.run({"run", "bad.toml"});
  CHECK(ran.code == 3);
  CHECK_THAT(ran.err, ContainsSubstring("tau = 1, 4 nodes: the wave is gone after one step"));
}

TEST_CASE("A spoilt case is refused with its place, and no earlier result stands for it") {
  const Folder folder;
  for (const Spoilt& spoilt : spoilt_cases()) {
    INFO(spoilt.name);
    folder.write("bad.toml", spoilt.text);
    folder.write("out/bad.h5", "an earlier result");
    check_refusal(folder.run({"run", "bad.toml", "--out", "out"}), input, spoilt.message);
    const io::Hdf5File result(folder.path() / "out/bad.h5");
    CHECK(result.attribute("/", "verdict") == "error");
    CHECK(result.attribute("/", "error_kind") == "input");
    const Ran validated = folder.run({"validate", "bad.toml"});
    CHECK(validated.code == input);
    CHECK_THAT(validated.err, ContainsSubstring(spoilt.message));
  }
  CHECK(folder.left_aside().empty());
}

TEST_CASE("A spoilt reference is refused with its place") {
  const Folder folder;
  folder.write("bad.toml", replaced(with(target, "reference = \"table\""), "young_modulus", "young_modulus"));
  for (const Data& spoilt : spoilt_references) {
    INFO(spoilt.name);
    std::filesystem::remove(folder.path() / "table.csv");
    std::string text = spoilt.reference;
    if (spoilt.csv != "!") folder.write("table.csv", spoilt.csv);
    if (text.find("@SHA@") != std::string::npos) text = replaced(text, "@SHA@", io::sha256(spoilt.csv));
    folder.write("table.toml", text);
    check_refusal(folder.run({"run", "bad.toml", "--out", "out"}), input, spoilt.message);
  }
  CHECK(folder.left_aside().empty());
}

TEST_CASE("A command line that makes no sense is refused") {
  const Folder folder;
  folder.write("bad.toml", good_case);
  folder.write("bad-baseline.toml", replaced(replaced(table_reference, "\"table\"", "\"bad-baseline\""),
                                             "@SHA@", io::sha256("x\n1\n")));
  folder.write("table.csv", "x\n1\n");
  folder.write("occupied/bad.h5/file", "");
  folder.write("empty/readme", "");
  REQUIRE(folder.run({"run", "bad.toml", "--out", "good"}).code == 0);
  const std::string whole = unit::contents(folder.path() / "good/bad.h5");
  folder.write("truncated/bad.h5", whole.substr(0, whole.size() / 2));
  folder.write("not-hdf5/bad.h5", "text");
  for (const Line& line : lines) {
    INFO(line.name);
    const Ran ran = folder.run(line.arguments);
    if (line.arguments.empty() || line.arguments.front() != "report") {
      // What `report` says comes from its script, which has tests of its own.
      check_refusal(ran, line.code, line.message);
    } else {
      CHECK(ran.code == line.code);
      CHECK_THAT(ran.err, ContainsSubstring(line.message));
    }
  }
  CHECK(folder.left_aside().empty());
  CHECK(unit::contents(folder.path() / "good/bad.h5") == whole);
}

TEST_CASE("Columns that differ in length and numbers that count nothing are refused by name") {
  const Folder folder;
  const fs::path path = folder.path() / "made.h5";
  io::Hdf5Image image;
  image.group("/records/curve");
  image.attribute("/records/curve", "columns", std::vector<std::string>{"x", "y"});
  image.numbers("/records/curve/x", std::vector{1.0, 2.0});
  image.numbers("/records/curve/y", std::vector{1.0});
  io::write_file(path, image.bytes());
  const io::Hdf5File file(path);
  const auto refusal = [](const auto& work) {
    try {
      work();
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  CHECK_THAT(refusal([&] { engine::read_record(file, "curve"); }),
             ContainsSubstring("made.h5: the columns of /records/curve differ in length"));
  observe::Record table{"curve", "", {{"x", "", "1", "", {1.0}}, {"w", "", "1", "", {}, {"word"}}}};
  CHECK(engine::numbers_in(table, "x", file).size() == 1);
  CHECK(engine::words_in(table, "w", file).size() == 1);
  CHECK_THAT(refusal([&] { engine::numbers_in(table, "w", file); }),
             ContainsSubstring("made.h5: there are no numbers 'w' in curve"));
  CHECK_THAT(refusal([&] { engine::words_in(table, "x", file); }),
             ContainsSubstring("there are no words 'x' in curve"));
  CHECK_THAT(refusal([&] { engine::words_in(table, "y", file); }), ContainsSubstring("no words 'y'"));
  CHECK(engine::count_of(0.0, file, "/n") == 0);
  CHECK(engine::count_of(0x1p53, file, "/n") == std::uint64_t{1} << 53);
  for (const double number : {-1.0, 0.5, 0x1p54, std::nan("")}) {
    CHECK_THAT(refusal([&] { engine::count_of(number, file, "/n"); }), ContainsSubstring(" in /n"));
  }
}

TEST_CASE("Byte order mark and CRLF are no errors") {
  const Folder folder;
  std::string text = "\xef\xbb\xbf";
  for (const char c : good_case) text += c == '\n' ? std::string("\r\n") : std::string(1, c);
  folder.write("bad.toml", text);
  CHECK(folder.run({"run", "bad.toml", "--out", "out"}).code == 0);
}

TEST_CASE("validate lists every problem") {
  const Folder folder;
  folder.write("bad.toml",
               and_then(replaced(good_case.substr(good_case.find("[[check]]")), "young_modulus", "young") +
                        "unit = 1\n[fluid]\ntau = 1"));
  const Ran ran = folder.run({"validate", "bad.toml", "nowhere"});
  CHECK(ran.code == input);
  CHECK_THAT(ran.err, ContainsSubstring("no case 'nowhere'"));
  CHECK_THAT(ran.err, ContainsSubstring("does not measure 'young'"));
  CHECK_THAT(ran.err, ContainsSubstring("unknown key 'fluid'"));
}

TEST_CASE("A file name that is no UTF-8 does not break the output") {
  const Folder folder;
  folder.write(
      "b\xff"
      "d.toml",
      good_case);
  const Ran ran = folder.run({"run",
                              "b\xff"
                              "d.toml",
                              "--json", "--out", "out"});
  CHECK(ran.code == input);
  CHECK(folder.run({"list", "--json", "--cases", "."}).code == 0);
}

TEST_CASE("What the HDF5 library refuses is told in its own words") {
  io::Hdf5Image image;
  image.group("/once");
  CHECK_THROWS_WITH(image.group("/once"), ContainsSubstring("name already exists"));
}
