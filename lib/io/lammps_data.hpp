/// Data files of LAMMPS: atoms, bonds and angles as plain arrays.
///
/// Read are the header, `Atoms` of the styles atomic, bond, angle, molecular and full (named behind the
/// section's keyword, `Atoms # angle`, as LAMMPS writes it), `Bonds` and `Angles`, in any order and with ids
/// in any order, `Masses`, and `Bond Coeffs` and `Angle Coeffs` with their styles, so that they can be held
/// against the case, where parameters belong. Other sections are passed over. Refused is what would make
/// another body of it: dihedrals and impropers, image flags, because there is no periodic box, and a bond
/// that only such a box would make short.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace veriflex::io {

struct LammpsAtom {
  std::int64_t id;
  int type;
  std::array<double, 3> position;  // [L]
};

/// `line` is where the row stands, for messages.
struct LammpsBond {
  std::int64_t id;
  int type;
  std::array<std::int64_t, 2> atoms;  // ids
  unsigned line;
};

struct LammpsAngle {
  std::int64_t id;
  int type;
  std::array<std::int64_t, 3> atoms;  // ids, the apex in the middle
  unsigned line;
};

/// The mass of the atoms of a type  [M].
struct LammpsMass {
  int type;
  double mass;
  unsigned line;
};

/// The coefficients of a type of bonds or angles, as they stand there. The style is the row's own (hybrid
/// ones) or named behind the section's keyword; empty where neither is.
struct LammpsCoefficients {
  int type;
  std::string style;
  std::vector<double> values;
  unsigned line;
};

struct LammpsData {
  std::string file;
  std::vector<LammpsAtom> atoms;    // in rising order of ids, like the other two
  std::vector<LammpsBond> bonds;    // between two different atoms that exist
  std::vector<LammpsAngle> angles;  // of three different atoms that exist
  std::vector<LammpsMass> masses;   // in the file's order, like the coefficients
  std::vector<LammpsCoefficients> bond_coefficients, angle_coefficients;
  int bond_types, angle_types;  // as the header announces; 0 where it does not
};

/// The data file in `text`; `file` is only for messages. Throws InputError: a section that is missing,
/// unknown or there twice, a number of rows that differs from the header's, a row with too few or too many
/// fields, anything that is not a finite number, ids that repeat or do not exist, types out of range, a bond
/// that reaches over more than half of the box.
LammpsData parse_lammps_data(std::string_view text, const std::string& file);

/// As above, of the file at `path`.
LammpsData read_lammps_data(const std::filesystem::path& path);

/// A data file of style angle in a box with room for one more bond around its atoms: what LAMMPS and the
/// reader above read, each number with the digits that tell it from its neighbours. `velocities` has one row
/// for each atom [L T^-1]. Coefficients are not written.
std::string write_lammps_data(const LammpsData& data, const std::vector<std::array<double, 3>>& velocities,
                              const std::string& title);

}  // namespace veriflex::io
