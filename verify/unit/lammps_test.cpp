#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "base/error.hpp"
#include "catch.hpp"
#include "io/lammps_data.hpp"
#include "observe/snapshot.hpp"
#include "repository.hpp"
#include "scene/lammps_network.hpp"
#include "solid/elastic.hpp"

using namespace veriflex;

namespace {

// Three sides of a square and its centre's diagonal neighbour: ids out of order and with gaps, comments,
// sections in another order than LAMMPS writes them.
const std::string good = R"(a title that is not read: 99 atoms

4 atoms
3 bonds
2 angles
2 atom types
1 bond types
2 angle types

-1 5 xlo xhi
-1 5 ylo yhi
-1 5 zlo zhi

Masses

1 1.0
2 1.0

Bonds

7 1 10 20
2 1 30 20   # backwards
3 1 30 40

Atoms # angle

30 1 2 1 1 0
10 1 1 0 0 0 0 0 0
40 1 1 2 1 1e-3
20 1 1 1 0 0

Velocities

10 0 0 0
20 0 0 0
30 0 0 0
40 0 0 0

Angles

2 2 20 30 40
1 1 10 20 30
)";

std::string with(const std::string& from, const std::string& to) {
  std::string text = good;
  const std::size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

std::string message_of(const std::string& text) {
  try {
    scene::network_of(io::parse_lammps_data(text, "x.data"), {2});
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace

TEST_CASE("A LAMMPS data file is read whatever the order of its sections and ids") {
  const io::LammpsData data = io::parse_lammps_data(good, "x.data");
  REQUIRE(data.atoms.size() == 4);
  CHECK(data.atoms[0].id == 10);
  CHECK(data.atoms[2].id == 30);
  CHECK(data.atoms[2].type == 2);
  CHECK(data.atoms[3].position == std::array{2.0, 1.0, 1e-3});
  REQUIRE(data.bonds.size() == 3);
  CHECK(data.bonds[0].id == 2);
  CHECK(data.bonds[0].atoms == std::array<std::int64_t, 2>{30, 20});
  CHECK(data.bonds[0].line == 22);
  REQUIRE(data.angles.size() == 2);
  CHECK(data.angles[0].atoms == std::array<std::int64_t, 3>{10, 20, 30});
  CHECK(data.angle_types == 2);
}

TEST_CASE("Every atom style puts its fields where LAMMPS does") {
  const auto one = [](const std::string& style, const std::string& row) {
    const std::string text =
        "title\n2 atoms\n1 atom types\n\nAtoms  # " + style + "\n\n1 " + row + "\n2 " + row;
    return io::parse_lammps_data(text, "x.data").atoms[0].position;
  };
  const std::array wanted{4.0, -5.0, 0.5};
  CHECK(one("atomic", "1 4 -5 0.5") == wanted);
  CHECK(one("bond", "9 1 4 -5 0.5") == wanted);
  CHECK(one("angle", "9 1 4 -5 0.5 0 0 0") == wanted);
  CHECK(one("molecular", "9 1 4 -5 0.5") == wanted);
  CHECK(one("full", "9 1 0.25 4 -5 0.5\r") == wanted);
}

TEST_CASE("A data file becomes a network: nodes by rising id, angles between bonds that share the apex") {
  const solid::Network network = scene::network_of(io::parse_lammps_data(good, "x.data"), {2});
  REQUIRE(network.node_count() == 4);
  CHECK(network.rest(3, 0) == 2.0);
  REQUIRE(network.bonds.size() == 3);
  // Bond 2 of the file is the first, from atom 30 (node 2) to atom 20 (node 1).
  CHECK(network.bonds[0].first == 2);
  CHECK(network.bonds[0].second == 1);
  CHECK(Vec3(network.vectors.row(0)) == Vec3(0.0, -1.0, 0.0));
  CHECK(network.spacing == 1.0);  // the median: two bonds have it
  REQUIRE(network.angles.size() == 2);
  // Angle 1: apex atom 20, between bonds 7 (towards the apex) and 2 (towards it too).
  CHECK(network.angles[0].bond_a == 2);
  CHECK(network.angles[0].bond_b == 0);
  CHECK(network.angles[0].sign_a == -1);
  CHECK(network.angles[0].sign_b == -1);
  CHECK_FALSE(network.angles[0].straight);
  CHECK(network.angles[1].straight);
  CHECK(network.angles[1].sign_a == 1);
}

TEST_CASE("The lattice of the peer's bar is ours: same energy of the same displacement") {
  for (const char* name : {"paper", "unit"}) {
    const auto data = io::read_lammps_data(repository::references() / "lammps" /
                                           fmt::format("bar_4x4x12_{}", name) / "lattice.data");
    const solid::Network theirs = scene::network_of(data, {2});
    solid::Network ours = solid::cubic_lattice({{4, 4, 12}, theirs.spacing});
    solid::add_angles(ours);
    CHECK(theirs.bonds.size() == ours.bonds.size());
    CHECK(theirs.angles.size() == ours.angles.size());
    CHECK((theirs.rest - ours.rest).cwiseAbs().maxCoeff() < 1e-14);
    const bond::Harmonic law{1.0, theirs.spacing};
    const solid::HarmonicAngle angle{0.1};
    const Positions u = 0.05 * (37.0 * theirs.rest.array()).sin().matrix() +
                        0.03 * (theirs.rest.rowwise().reverse().array() * 11.0).cos().matrix();
    const auto energy_of = [&](const solid::Network& network) {
      solid::Workspace work;
      REQUIRE(solid::deform(law, network, u, work));
      return solid::energy(law, angle, network, work);
    };
    CHECK(energy_of(theirs) == Approx(energy_of(ours)).epsilon(1e-12));
  }
}

TEST_CASE("A body written as a data file is read as that body: places bit by bit, bonds, angles, mass") {
  for (const std::array<std::int64_t, 3> nodes : {std::array<std::int64_t, 3>{3, 2, 4}, {1, 1, 5}}) {
    scene::Body body{};
    body.material = {bond::Harmonic{0.26, 1.0}, 0.025};
    body.network = solid::cubic_lattice({nodes, 1.0});
    body.conditions.node_mass = 1.0 / 3.0;
    body.place = {4.0, 5.1, -6.0};
    body.name = "block";
    solid::add_angles(body.network);
    body.start.displacement = 0.1 * (37.0 * body.network.rest.array()).sin().matrix();
    const scene::MovingBody moving(body, nullptr);
    const std::string text = observe::lammps_data_of(moving, 0.0);
    const io::LammpsData data = io::parse_lammps_data(text, "written.data");
    const bool is_chain = nodes[0] == 1;
    CHECK(data.masses[0].mass == 1.0 / 3.0);
    CHECK(data.angle_types == (is_chain ? 1 : 2));
    CHECK_THAT(text, StartsWith("block, step 0; angles of type " + std::string(is_chain ? "1" : "2") +
                                " rest at 180 degrees"));
    const solid::Network read = scene::network_of(data, {data.angle_types});
    CHECK((read.rest.array() == moving.positions().array()).all());
    REQUIRE(read.bonds.size() == body.network.bonds.size());
    for (std::size_t b = 0; b < read.bonds.size(); ++b) {
      CHECK(read.bonds[b].first == body.network.bonds[b].first);
      CHECK(read.bonds[b].second == body.network.bonds[b].second);
    }
    REQUIRE(read.angles.size() == body.network.angles.size());
    for (std::size_t i = 0; i < read.angles.size(); ++i) {
      const solid::Angle &ours = body.network.angles[i], &theirs = read.angles[i];
      CHECK(theirs.bond_a == ours.bond_a);
      CHECK(theirs.bond_b == ours.bond_b);
      CHECK(theirs.sign_a == ours.sign_a);
      CHECK(theirs.sign_b == ours.sign_b);
      CHECK(theirs.straight == ours.straight);
    }
  }
}

TEST_CASE("The box of a written file holds the body, its longest bond from every face") {
  scene::Body body{};
  body.material = {bond::Harmonic{0.26, 2.5}, 0.0};
  body.network = solid::cubic_lattice({{2, 3, 4}, 2.5});
  body.place = {4.0, -20.0, 30.0};
  body.name = "block";
  body.start.displacement = Positions::Zero(24, 3);
  body.start.displacement.col(2).tail(6).setConstant(1.0);  // the last layer: bonds of 3.5 along z
  const std::string text = observe::lammps_data_of(scene::MovingBody(body, nullptr), 0.0);
  CHECK_THAT(text, ContainsSubstring("\n0.5 10 xlo xhi\n-23.5 -11.5 ylo yhi\n26.5 42 zlo zhi\n"));
}

TEST_CASE("What is wrong with a data file is said with its place") {
  for (const char* line :
       {"2 extra bonds", "2 bonds per atom", "extra bond per atom", "1 2 extra bond per atom"}) {
    CHECK_THAT(message_of(with("2 angles", std::string("2 angles\n") + line)), StartsWith("x.data:6:1: "));
  }
  CHECK_THAT(message_of(with("4 atoms\n", "")),
             StartsWith("x.data:13:1: the header ends without a number of atoms"));
  CHECK_THAT(message_of(with("4 atoms", "4.5 atoms")), StartsWith("x.data:3:1: '4.5' is not an integer"));
  CHECK_THAT(message_of(with("4 atoms", "5 atoms")),
             StartsWith("x.data:25:1: section 'Atoms' has 4 rows (the header announces 5 atoms)"));
  CHECK_THAT(message_of(with("3 bonds", "3 bonds\n3 bonds")),
             StartsWith("x.data:5:1: the number of bonds is given twice"));
  CHECK_THAT(message_of(with("2 angles", "2 angels")),
             StartsWith("x.data:5:1: 'angels' is no line of a header"));
  CHECK_THAT(message_of(with("2 angles", "2 angles\n1 dihedrals")),
             StartsWith("x.data:6:1: the file has dihedrals"));
  CHECK_THAT(message_of(good.substr(0, good.find("Angles"))),
             StartsWith("x.data: section 'Angles' is missing (the header announces 2 angles)"));
  CHECK_THAT(message_of(with("Bonds", "Bond")),
             StartsWith("x.data:19:1: unknown section 'Bond'") && ContainsSubstring("Did you mean 'Bonds'?"));
  CHECK_THAT(message_of(with("Masses", "Bonds")), StartsWith("x.data:14:1: section 'Bonds' has 2 rows"));
  CHECK_THAT(message_of(with("Masses\n\n1 1.0\n2 1.0", "Velocities\n\n1 1.0\n2 1.0")),
             ContainsSubstring("section 'Velocities' twice"));
  CHECK_THAT(message_of(with("Atoms # angle", "Atoms")),
             StartsWith("x.data:25:1: the atom style is not named"));
  CHECK_THAT(message_of(with("Atoms # angle", "Atoms # sphere")),
             StartsWith("x.data:25:1: atom style 'sphere' is not known"));
  CHECK_THAT(message_of(with("30 1 2 1 1 0", "30 1 2 nan 1 0")),
             StartsWith("x.data:27:8: 'nan' is not a finite number"));
  CHECK_THAT(message_of(with("30 1 2 1 1 0", "30 1 2 1 1e999 0")),
             StartsWith("x.data:27:10: '1e999' is not a finite number"));
  CHECK_THAT(message_of(with("30 1 2 1 1 0", "30 1 3 1 1 0")),
             StartsWith("x.data:27:6: an atom's type is 3"));
  CHECK_THAT(message_of(with("30 1 2 1 1 0", "30 1 2 1 1")),
             StartsWith("x.data:27:1: 5 fields (a row here is 'id molecule type x y z')"));
  CHECK_THAT(message_of(with("0 0 0 0 0 0", "0 0 0 1 0 0")),
             StartsWith("x.data:28:14: an image flag is not zero"));
  CHECK_THAT(message_of(with("40 1 1 2", "20 1 1 2")),
             StartsWith("x.data:30:1: atom 20 twice (the first stands in line 29)"));
  CHECK_THAT(message_of(with("7 1 10 20", "7 1 10 21")),
             StartsWith("x.data:21:1: bond 7 names atom 21 (none of the 4 atoms has that id)"));
  CHECK_THAT(message_of(with("7 1 10 20", "7 1 10 10")),
             StartsWith("x.data:21:5: bond 7 names atom 10 twice"));
  CHECK_THAT(message_of(with("7 1 10 20", "7 2 10 20")), StartsWith("x.data:21:3: the bond's type is 2"));
  CHECK_THAT(message_of(with("7 1 10 20", "2 1 10 20")), StartsWith("x.data:22:1: bond 2 twice"));
  CHECK_THAT(message_of(with("7 1 10 20", "7 1 10 20 30")),
             StartsWith("x.data:21:1: 5 fields (a row here is 'id type atom atom')"));
  CHECK_THAT(message_of(""), StartsWith("x.data: the header ends without a number of atoms"));
}

TEST_CASE("A data file may say more than is needed, as LAMMPS lets it") {
  const std::string more =
      with("2 angle types", "2 angle types\n2 extra bond per atom\n4 extra special per atom");
  CHECK_THAT(message_of(more), StartsWith("no error"));
  CHECK_THAT(message_of(with("30 1 2 1 1 0", "30 -1 2 +1 +1.0 0")), StartsWith("no error"));
  CHECK_THAT(message_of(with("30 1 2 1 1 0", "30 -1 2 +-1 1 0")),
             ContainsSubstring("'+-1' is not a finite number"));
  const io::LammpsData data = io::parse_lammps_data(
      with("Velocities",
           "Bond Coeffs # harmonic\n\n1 50 1.0\n\nAngle Coeffs\n\n1 harmonic 2 90\n2 cosine 1\n\nVelocities"),
      "x.data");
  REQUIRE(data.masses.size() == 2);
  CHECK(data.masses[1].mass == 1.0);
  REQUIRE(data.bond_coefficients.size() == 1);
  CHECK(data.bond_coefficients[0].style == "harmonic");
  CHECK(data.bond_coefficients[0].values == std::vector<double>{50.0, 1.0});
  REQUIRE(data.angle_coefficients.size() == 2);
  CHECK(data.angle_coefficients[0].style == "harmonic");
  CHECK(data.angle_coefficients[1].style == "cosine");
  CHECK_THAT(message_of(with("1 1.0\n2 1.0", "1 1.0\n2 -1.0")),
             StartsWith("x.data:17:3: the mass of type 2 is -1"));
}

TEST_CASE("A header that breaks off is named with the line where it does") {
  CHECK_THAT(message_of(with("\n4 atoms", "NOTE: changed\n4 atoms")),
             StartsWith("x.data:2:1: the header ends without a number of atoms"));
}

TEST_CASE("A bond across the box is refused: without a box it would be another body") {
  // The side of the square from atom 20 at x = 1 to atom 30, which a periodic box of length 6 has at x = -0.5
  // + 6.
  CHECK_THAT(message_of(with("30 1 2 1 1 0", "30 1 2 4.5 1 0")),
             StartsWith("x.data:22:1: bond 2 reaches over more than half of the box along x"));
  CHECK_THAT(message_of(with("-1 5 xlo xhi", "5 -1 xlo xhi")), StartsWith("x.data:10:1: the box ends"));
}

TEST_CASE("What cannot be a network is refused at its row") {
  CHECK_THAT(message_of(good), StartsWith("no error"));
  CHECK_THAT(message_of(with("3 1 30 40", "3 1 20 10")),
             StartsWith("x.data:21:1: bond 7 joins the same atoms as bond 3"));
  CHECK_THAT(message_of(with("1 1 10 20 30", "1 1 20 10 30")),
             StartsWith("x.data:42:1: angle 1 needs a bond between atoms 10 and 30"));
  CHECK_THAT(message_of(with("20 1 1 1 0 0", "20 1 1 0 0 0")),
             StartsWith("x.data:21:1: bond 7 has length zero"));
  CHECK_THAT(message_of(with("30 1 2 1 1 0", "30 1 2 2 0 0")),
             StartsWith("x.data:42:1: angle 1 is flat (its type rests at 90 degrees") &&
                 ContainsSubstring("Name type 1 in straight_types"));
  CHECK_THAT(message_of(with("30 1 2 1 1 0", "30 1 2 0.5 0 0")),
             StartsWith("x.data:42:1: angle 1 is folded back (its type rests at 90 degrees"));
  CHECK_THAT(message_of("t\n1 atoms\n1 atom types\nAtoms # atomic\n1 1 0 0 0\n"),
             StartsWith("x.data: the file has no bonds"));
}
