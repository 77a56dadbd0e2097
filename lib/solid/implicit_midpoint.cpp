#include "solid/implicit_midpoint.hpp"

#include <fmt/format.h>

#include "base/error.hpp"
#include "base/stop.hpp"
#include "solid/inadmissible.hpp"

namespace veriflex::solid {

ImplicitMidpoint::ImplicitMidpoint(const Material& material, const Network& network, double node_mass,
                                   const FixedDofs& fixed, const Positions& load, double dt,
                                   const Positions& u, const Positions& v)
    : material_(material),
      network_(network),
      mass_(node_mass),
      dt_(dt),
      fixed_(fixed.size() > 0 ? fixed : FixedDofs::Constant(u.rows(), 3, false)),
      load_(load.size() > 0 ? load : Positions::Zero(u.rows(), 3)),
      u_(u),
      v_(fixed_.select(0.0, v)),
      part_(parts::Kind::Midpoint, parts::array_bytes(u_, v_, load_, fixed_)) {}

void ImplicitMidpoint::step() {
  stop_if_asked("step", steps_ + 1);
  const std::string when = fmt::format("step {}", steps_ + 1);
  Equilibrium middle;
  try {
    middle = equilibrium(material_, network_, u_, fixed_, load_,
                         {.stiffness = 4.0 * mass_ / (dt_ * dt_), .predicted = u_ + 0.5 * dt_ * v_});
  } catch (const NumericalFailure& failure) {
    throw failure.at(when);
  }
  const Positions next = 2.0 * middle.u - u_;
  Workspace work;
  const bool inside =
      std::visit([&](const auto& law) { return deform(law, network_, next, work); }, material_.law);
  if (!inside) {
    throw NumericalFailure(fmt::format("{}: {}", when, what_is_inadmissible(material_, network_, next)),
                           FailureMode::Bond);
  }
  v_ = 2.0 / dt_ * (next - u_) - v_;
  u_ = next;
  newton_steps_ += middle.iterations;
  ++steps_;
}

}  // namespace veriflex::solid
