#include "solid/integrator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/mutant.hpp"
#include "solid/inadmissible.hpp"

namespace veriflex::solid {

double Drive::at(double time) const {
  const double risen = ramp > 0.0 && !planted(Mutant::drive_ramp_ignored) ? std::min(1.0, time / ramp) : 1.0;
  return risen * amplitude * std::sin(omega * time);
}

FixedDofs prescribed_dofs(const Conditions& conditions, Eigen::Index nodes) {
  FixedDofs prescribed = conditions.fixed;
  if (prescribed.size() == 0) prescribed = FixedDofs::Constant(nodes, 3, false);
  if (const auto& drive = conditions.drive) {
    for (const std::int32_t node : drive->nodes) prescribed(node, drive->axis) = true;
  }
  return prescribed;
}

Integrator::Integrator(const Material& material, const Network& network, Conditions conditions, double dt,
                       Positions u, Positions v)
    : material_(material),
      network_(network),
      conditions_(std::move(conditions)),
      dt_(dt),
      u_(std::move(u)),
      v_(std::move(v)) {}

void Integrator::tell_parts() {
  using parts::array_bytes, parts::Kind;
  network_parts_ = parts_of(network_);
  if (material_.has_angles()) parts_.emplace_back(Kind::Angles, work_.stars.bytes());
  if (conditions_.fixed.size() > 0) parts_.emplace_back(Kind::Constraints, array_bytes(conditions_.fixed));
  if (conditions_.load.size() > 0) parts_.emplace_back(Kind::Loads, array_bytes(conditions_.load));
  if (conditions_.drive) parts_.emplace_back(Kind::Drive, array_bytes(conditions_.drive->nodes));
}

double Integrator::kinetic_energy() const { return 0.5 * conditions_.node_mass * velocity().squaredNorm(); }

double Integrator::potential_energy() const {
  const double elastic = visit(
      material_, [&](const auto& law, const auto& angle) { return energy(law, angle, network_, work_); });
  return conditions_.load.size() > 0 ? elastic - (planted(Mutant::load_raises_energy) ? -1.0 : 1.0) *
                                                     conditions_.load.cwiseProduct(u_).sum()
                                     : elastic;
}

Vec3 Integrator::momentum() const { return conditions_.node_mass * v_.colwise().sum().transpose(); }

void Integrator::fail(const std::string& when, const Positions& u) const {
  throw NumericalFailure(fmt::format("{}: {}", when, what_is_inadmissible(material_, network_, u)),
                         FailureMode::Bond);
}

}  // namespace veriflex::solid
