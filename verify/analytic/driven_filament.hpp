/// Thrust of an elastic filament that is driven at one end, without inertia and of small amplitude.
///                                                                        [wiggins-goldstein-1998]
///   xi_perp w_t = - B w'''',  F = - (xi_perp - xi_par) int <w_t w'> ds,  l^4 = B/(xi_perp omega),  Sp = L/l
///
/// Slender body, drag per length xi_perp across and xi_par along it; its free end bears neither force nor
/// moment. F pushes towards the driven end, at s = 0. It holds to order 1/ln(L/a). A chain of markers in a
/// periodic box needs no such thing: what a force on one moves the others by is known exactly.
#pragma once

#include <array>

#include "analytic/line_mobility.hpp"
#include "base/named.hpp"

namespace veriflex::analytic {

enum class FilamentDrive { Hinged, Clamped, Angle };
inline constexpr std::array filament_drives{
    Named<FilamentDrive>{FilamentDrive::Hinged, "hinged", "hinged", "displacement y0, free to turn"},
    Named<FilamentDrive>{FilamentDrive::Clamped, "clamped", "clamped", "displacement y0, without turning"},
    Named<FilamentDrive>{FilamentDrive::Angle, "angle", "angle", "angle theta0 about the end"},
};

/// F/((xi_perp - xi_par) omega a^2) of an endless filament that is driven with the amplitude a: y0, or theta0
/// [1 or L^2].
double endless_thrust(FilamentDrive drive, double bending_length);

/// Y: F over that of an endless filament. It tends to 1 for large Sp.
double slender_thrust(FilamentDrive drive, double sperm_number);

/// Drag per length over viscosity of a slender rod, across and along: 4 pi/(ln(L/a) + 1/2) and
/// 2 pi/(ln(L/a) - 1/2).
struct RodDrag {
  double across, along;
};
RodDrag slender_drags(double radius_over_length);

/// The same of markers a spacing apart on a line that is towed, by what a marker, slip and all, moves the
/// others: force per velocity and marker  [M L^-1 T^-1].
RodDrag towed_drags(const Mobility& mobility);

/// Markers a spacing apart, with bonds that keep their length, and angles. The first is driven across the
/// line, and the second with it (Clamped) or in its place (Angle).
struct DrivenChain {
  FilamentDrive drive;
  Mobility steady;  // what a marker needs for itself, such as slip, added at distance 0
  OscillatingMobility mobility;
  double omega;            // [T^-1]
  double angle_stiffness;  // k_a  [M L^2 T^-2]
  double node_mass;        // [M]
};

/// The markers that are driven, all of them alike; the first one stays on the axis if it is not among them.
std::vector<std::int32_t> driven_markers(FilamentDrive drive);

struct ChainStroke {
  Eigen::VectorXcd shape;  // displacements, Re[shape exp(i omega t)], over that of what is driven
  double thrust;           // mean force over the square of the driven displacement  [M L^-1 T^-2]
};
ChainStroke stroke_of(const DrivenChain& chain);

}  // namespace veriflex::analytic
