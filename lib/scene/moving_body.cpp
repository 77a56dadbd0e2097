#include "scene/moving_body.hpp"

#include <cassert>

#include <fmt/format.h>

#include "base/error.hpp"
#include "base/mutant.hpp"
#include "base/work.hpp"
#include "scene/markers.hpp"
#include "solid/implicit_midpoint.hpp"

namespace veriflex::scene {

MovingBody::MovingBody(Body body, const fluid::Spec* fluid)
    : body_(std::move(body)),
      coupled_(fluid == nullptr ? std::vector<std::int32_t>{} : coupled_nodes(body_)) {
  const bool meets_fluid = fluid != nullptr && body_.coupling;
  if (body_.motion && !meets_fluid) {
    throw BadParameter("motion", fmt::format("the motion of {} is given, and it meets no fluid", body_.name),
                       "nothing would come of it",
                       "Give it a coupling and the scene a fluid, or leave it out");
  }
  if (meets_fluid) {
    markers_.resize(static_cast<Eigen::Index>(coupled_.size()), 3);
    exchange_.emplace(parts::Kind::Coupling, 0.0);
    const CouplingSpec& coupling = *body_.coupling;
    if (body_.motion) {
      prescribed_.emplace(*fluid,
                          Forcing{coupling.delta, coupling.marker_volume, coupling.forcing_iterations});
    } else {
      transfer_.emplace(fluid->grid, closed(*fluid), coupling.delta, fluid->obstacle);
      slip_.resize(markers_.rows(), 3);
    }
  }
  if (!body_.motion) {
    const auto or_none = [&](Positions& given) {
      return given.size() > 0 ? std::move(given) : Positions(Positions::Zero(body_.network.node_count(), 3));
    };
    Positions u = or_none(body_.start.displacement), v = or_none(body_.start.velocity);
    if (body_.scheme == solid::Scheme::ImplicitMidpoint) {
      motion_ = std::make_unique<solid::ImplicitMidpoint>(
          body_.material, body_.network, std::move(body_.conditions), 1.0, std::move(u), std::move(v));
    } else {
      motion_ = std::make_unique<solid::Leapfrog>(body_.material, body_.network, std::move(body_.conditions),
                                                  1.0, body_.substeps, std::move(u), std::move(v));
    }
  }
}

void MovingBody::put_markers() {
  const Vec3 shift =
      motion_ ? Vec3(Vec3::Zero()) : body_.motion->displacement_at(static_cast<double>(steps_));
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < coupled_.size(); ++i) {
      const double moved =
          motion_ ? (planted(Mutant::markers_stay_behind) ? 0.0 : motion_->displacement()(coupled_[i], axis))
                  : shift[axis];
      markers_(static_cast<Eigen::Index>(i), axis) =
          body_.place[axis] + body_.network.rest(coupled_[i], axis) + moved;
    }
  }
}

void MovingBody::locate() {
  if (!(planted(Mutant::supports_kept_too_long) && steps_ % 2 == 1)) put_markers();
  try {
    if (prescribed_) {
      prescribed_->place(markers_);
    } else {
      transfer_->locate(markers_);
    }
  } catch (const NumericalFailure& failure) {
    throw failure.at(fmt::format("step {}", steps_ + 1));
  }
}

void MovingBody::interpolate(const fluid::Fluid& fluid) {
  if (prescribed_) {
    prescribed_->exchange(
        fluid, body_.motion->velocity_at(static_cast<double>(steps_) +
                                         (planted(Mutant::prescribed_velocity_ahead) ? 0.5 : 0.0)));
    return;
  }
  fluid.velocities(transfer_->nodes(), at_nodes_);
  transfer_->interpolate(at_nodes_, wanted_);
  work::add_markers(coupled_.size() * static_cast<std::uint64_t>(body_.coupling->forcing_iterations));
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < coupled_.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      slip_(row, axis) = wanted_(row, axis) - motion_->carried_velocity()(coupled_[i], axis);
    }
  }
  coupling::add_further_rounds(*transfer_, slip_, body_.coupling->marker_volume,
                               body_.coupling->forcing_iterations, wanted_);
}

void MovingBody::move() {
  if (prescribed_) {
    exchanged_ = prescribed_->force();
  } else if (transfer_) {
    motion_->step({coupled_, wanted_,
                   (planted(Mutant::exchange_reversed) ? -1.0 : 1.0) *
                       (planted(Mutant::marker_volume_ignored) ? 1.0 : body_.coupling->marker_volume),
                   body_.coupling->subcycled},
                  exchanged_);
  } else {
    motion_->step();
  }
  ++steps_;
}

void MovingBody::spread() {
  transfer().spread((planted(Mutant::reaction_missing)   ? 0.0
                     : planted(Mutant::reaction_doubled) ? -2.0
                                                         : -1.0) *
                        exchanged_,
                    spread_);
  exchange_->takes(parts::array_bytes(markers_, at_nodes_, wanted_, slip_, exchanged_, spread_));
}

Positions MovingBody::displacement() const {
  if (motion_) return motion_->displacement();
  const Vec3 moved = body_.motion->displacement_at(static_cast<double>(steps_));
  return moved.transpose().replicate(body_.network.node_count(), 1);
}

Positions MovingBody::positions() const {
  return (body_.network.rest + displacement()).rowwise() + body_.place.transpose();
}

Positions MovingBody::markers() const {
  const Positions all = positions();
  Positions X(static_cast<Eigen::Index>(coupled_.size()), 3);
  for (Eigen::Index m = 0; m < X.rows(); ++m) X.row(m) = all.row(coupled_[static_cast<std::size_t>(m)]);
  return X;
}

Vec3 MovingBody::momentum() const { return motion_ ? motion_->momentum() : Vec3(Vec3::Zero()); }

MovingBody::State MovingBody::state() const {
  return {steps_, motion_ ? std::optional(motion_->state()) : std::nullopt};
}

void MovingBody::restore(const State& state) {
  assert(!motion_ || (state.elastic && state.elastic->displacement.rows() == positions().rows()));
  steps_ = state.steps;
  if (motion_) motion_->restore(*state.elastic);
}

}  // namespace veriflex::scene
