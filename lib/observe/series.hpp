/// Numbers of a whole scene in time: what a row of such a record holds, and how it is found.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "observe/record.hpp"
#include "scene/simulation.hpp"

namespace veriflex::observe {

/// One measure in time, for one run. Columns are named after the bodies: `rod_kinetic`.
struct Series {
  std::vector<Column> columns;
  /// The row now, one number per column; calls follow each other in time.
  std::function<std::vector<double>(const scene::Simulation&)> row;
  /// Whether row() has an answer before the first step.
  bool from_start = true;
  /// What must see the start and every step, due or not; empty: nothing.
  std::function<void(const scene::Simulation&)> every_step{};
  /// Whether both look at bodies alone.
  bool at_bodies = false;
  /// What it keeps from one call to the next, always as many numbers from the start on: put back, a series
  /// goes on bit by bit; null: nothing.
  std::shared_ptr<std::vector<double>> memory{};
};

/// Kinetic energy of each body that moves by its own forces, with the velocity now, its potential energy,
/// elastic and of its dead load, and both together; kinetic energy of the fluid, rho u^2/2 with sum f c.
Series energies(const scene::Scene& scene);

/// Momentum of the fluid, of each body that moves by its own forces (with the velocity that leap-frog
/// carries) and of all together; where the box has walls, openings or an obstacle also the impulse that these
/// gave to the fluid since the start, which is what is left of the fluid's balance.
Series momentum(const scene::Scene& scene);

/// Force of the last step on each body: of the fluid, and of what holds or drives it, which is what is left
/// of the body's balance; that of the fluid on its obstacle; and where there are several of these, that of
/// the fluid on all of them.
Series forces(const scene::Scene& scene);

/// Each body that moves by its own forces as a rigid one: its centre of mass and that one's velocity, its
/// angular velocity, angular momentum by tensor of inertia, and how far it has turned since the start, the
/// sum of that; velocities are those that leap-frog carries, half a step old. Of bodies that have nodes in a
/// line alone the turning about that line is none.
Series rigid_motion(const scene::Scene& scene);

/// Principal stretches of each such body and its Taylor deformation (max - min)/(max + min), by the affine
/// map that fits the places of its nodes best. Bodies whose nodes lie in a plane have none.
Series deformation(const scene::Scene& scene);

/// Displacement of the last section of each such body, the nodes at the far end of its own axis: their mean.
Series tips(const scene::Scene& scene);

/// Smallest and largest strain of any bond of each body, over every step since the row before.
Series strains(const scene::Scene& scene);

/// Slip u_f - u_s that the last step found at each body's coupled nodes: root mean square and largest.
Series slip(const scene::Scene& scene);

}  // namespace veriflex::observe
