#include "solid/leapfrog.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/mutant.hpp"
#include "base/reduce.hpp"
#include "base/stop.hpp"
#include "solid/inadmissible.hpp"
#include "solid/modes.hpp"

namespace veriflex::solid {

namespace {
constexpr double max_substeps = 1e6;
// Of a bond's distance from a limit of its law that it may move in a sub-step. With a half a pair that is
// thrown against its limit gains energy at each rebound until nothing holds it.
constexpr double refused_share = 0.1;
}  // namespace

Leapfrog::Leapfrog(const Material& material, const Network& network, Conditions conditions, double dt,
                   Substeps substeps, Positions u, Positions v)
    : Integrator(material, network, std::move(conditions), dt, std::move(u), std::move(v)),
      wanted_(substeps) {
  if (!evaluate(u_)) fail("start", u_);
  divide();
  // Back to half a sub-step before the start, so that velocity() is v.
  last_substep_ = dt_ / count_;
  const double half_drag = 0.5 * conditions_.drag * last_substep_ / conditions_.node_mass;
  const double half_kick =
      (planted(Mutant::start_not_shifted) ? 0.0 : 0.5) * last_substep_ / conditions_.node_mass;
  if (conditions_.load.size() > 0) {
    v_ = v_ * (1.0 + half_drag) - half_kick * (conditions_.load - gradient_);
  } else {
    v_ = v_ * (1.0 + half_drag) + half_kick * gradient_;
  }
  if (conditions_.fixed.size() > 0) v_ = conditions_.fixed.select(0.0, v_);
  next_.resizeLike(u_);
  if (wanted_.most > 0) {
    bonds_before_.resizeLike(work_.d);
    u_before_.resizeLike(u_);
    v_before_.resizeLike(u_);
  }
  tell_parts();
  parts_.emplace_back(parts::Kind::LeapFrog, parts::array_bytes(u_, v_, gradient_, next_, work_.d, work_.g,
                                                                bonds_before_, u_before_, v_before_));
}

// As many sub-steps as asked for, or as the present network needs.
void Leapfrog::divide() {
  if (!(wanted_.safety > 0.0)) {
    count_ = wanted_.count;
    return;
  }
  stiffest_ = 0.0;
  for (Eigen::Index b = 0; b < work_.d.rows(); ++b) {
    stiffest_ = worse(stiffest_, bond::stiffness(material_.law, work_.d.row(b).norm()));
  }
  const FixedDofs held =
      conditions_.fixed.size() > 0 ? conditions_.fixed : FixedDofs::Constant(u_.rows(), 3, false);
  const double omega = largest_frequency(material_, network_, u_, held, conditions_.node_mass);
  const double wanted = std::ceil(dt_ * omega / (2.0 * wanted_.safety));
  if (!(wanted <= max_substeps)) {
    throw NumericalFailure(
        fmt::format("step {}: the body is so stiff that a step needs {} sub-steps, more than {}", steps_ + 1,
                    wanted, max_substeps),
        FailureMode::TimeStep);
  }
  count_ = std::max(1, static_cast<int>(wanted));
}

bool Leapfrog::evaluate(const Positions& u) {
  return visit(material_, [&](const auto& law, const auto& angle) {
    return deform(law, network_, u, work_) && gradient(law, angle, network_, work_, gradient_);
  });
}

// Velocities that take the fixed and driven coordinates where they have to be at `time`, a sub-step from now.
void Leapfrog::prescribe(double time, double substep) {
  if (conditions_.fixed.size() > 0) v_ = conditions_.fixed.select(0.0, v_);
  if (const auto& drive = conditions_.drive) {
    for (const std::int32_t node : drive->nodes) {
      v_(node, drive->axis) =
          (drive->at(planted(Mutant::drive_a_substep_late) ? time - substep : time) - u_(node, drive->axis)) /
          substep;
    }
  }
}

/// Whether a bond moved by more than a tenth of its distance from a limit of its law in this sub-step, so
/// that it might have gone beyond, or through its neighbour.
bool Leapfrog::moved_too_far() const {
  const Interval domain = bond::domain(material_.law);
  for (Eigen::Index b = 0; b < work_.d.rows(); ++b) {
    const double length = bonds_before_.row(b).norm();
    const double room = std::min(length - domain.lo, domain.hi - length);
    if (!((work_.d.row(b) - bonds_before_.row(b)).norm() <= refused_share * room)) return true;
  }
  return false;
}

/// u_ is the displacement at their end, or at that of the last good one.
template <class Extra>
Leapfrog::Substepped Leapfrog::make_substeps(int count, Extra extra_kick) {
  const double h = (planted(Mutant::substep_short) ? 0.99 : 1.0) * dt_ / count;
  for (int i = 1; i <= count; ++i) {
    // From the middle of the sub-step before to the middle of this one.
    const double kick =
        (planted(Mutant::node_mass_halved) ? 1.0 : 0.5) * (last_substep_ + h) / conditions_.node_mass;
    const double half_drag = (planted(Mutant::drag_doubled) ? 1.0 : 0.5) * conditions_.drag * kick;
    if (half_drag > 0.0) v_ *= (1.0 - half_drag) / (1.0 + half_drag);
    extra_kick(i, kick / (1.0 + half_drag));
    v_ -= kick / (1.0 + half_drag) * gradient_;
    if (conditions_.load.size() > 0) v_ += kick / (1.0 + half_drag) * conditions_.load;
    prescribe(time() + i * h, h);
    next_ = u_ + h * v_;
    if (wanted_.most > 0) bonds_before_ = work_.d;
    if (!evaluate(next_)) return Substepped::Outside;
    if (wanted_.most > 0 && !planted(Mutant::refused_steps_kept) && moved_too_far())
      return Substepped::TooFar;
    std::swap(u_, next_);
    last_substep_ = h;
  }
  return Substepped::Well;
}

/// In how many sub-steps.
template <class Extra>
int Leapfrog::advance(Extra extra_kick) {
  stop_if_asked("step", steps_ + 1);
  if (wanted_.safety > 0.0) {
    double stiffest = 0.0;
    for (Eigen::Index b = 0; b < work_.d.rows(); ++b) {
      stiffest = worse(stiffest, bond::stiffness(material_.law, work_.d.row(b).norm()));
    }
    if (stiffest > 1.1 * stiffest_ || stiffest < 0.5 * stiffest_) divide();
  }
  const bool may_refuse = wanted_.most > 0;
  if (may_refuse) {
    u_before_ = u_;
    v_before_ = v_;
  }
  const double substep_before = last_substep_;
  int count = count_;
  for (Substepped how; (how = make_substeps(count, extra_kick)) != Substepped::Well; count *= 2) {
    if (!may_refuse) fail(fmt::format("step {}", steps_ + 1), next_);
    u_ = u_before_;
    v_ = v_before_;
    last_substep_ = substep_before;
    evaluate(u_);
    if (count > wanted_.most / 2) {
      throw NumericalFailure(
          fmt::format("step {}: refused in {} sub-steps, and no more than {} are allowed: {}", steps_ + 1,
                      count, wanted_.most,
                      how == Substepped::TooFar
                          ? "a bond moves by more than a tenth of its distance from a limit of its law"
                          : what_is_inadmissible(material_, network_, next_)),
          FailureMode::Bond);
    }
  }
  ++steps_;
  return count;
}

void Leapfrog::restore(const State& state) {
  u_ = state.displacement;
  v_ = state.velocity;
  steps_ = state.steps;
  count_ = state.substeps;
  stiffest_ = state.stiffest;
  last_substep_ = state.substep;
  if (!evaluate(u_)) fail(fmt::format("step {}", steps_), u_);
}

void Leapfrog::step() {
  advance([](int, double) {});
}

void Leapfrog::step(const VelocityCoupling& coupling, Positions& mean) {
  const auto count = static_cast<Eigen::Index>(coupling.nodes.size());
  const auto evaluate_coupling = [&](Positions& force) {
    for (int axis = 0; axis < 3; ++axis) {
      for (Eigen::Index i = 0; i < count; ++i) {
        const std::int32_t node = coupling.nodes[static_cast<std::size_t>(i)];
        const double v =
            v_(node, axis) - (planted(Mutant::coupling_velocity_on_step)
                                  ? 0.5 * last_substep_ / conditions_.node_mass * gradient_(node, axis)
                                  : 0.0);
        force(i, axis) = coupling.strength * (coupling.target(i, axis) - v);
      }
    }
  };
  Positions force(count, 3);
  const int substeps = advance([&](int i, double kick) {
    if (i == 1 || planted(Mutant::force_of_last_substep)) mean.setZero(count, 3);
    if (i == 1 || coupling.subcycled || planted(Mutant::frozen_force_follows)) evaluate_coupling(force);
    mean += force;
    for (int axis = 0; axis < 3; ++axis) {
      for (Eigen::Index k = 0; k < count; ++k)
        v_(coupling.nodes[static_cast<std::size_t>(k)], axis) += kick * force(k, axis);
    }
  });
  mean /= planted(Mutant::force_not_averaged) ? 1 : substeps;
}

Positions Leapfrog::velocity() const {
  const double kick = 0.5 * last_substep_ / conditions_.node_mass;
  Positions v = v_ - kick * gradient_;
  if (conditions_.load.size() > 0 && !planted(Mutant::velocity_without_load)) v += kick * conditions_.load;
  if (conditions_.drag > 0.0) v /= 1.0 + kick * conditions_.drag;
  if (conditions_.fixed.size() > 0) v = conditions_.fixed.select(0.0, v);
  return v;
}

void Leapfrog::reverse() {
  // v(t - dt/2) becomes -v(t + dt/2).
  v_ = v_ - 2.0 * (v_ - velocity());
  v_ = -v_;
}

}  // namespace veriflex::solid
