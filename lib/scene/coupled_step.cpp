#include "scene/coupled_step.hpp"

#include <algorithm>

#include "coupling/transfer.hpp"
#include "scene/markers.hpp"
#include "solid/dof_map.hpp"
#include "solid/modes.hpp"

namespace veriflex::scene {

namespace {

/// A: what a unit force at one marker gives to all, three markers at a time.
Eigen::SparseMatrix<double> exchange_of(const coupling::Transfer& transfer, Eigen::Index markers) {
  std::vector<Eigen::Triplet<double>> entries;
  Positions spread, back;
  for (Eigen::Index first = 0; first < markers; first += 3) {
    const Eigen::Index count = std::min<Eigen::Index>(3, markers - first);
    Positions unit = Positions::Zero(markers, 3);
    for (Eigen::Index i = 0; i < count; ++i) unit(first + i, i) = 1.0;
    transfer.spread(unit, spread);
    transfer.interpolate(spread, back);
    for (Eigen::Index i = 0; i < count; ++i) {
      for (Eigen::Index m = 0; m < markers; ++m) {
        if (back(m, i) != 0.0) entries.emplace_back(m, first + i, back(m, i));
      }
    }
  }
  Eigen::SparseMatrix<double> exchange(markers, markers);
  exchange.setFromTriplets(entries.begin(), entries.end());
  return exchange;
}

}  // namespace

solid::FixedDofs prescribed_dofs(const Body& body) {
  solid::FixedDofs held = body.conditions.fixed;
  if (held.size() == 0) held = solid::FixedDofs::Constant(body.network.node_count(), 3, false);
  if (const auto& drive = body.conditions.drive) {
    for (const std::int32_t node : drive->nodes) held(node, drive->axis) = true;
  }
  return held;
}

CoupledStep::CoupledStep(const fluid::Spec& fluid, const Body& body, FluidMemory memory)
    : coupling_(*body.coupling),
      memory_(memory),
      node_mass_(body.conditions.node_mass),
      drag_(body.conditions.drag) {
  const Positions rest = Positions::Zero(body.network.node_count(), 3);
  const solid::FixedDofs held = prescribed_dofs(body);
  stiffness_ = solid::free_hessian(body.material, body.network, rest, held);
  substeps_ = body.substeps.count;
  if (body.substeps.safety > 0.0) {
    substeps_ = solid::Leapfrog(body.material, body.network, body.conditions, 1.0, body.substeps, rest, rest)
                    .substeps();
  }

  const std::vector<std::int32_t> nodes = coupled_nodes(body);
  coupling::Transfer transfer(fluid.grid, closed(fluid), coupling_.delta, fluid.obstacle);
  transfer.locate(markers_at_rest(body));
  exchange_ = exchange_of(transfer, static_cast<Eigen::Index>(nodes.size()));
  const solid::DofMap dofs(held);
  for (int axis = 0; axis < 3; ++axis) {
    for (const std::int32_t node : nodes) {
      place_.push_back(dofs.number[axis * body.network.node_count() + node]);
    }
  }
}

CoupledStep::Vector CoupledStep::at_markers(const Vector& free) const {
  Vector values(marker_values());
  for (Eigen::Index m = 0; m < values.size(); ++m) {
    const int place = place_[static_cast<std::size_t>(m)];
    values[m] = place < 0 ? 0.0 : free[place];
  }
  return values;
}

CoupledStep::Vector CoupledStep::at_coordinates(const Vector& markers) const {
  Vector free = Vector::Zero(free_count());
  for (Eigen::Index m = 0; m < markers.size(); ++m) {
    const int place = place_[static_cast<std::size_t>(m)];
    if (place >= 0) free[place] += markers[m];
  }
  return free;
}

CoupledStep::Vector CoupledStep::exchanged(const Vector& force) const {
  const Eigen::Index markers = exchange_.rows();
  Vector given(force.size());
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    given.segment(axis * markers, markers) = exchange_ * force.segment(axis * markers, markers);
  }
  return given;
}

bool CoupledStep::couples_free_coordinates() const {
  return std::any_of(place_.begin(), place_.end(), [](int place) { return place >= 0; });
}

CoupledStep::Vector CoupledStep::next(const Vector& state) const {
  const double step = 1.0 / substeps_;
  const double half_drag = 0.5 * drag_ * step / node_mass_;
  const double kick = step / node_mass_ / (1.0 + half_drag);
  const double V = coupling_.marker_volume;
  Vector f = state.head(free_count());
  Vector v = state.segment(free_count(), free_count());
  Vector W = state.tail(marker_values());

  Vector wanted = W;
  Vector missing = W - at_markers(v);
  for (int round = 1; round < coupling_.forcing_iterations; ++round) {  // coupling::add_further_rounds
    missing -= V * exchanged(missing);
    wanted += missing;
  }
  Vector force = V * (wanted - at_markers(v));
  Vector mean = Vector::Zero(marker_values());
  for (int i = 0; i < substeps_; ++i) {
    v *= (1.0 - half_drag) / (1.0 + half_drag);
    if (coupling_.subcycled && i > 0) force = V * (wanted - at_markers(v));
    mean += force / substeps_;
    v += kick * (f + at_coordinates(force));
    f -= step * (stiffness_ * v);
  }
  if (memory_ == FluidMemory::Keeps) {
    W -= exchanged(mean);
  } else {
    W.setZero();
  }
  Vector after(size());
  after << f, v, W;
  return after;
}

}  // namespace veriflex::scene
