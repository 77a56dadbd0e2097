#include "solid/implicit_midpoint.hpp"

#include <fmt/format.h>

#include "base/error.hpp"
#include "base/mutant.hpp"
#include "base/stop.hpp"
#include "solid/relax.hpp"

namespace veriflex::solid {

ImplicitMidpoint::ImplicitMidpoint(const Material& material, const Network& network, Conditions conditions,
                                   double dt, Positions u, Positions v)
    : Integrator(material, network, std::move(conditions), dt, std::move(u), std::move(v)),
      prescribed_(prescribed_dofs(conditions_, u_.rows())) {
  v_ = prescribed_.select(0.0, v_);
  if (!evaluate(u_)) fail("start", u_);
  tell_parts();
  part_ = parts::Built(parts::Kind::Midpoint, parts::array_bytes(u_, v_, prescribed_, work_.d));
}

bool ImplicitMidpoint::evaluate(const Positions& u) {
  return std::visit([&](const auto& law) { return deform(law, network_, u, work_); }, material_.law);
}

Inertia ImplicitMidpoint::inertia() const {
  const double mass =
      (planted(Mutant::midpoint_inertia_halved) ? 2.0 : 4.0) * conditions_.node_mass / (dt_ * dt_);
  const double drag = 2.0 * conditions_.drag / dt_;
  return {Eigen::VectorXd::Constant(u_.rows(), mass + drag), u_ + 0.5 * dt_ * mass / (mass + drag) * v_};
}

Positions ImplicitMidpoint::load() const {
  return conditions_.load.size() > 0 ? conditions_.load : Positions(Positions::Zero(u_.rows(), 3));
}

void ImplicitMidpoint::step() { advance(load(), inertia()); }

void ImplicitMidpoint::step(const VelocityCoupling& coupling, Positions& mean) {
  const auto count = static_cast<Eigen::Index>(coupling.nodes.size());
  const auto node = [&](Eigen::Index k) { return coupling.nodes[static_cast<std::size_t>(k)]; };
  Positions load = this->load();
  Inertia inertia = this->inertia();
  Positions before(count, 3);
  for (Eigen::Index k = 0; k < count; ++k) before.row(k) = u_.row(node(k));
  if (coupling.subcycled) {
    // strength (target - (u' - u)/dt) is a spring of the middle to where the target takes it.
    const double spring = 2.0 * coupling.strength / dt_;
    for (Eigen::Index k = 0; k < count; ++k) {
      double& stiffness = inertia.stiffness[node(k)];
      auto predicted = inertia.predicted.row(node(k));
      predicted = (stiffness * predicted + spring * (before.row(k) + 0.5 * dt_ * coupling.target.row(k))) /
                  (stiffness + spring);
      stiffness += spring;
    }
    advance(load, inertia);
    mean.resize(count, 3);
    for (Eigen::Index k = 0; k < count; ++k) {
      mean.row(k) = coupling.strength * (coupling.target.row(k) - (u_.row(node(k)) - before.row(k)) / dt_);
    }
    return;
  }
  mean.resize(count, 3);
  for (Eigen::Index k = 0; k < count; ++k) {
    mean.row(k) = coupling.strength * (coupling.target.row(k) - v_.row(node(k)));
    load.row(node(k)) += mean.row(k);
  }
  advance(load, inertia);
}

void ImplicitMidpoint::advance(const Positions& load, const Inertia& inertia) {
  stop_if_asked("step", steps_ + 1);
  const std::string when = fmt::format("step {}", steps_ + 1);
  Positions start = u_;
  if (const auto& drive = conditions_.drive) {
    for (const std::int32_t node : drive->nodes)
      start(node, drive->axis) = 0.5 * (u_(node, drive->axis) + drive->at(time() + dt_));
  }
  Equilibrium middle;
  try {
    middle = newton_with(kept_, material_, network_, start, prescribed_, load, inertia, Statics{}.residual);
  } catch (const NumericalFailure& failure) {
    throw failure.at(when);
  }
  const Positions next = 2.0 * middle.u - u_;
  if (!evaluate(next)) {
    static_cast<void>(evaluate(u_));  // what the energy is asked of
    fail(when, next);
  }
  const Positions mean_velocity = (next - u_) / dt_;
  v_ = prescribed_.select(mean_velocity, 2.0 * mean_velocity - v_);
  u_ = next;
  newton_steps_ += middle.iterations;
  ++steps_;
  part_.takes(parts::array_bytes(u_, v_, prescribed_, work_.d, kept_.at) + bytes_of(kept_.factor));
}

void ImplicitMidpoint::restore(const State& state) {
  u_ = state.displacement;
  v_ = state.velocity;
  steps_ = state.steps;
  const bool is_same = kept_.at.rows() == state.linearised_at.rows() && kept_.at == state.linearised_at;
  kept_.at = state.linearised_at;
  kept_.is_made = kept_.is_made && is_same;
  if (!evaluate(u_)) fail(fmt::format("step {}", steps_), u_);
}

}  // namespace veriflex::solid
