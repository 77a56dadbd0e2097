// Comparisons with another program's tables: what is compared, what is left out, and what is refused.
#include <fmt/format.h>

#include <cmath>

#include "base/progress.hpp"
#include "catch.hpp"
#include "engine/case.hpp"
#include "engine/cost.hpp"
#include "engine/verdict.hpp"
#include "io/document.hpp"
#include "io/file.hpp"
#include "measures/drivers.hpp"
#include "repository.hpp"
#include "studies/studies.hpp"
#include "unit/command.hpp"

using namespace veriflex;
using unit::Folder;
using unit::replaced;

namespace {

void write_table(const Folder& folder, const std::string& id, const std::string& csv) {
  folder.write(id + ".csv", csv);
  folder.write(id + ".toml",
               fmt::format("schema = 1\nid = \"{0}\"\nkind = \"peer-code\"\nsource = \"by hand\"\n"
                           "obtained = \"by hand\"\n[data]\nfile = \"{0}.csv\"\nsha256 = \"{1}\"\n",
                           id, io::sha256(csv)));
}

const std::string harmonic = "[bond]\nlaw = \"harmonic\"\nbond_stiffness = 100.0\nrest_length = 1.0\n";
const std::string fene = "[bond]\nlaw = \"fene-lj\"\nepsilon = 1.0\nsigma = 1.0\n";

// Three atoms in a row, numbered by hundreds.
const std::string row_of_three = R"(three in a row

3 atoms
2 bonds
1 atom types
2 bond types

-5 5 xlo xhi
-5 5 ylo yhi
-5 5 zlo zhi

Masses

1 1.0

Atoms # bond

100 1 1 0 0 0
200 1 1 0 0 1
300 1 1 0 0 2

Bonds

1 1 100 200
2 1 200 300
)";

const std::string at_rest =
    "step,id,x,y,z,vx,vy,vz\n0,100,0,0,0,0,0,0\n0,200,0,0,1,0,0,0\n0,300,0,0,2,0,0,0\n"
    "1,100,0,0,0,0,0,0\n1,200,0,0,1,0,0,0\n1,300,0,0,2,0,0,0\n";

struct Seen {
  observe::Observations observations;
  std::vector<std::string> warnings;

  double metric(const std::string& name) const {
    INFO(name);
    REQUIRE(observations.metric(name) != nullptr);
    return observations.metric(name)->value;
  }
};

Seen compared(const Folder& folder, const std::string& text) {
  const engine::Study study =
      measures::read_peer(io::parse_document(text, (folder.path() / "case.toml").string()));
  Progress progress("test");
  engine::Cost cost;
  Seen seen{engine::begin(study), {}};
  study.run(seen.observations, progress, cost);
  seen.warnings = progress.warnings();
  return seen;
}

std::string message_of(const Folder& folder, const std::string& text) {
  try {
    compared(folder, text);
  } catch (const std::exception& error) {
    return error.what();
  }
  return "no error";
}

// A motion of the three atoms against a table of frames.
struct Motion {
  Folder folder;
  std::string text = harmonic +
                     "[peer]\nkind = \"trajectory\"\ndata = \"x.data\"\ntable = \"t\"\nenergies = \"e\"\n" +
                     "time_step = 0.005\n";

  explicit Motion(const std::string& data = row_of_three, const std::string& frames = at_rest,
                  const std::string& energies = "step,total\n0,0\n") {
    folder.write("x.data", data);
    write_table(folder, "t", frames);
    write_table(folder, "e", energies);
  }
  std::string message() const { return message_of(folder, text); }
};

}  // namespace

TEST_CASE("A body at rest in a table of zeros is compared with error 0, not 0/0") {
  const Motion motion;
  const Seen seen = compared(motion.folder, motion.text);
  for (const char* name : {"position_error", "velocity_error", "energy_error", "energy_change"})
    CHECK(seen.metric(name) == 0.0);
  CHECK(seen.metric("dt_over_limit") == Approx(0.5 * 0.005 * std::sqrt(300.0)).epsilon(1e-9));
}

TEST_CASE("A table that ends with the start compares no motion, and is no success") {
  const std::string first = at_rest.substr(0, at_rest.find("1,100"));
  CHECK_THAT(Motion(row_of_three, first).message(), ContainsSubstring("no frame after the first"));
}

TEST_CASE("Messages about a body from a data file name its atoms' ids") {
  Motion motion(row_of_three, replaced(at_rest, "0,300,0,0,2", "0,300,0,0,2.7"));
  motion.text = replaced(motion.text, harmonic, fene);
  CHECK_THAT(motion.message(), ContainsSubstring("bond of nodes 200 and 300 has length 1.7"));
}

TEST_CASE("A row of another step than its frame's is refused, and steps that do not rise") {
  const std::string second = "20,100,0,0,0,0,0,0\n20,200,0,0,1,0,0,0\n20,300,0,0,2,0,0,0\n";
  CHECK(Motion(row_of_three, at_rest + second).message() == "no error");
  CHECK_THAT(Motion(row_of_three, at_rest + replaced(second, "20,200", "40,200")).message(),
             ContainsSubstring("row 8 (id 200) is of step 40 (it stands in the frame of step 20"));
  CHECK_THAT(Motion(row_of_three, at_rest + at_rest.substr(at_rest.find('\n') + 1)).message(),
             ContainsSubstring("the frame of step 0 follows that of step 1"));
  CHECK_THAT(Motion(row_of_three, replaced(at_rest, "0,300", "0.5,300")).message(),
             ContainsSubstring("a row of step 0.5"));
  CHECK_THAT(Motion(row_of_three, replaced(at_rest, "0,300", "0,1e300")).message(),
             ContainsSubstring("a row of id 1e+300"));
  CHECK_THAT(Motion(row_of_three, at_rest, "step,total\n0,1\n20,1\n20,1\n").message(),
             ContainsSubstring("the steps of the energies do not rise"));
}

TEST_CASE("Masses of the data file are used, and refused where they differ or contradict the case") {
  const std::string heavy = replaced(row_of_three, "1 1.0", "1 4.0");
  // omega_max^2 = 3 k/m.
  const Motion motion(heavy);
  CHECK(compared(motion.folder, motion.text).metric("dt_over_limit") ==
        Approx(0.5 * 0.005 * std::sqrt(75.0)).epsilon(1e-9));
  CHECK_THAT(message_of(motion.folder, motion.text + "node_mass = 1.0\n"),
             ContainsSubstring("'node_mass' is 1 (the data file's atoms have mass 4)"));
  CHECK(message_of(motion.folder, motion.text + "node_mass = 4.0\n") == "no error");
  const std::string two =
      replaced(replaced(replaced(row_of_three, "1 atom types", "2 atom types"), "1 1.0", "1 1.0\n2 5.0"),
               "200 1 1", "200 1 2");
  CHECK_THAT(Motion(two).message(), ContainsSubstring("x.data:15:1: atoms have masses 1 and 5"));
}

TEST_CASE("Coefficients of the data file must agree with the case, and types without any are warned of") {
  const auto with_coefficients = [](const std::string& rows) {
    return replaced(row_of_three, "Atoms #", "Bond Coeffs # harmonic\n\n" + rows + "\n\nAtoms #");
  };
  // LAMMPS's harmonic energy is K (r - r0)^2 without the half.
  CHECK(Motion(with_coefficients("1 50 1.0\n2 500 1.2")).message() == "no error");  // type 2 is not used
  CHECK_THAT(Motion(with_coefficients("1 500 1.2\n2 50 1.0")).message(),
             ContainsSubstring("x.data:18:1: bonds of type 1 have bond_stiffness = 1000 (the case has 100"));
  const std::string two_types =
      replaced(with_coefficients("1 50 1.0\n2 500 1.2"), "2 1 200 300", "2 2 200 300");
  CHECK_THAT(Motion(two_types).message(), ContainsSubstring("x.data:19:1: bonds of type 2"));
  const Motion silent(replaced(row_of_three, "2 1 200 300", "2 2 200 300"));
  const Seen seen = compared(silent.folder, silent.text);
  REQUIRE(seen.warnings.size() == 1);
  CHECK_THAT(seen.warnings.front(), ContainsSubstring("bonds are of 2 types"));
  Motion other(with_coefficients("1 50 1.0\n2 500 1.2"));
  other.text = replaced(other.text, harmonic, fene);
  CHECK_THAT(other.message(),
             ContainsSubstring("bonds of type 1 are 'harmonic' (the case's bonds are fene-lj)"));
  Motion same(replaced(with_coefficients("1 30 1.5 1.0 1.0\n2 1 1 1 1"), "# harmonic", "# fene"));
  same.text = replaced(same.text, harmonic, fene);
  CHECK(same.message() == "no error");
  same.text = replaced(same.text, "sigma = 1.0", "sigma = 1.0\ncutoff = inf");
  CHECK_THAT(same.message(), ContainsSubstring("bonds of type 1 have cutoff = 1.122"));
}

TEST_CASE("Rows flagged as clamped are left out before anything is computed, and some must remain") {
  Folder folder;
  const std::string text = fene + "[peer]\nkind = \"bond-table\"\ntable = \"t\"\n";
  write_table(folder, "t", "r,energy,force,clamped\n0.97,1,1,0\n1.2,1,1,0\n1.45,50,-10,1\n1.52,77,-10,1\n");
  const Seen seen = compared(folder, text);
  CHECK(seen.metric("rows") == 2.0);
  CHECK(seen.metric("clamped_rows") == 2.0);
  CHECK(std::isfinite(seen.metric("clamped_force_error")));  // of the row at 1.45
  CHECK(std::isnan(seen.observations.record("bond_table")->find("force")->values.back()));
  write_table(folder, "t", "r,energy,force,clamped\n0.97,1,1,0\n1.52,77,-10,0\n");
  CHECK_THAT(message_of(folder, text), ContainsSubstring("length 1.52 of the table is outside the domain"));
  write_table(folder, "t", "r,energy,force,clamped\n1.45,5,5,1\n");
  CHECK_THAT(message_of(folder, text), ContainsSubstring("all 1 rows of 't' are flagged as clamped"));
}

TEST_CASE("Flags of a table belong to its rows, in whatever order its atoms stand") {
  Folder folder;
  folder.write("x.data", row_of_three);
  const std::string text = harmonic + "[peer]\nkind = \"node-forces\"\ndata = \"x.data\"\ntable = \"t\"\n";
  // The row of atom 300 is wrong and flagged; it stands first.
  write_table(
      folder, "t",
      "id,x,y,z,fx,fy,fz,fx_bond,fy_bond,fz_bond,e_bond,clamped\n"
      "300,0,0,2,9,9,9,9,9,9,9,1\n200,0,0,1,0,0,-10,0,0,-10,0.25,0\n100,0,0,-0.1,0,0,10,0,0,10,0.25,0\n");
  const Seen seen = compared(folder, text);
  CHECK(seen.metric("force_error") < 1e-14);
  CHECK(seen.metric("bond_energy_error") < 1e-13);
  CHECK(seen.metric("rows") == 2.0);
}

TEST_CASE("Node forces of a body without angles compare its bonds alone") {
  Folder folder;
  folder.write("x.data", row_of_three);
  write_table(folder, "t",
              "id,x,y,z,fx,fy,fz,fx_bond,fy_bond,fz_bond,e_bond\n100,0,0,0,0,0,10,0,0,10,0.25\n"
              "200,0,0,1.1,0,0,-10,0,0,-10,0.5\n300,0,0,2.0,0,0,-10,0,0,-10,0.25\n");
  const std::string text = "[peer]\nkind = \"node-forces\"\ndata = \"x.data\"\ntable = \"t\"\n";
  // Atom 2 is pulled back by the first bond and pushed back by the second: twice 10.
  for (const std::string& angle : {std::string(), std::string("[angle]\nstiffness = 0.0\n")}) {
    const Seen seen = compared(folder, harmonic + angle + text);
    CHECK(seen.metric("force_error") == Approx(2.0).epsilon(1e-12));  // 10 against -10, over 10
    CHECK(seen.observations.metric("angle_force_error") == nullptr);
  }
  write_table(folder, "t",
              "id,x,y,z,fx,fy,fz,fx_bond,fy_bond,fz_bond,e_bond\n100,0,0,0,0,0,10,0,0,10,0.25\n"
              "200,0,0,1.1,0,0,-20,0,0,-20,0.5\n300,0,0,2.0,0,0,10,0,0,10,0.25\n");
  const Seen seen = compared(folder, harmonic + text);
  CHECK(seen.metric("force_error") < 1e-14);
  CHECK(seen.metric("bond_energy_error") < 1e-13);
  CHECK_THAT(message_of(folder, harmonic + "[angle]\nstiffness = 1.0\n" + text),
             ContainsSubstring("has no angles"));
}

namespace {

// A 2 x 2 bar of five layers along z, as a data file; `more` are further atoms.
std::string bar(const std::string& more = "", int more_atoms = 0, double rounding = 0.0) {
  std::string atoms, bonds, angles;
  int bond = 0, angle = 0;
  const auto id = [](int x, int y, int z) { return 1 + x + 2 * y + 4 * z; };
  for (int z = 0; z < 5; ++z) {
    for (int y = 0; y < 2; ++y) {
      for (int x = 0; x < 2; ++x) {
        atoms += fmt::format("{} 1 1 {} {} {:.6f}\n", id(x, y, z), x, y, z + rounding * ((x + y + z) % 2));
        if (x == 0) bonds += fmt::format("{} 1 {} {}\n", ++bond, id(0, y, z), id(1, y, z));
        if (y == 0) bonds += fmt::format("{} 1 {} {}\n", ++bond, id(x, 0, z), id(x, 1, z));
        if (z < 4) bonds += fmt::format("{} 1 {} {}\n", ++bond, id(x, y, z), id(x, y, z + 1));
        for (const int dz : {-1, 1}) {  // between the bond along z and those across
          if (z + dz < 0 || z + dz > 4) continue;
          for (const int across : {id(1 - x, y, z), id(x, 1 - y, z)})
            angles += fmt::format("{} 1 {} {} {}\n", ++angle, id(x, y, z + dz), id(x, y, z), across);
        }
        angles += fmt::format("{} 1 {} {} {}\n", ++angle, id(1 - x, y, z), id(x, y, z), id(x, 1 - y, z));
      }
    }
  }
  return fmt::format(
      "bar\n\n{} atoms\n{} bonds\n{} angles\n1 atom types\n1 bond types\n1 angle types\n\nAtoms # "
      "angle\n\n{}{}\nBonds\n\n{}"
      "\nAngles\n\n{}",
      20 + more_atoms, bond, angle, atoms, more, bonds, angles);
}

const std::string stiff = harmonic + "[angle]\nstiffness = 0.1\n";

}  // namespace

TEST_CASE("A row without load is compared like any other, in whichever order the rows stand") {
  Folder folder;
  folder.write("x.data", bar());
  const std::string text =
      stiff + "[peer]\nkind = \"cantilever\"\ndata = \"x.data\"\ntable = \"t\"\nclamped_layers = 1\n";
  const std::string head = "force_per_node,tip_x,tip_z,e_bond,e_angle,clamp_reaction_x\n";
  const std::string zero = "0,0.5,4,0,0,0\n";
  write_table(folder, "t", head + zero);
  CHECK(compared(folder, text).metric("tip_error") == 0.0);
  // The values of a loaded row are this program's own: only their order is in question.
  write_table(folder, "t", head + "0.001,1.5,4,1,0,0.004\n0.002,1.5,4,1,0,0.008\n");
  const Seen own = compared(folder, text);
  const std::vector<double>& bent = own.observations.record("cantilever")->find("deflection")->values;
  const std::string first = fmt::format("0.001,{:.17g},4,1,0,0.004\n", 0.5 + bent[0]);
  const std::string second = fmt::format("0.002,{:.17g},4,1,0,0.008\n", 0.5 + bent[1]);
  std::vector<double> tip_errors;
  for (const std::string& rows : {zero + first + second, second + zero + first, first + second + zero}) {
    write_table(folder, "t", head + rows);
    const Seen seen = compared(folder, text);
    tip_errors.push_back(seen.metric("tip_error"));
    CHECK(seen.metric("reaction_error") < 1e-9);
    CHECK(std::isfinite(tip_errors.back()));
  }
  CHECK(tip_errors[1] == tip_errors[0]);
  CHECK(tip_errors[2] == tip_errors[0]);
}

TEST_CASE("What keeps a static comparison from an answer is named") {
  Folder folder;
  write_table(folder, "t", "strain,force_bottom,force_top,e_bond,e_angle\n0.01,4,-4,0.08,0\n");
  const std::string text = stiff + "[peer]\nkind = \"tensile\"\ndata = \"x.data\"\ntable = \"t\"\n";
  folder.write("x.data", bar());
  CHECK(compared(folder, text).metric("force_error") < 1e-10);
  folder.write("x.data", bar("", 0, 2e-6));
  CHECK_THAT(message_of(folder, text), ContainsSubstring("atoms 1 and 2 are 2e-06 apart along z"));
  folder.write("x.data", bar("21 1 1 5 5 0\n22 1 1 5 5 2\n", 2));
  CHECK_THAT(message_of(folder, text), ContainsSubstring("2 atoms are loose, the first is 21"));
}

TEST_CASE("Records of beams can be held against a table of one's own") {
  const std::string spring = "[bond]\nlaw = \"harmonic\"\nbond_stiffness = 0.26\nrest_length = 1.1\n";
  const std::string angle = "[angle]\nstiffness = 0.025\n";
  const std::string chain = "[solid]\nshape = \"chain\"\nnodes = 9\n";
  struct Held {
    std::string driver, text, record, x, y, first_x;
  };
  const std::string beam = angle + chain + "[beam]\nclamped = 2\nlength = 6\nfrequencies = 3\n";
  for (const Held& held :
       {Held{"elastica", angle + chain + "[elastica]\nclamped = 2\nlength = 6\nloads = [0.3, 1.7]\n",
             "elastica", "load", "deflection", "0.3"},
        {"beam", beam, "frequencies", "mode", "omega", "1"}}) {
    INFO(held.driver << ", " << held.record);
    Folder folder;
    const std::string text = fmt::format(
        "schema = 2\nid = \"case\"\ntitle = \"t\"\nquestion = \"a\"\nequation = \"e\"\nsources = []\ntier = "
        "\"quick\"\n"
        "topics = []\ndriver = \"{}\"\n{}{}[[check]]\nkind = \"verification\"\nstatement = \"s\"\nreference "
        "= "
        "\"t\"\n"
        "curve = {{ record = \"{}\", x = \"{}\", y = \"{}\" }}\n"
        "tolerance = {{ relative = 1e-12, floor = 0, reason = \"the same numbers\" }}\n",
        held.driver, spring, held.text, held.record, held.x, held.y);
    folder.write("case.toml", text);
    const auto verdict_with = [&](const std::string& csv) {
      write_table(folder, "t", csv);
      const engine::Case c =
          engine::read_case(folder.path() / "case.toml", {}, studies::readers(), repository::references());
      Progress progress("test");
      engine::Cost cost;
      observe::Observations seen = engine::begin(c.study);
      c.study.run(seen, progress, cost);
      return std::pair(engine::judge(c.checks.front(), c, seen).verdict, seen);
    };
    // What it measures, found with a table of one wrong point, is then the table.
    std::string csv = held.x + "," + held.y + "\n";
    const auto [wrong, seen] = verdict_with(csv + held.first_x + ",1e9\n");
    CHECK(wrong == engine::Verdict::fail);
    const observe::Record* record = seen.record(held.record);
    for (std::size_t i = 0; i < record->find(held.x)->values.size(); ++i)
      csv += fmt::format("{},{:.17g}\n", record->find(held.x)->values[i], record->find(held.y)->values[i]);
    CHECK(verdict_with(csv).first == engine::Verdict::pass);
  }
}
