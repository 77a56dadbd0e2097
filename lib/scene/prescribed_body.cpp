#include "scene/prescribed_body.hpp"

namespace veriflex::scene {

PrescribedBody::PrescribedBody(const fluid::Spec& fluid, const Forcing& forcing)
    : forcing_(forcing),
      transfer_(fluid.grid,
                {fluid.walls[0].has_value(), fluid.walls[1].has_value(), fluid.walls[2].has_value()},
                forcing.delta) {}

void PrescribedBody::place(const Positions& X) { transfer_.locate(X); }

void PrescribedBody::advance(fluid::Fluid& fluid, const Vec3& velocity) {
  fluid.velocities(transfer_.nodes(), at_nodes_);
  transfer_.interpolate(at_nodes_, slip_);
  slip_.rowwise() -= velocity.transpose();
  force_ = forcing_.marker_volume * slip_;
  Positions left = slip_, given;
  for (int round = 1; round < forcing_.iterations; ++round) {
    transfer_.spread(forcing_.marker_volume * left, spread_);
    transfer_.interpolate(spread_, given);
    left -= given;
    force_ += forcing_.marker_volume * left;
  }
  transfer_.spread(-force_, spread_);
  fluid.collide_and_stream({transfer_.nodes(), &spread_});
}

Positions PrescribedBody::slip_of_fluid() const {
  Positions given;
  transfer_.interpolate(spread_, given);
  return slip_ + 0.5 * given;
}

}  // namespace veriflex::scene
