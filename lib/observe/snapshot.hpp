/// Whole bodies and pieces of the fluid at one time, for files (io/vtk, io/lammps_data).
#pragma once

#include <array>
#include <string>

#include "io/vtk.hpp"
#include "observe/field.hpp"
#include "scene/simulation.hpp"

namespace veriflex::observe {

/// The body's nodes where they are in the box, not wrapped, and its bonds as lines; without bonds each node
/// is a vertex. On nodes: `node` (number), `displacement` [L], `velocity` (now, second order) [L T^-1] and,
/// for a body that meets the fluid, `fluid_force` of the last step (its mean over the sub-steps; 0 at nodes
/// that are not coupled and before the first step) [M L T^-2]. On bonds of a body that moves by its own
/// forces: `strain` over the undeformed length [1] and `tension` dU/dr, positive where it pulls
/// [M L T^-2].
io::VtkGrid picture_of_body(const scene::MovingBody& body, double time);

/// The fluid's `density`, `velocity` and `stress` (xx, yy, zz, xy, yz, xz, as VTK orders symmetric tensors),
/// what is asked for of it, at the nodes from `from` to `to`, both included.
io::VtkImage picture_of_fluid(const fluid::Fluid& fluid, const std::array<std::int64_t, 3>& from,
                              const std::array<std::int64_t, 3>& to, const Fields& fields, double time);

/// The body as a LAMMPS data file: its nodes where they are, with mass and velocity, by the ids of the file
/// that it came from or from 1 on, its bonds and its angles. Where there are two types of angles the second
/// are those that rest at 180 degrees; the title says which.
std::string lammps_data_of(const scene::MovingBody& body, double time);

}  // namespace veriflex::observe
