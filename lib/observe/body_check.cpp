#include "observe/body_check.hpp"

#include <fmt/format.h>

#include <cmath>

#include "base/error.hpp"
#include "base/reduce.hpp"
#include "solid/elastic.hpp"

namespace veriflex::observe {

namespace {

double undeformed_energy(const scene::MovingBody& body) {
  const solid::Network& network = body.network();
  return solid::visit(body.spec().material, [&](const auto& law, const auto& angle) {
    solid::Workspace work;
    const bool inside = solid::deform(law, network, Positions::Zero(network.node_count(), 3), work);
    return inside ? solid::energy(law, angle, network, work) : 0.0;
  });
}

double work_of_load(const scene::MovingBody& body) {
  const Positions& load = body.solid().conditions().load;
  return load.size() == 0 ? 0.0 : load.cwiseProduct(body.solid().displacement()).sum();
}

double volume(const Positions& vectors, const std::size_t (&bonds)[3]) {
  const auto edge = [&](int i) { return Vec3(vectors.row(static_cast<Eigen::Index>(bonds[i]))); };
  return edge(0).dot(edge(1).cross(edge(2)));
}

}  // namespace

BodyCheck::BodyCheck(const scene::MovingBody& body, const BodyLimits& limits) : body_(body), limits_(limits) {
  if (limits.energy_growth > 0.0) {
    start_ = energy();
    put_in_ = start_ + work_of_load(body) - undeformed_energy(body);
  }
  if (!limits.physical) return;
  const solid::Network& network = body.network();
  std::vector<std::vector<std::size_t>> from(static_cast<std::size_t>(network.node_count()));
  for (std::size_t b = 0; b < network.bonds.size(); ++b) {
    from[static_cast<std::size_t>(network.bonds[b].first)].push_back(b);
  }
  for (const std::vector<std::size_t>& bonds : from) {
    if (bonds.size() < 3) continue;
    CellCorner corner{{bonds[0], bonds[1], bonds[2]}, 0.0};
    corner.volume = volume(network.vectors, corner.bonds);
    if (corner.volume != 0.0) corners_.push_back(corner);
  }
}

void BodyCheck::look(std::int64_t step) {
  if (limits_.energy_growth > 0.0) look_at_energy(step);
  if (limits_.physical) look_at_shape(step);
}

double BodyCheck::energy() const { return body_.solid().kinetic_energy() + body_.solid().potential_energy(); }

void BodyCheck::look_at_energy(std::int64_t step) {
  load_work_ = worse(load_work_, std::abs(work_of_load(body_)));
  const double departure = std::abs(energy() - start_);
  const double bound = limits_.energy_growth * (put_in_ + load_work_);
  if (departure <= bound) return;
  throw NumericalFailure(
      fmt::format(
          "step {}: the energy of {} has departed by {:.6g} from that of its start, the limit is {:.6g} "
          "(monitor.energy_growth times what was put in)",
          step, body_.name(), departure, bound),
      FailureMode::Energy);
}

void BodyCheck::look_at_shape(std::int64_t step) const {
  constexpr double longest = 2.0;  // over the undeformed length
  const solid::Network& network = body_.network();
  const Positions& u = body_.solid().displacement();
  Positions vectors = network.vectors;
  for (std::size_t b = 0; b < network.bonds.size(); ++b) {
    const auto [first, second] = network.bonds[b];
    const auto row = static_cast<Eigen::Index>(b);
    vectors.row(row) += u.row(second) - u.row(first);
    const double stretch = vectors.row(row).norm() / network.vectors.row(row).norm();
    if (stretch <= longest) continue;
    throw NumericalFailure(
        fmt::format(
            "step {}: the bond of nodes {} and {} of {} is {:.3g} times as long as undeformed, the limit "
            "is {} (monitor.physical)",
            step, network.id_of(first), network.id_of(second), body_.name(), stretch, longest),
        FailureMode::Unphysical);
  }
  for (const CellCorner& corner : corners_) {
    if (volume(vectors, corner.bonds) / corner.volume > 0.0) continue;
    throw NumericalFailure(
        fmt::format("step {}: the cell of {} at node {} is turned inside out (monitor.physical)", step,
                    body_.name(), network.id_of(network.bonds[corner.bonds[0]].first)),
        FailureMode::Unphysical);
  }
}

}  // namespace veriflex::observe
