#include "scene/prescribed_body.hpp"

#include "base/work.hpp"

namespace veriflex::scene {

PrescribedBody::PrescribedBody(const fluid::Spec& fluid, const Forcing& forcing)
    : forcing_(forcing), transfer_(fluid.grid, closed(fluid), forcing.delta, fluid.obstacle) {}

void PrescribedBody::place(const Positions& X) { transfer_.locate(X); }

void PrescribedBody::exchange(const fluid::Fluid& fluid, const Vec3& velocity) {
  fluid.velocities(transfer_.nodes(), at_nodes_);
  transfer_.interpolate(at_nodes_, slip_);
  work::add_markers(static_cast<std::uint64_t>(slip_.rows() * forcing_.forcing_iterations));
  slip_.rowwise() -= velocity.transpose();
  force_ = slip_;
  coupling::add_further_rounds(transfer_, slip_, forcing_.marker_volume, forcing_.forcing_iterations, force_);
  force_ *= forcing_.marker_volume;
  exchange_.takes(parts::array_bytes(at_nodes_, slip_, force_, spread_));
}

void PrescribedBody::advance(fluid::Fluid& fluid, const Vec3& velocity) {
  exchange(fluid, velocity);
  transfer_.spread(-force_, spread_);
  fluid.collide_and_stream({transfer_.nodes(), &spread_});
}

Positions PrescribedBody::slip_of_fluid() const {
  Positions given;
  transfer_.interpolate(spread_, given);
  return slip_ + 0.5 * given;
}

}  // namespace veriflex::scene
