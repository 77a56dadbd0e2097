#include "observe/body_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/mutant.hpp"
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
  const solid::Network& network = body.network();
  if (limits.buckled > 0.0) {
    const auto along = network.rest.col(body.spec().axis);
    const double first = along.minCoeff();
    for (const double place : along) section_of_.push_back(std::llround((place - first) / network.spacing));
  }
  if (!limits.physical) return;
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
  if (limits_.buckled > 0.0) look_for_buckling(step);
  if (limits_.physical) look_at_shape(step);
}

double BodyCheck::energy() const { return body_.solid().kinetic_energy() + body_.solid().potential_energy(); }

void BodyCheck::look_at_energy(std::int64_t step) {
  load_work_ = worse(load_work_, std::abs(work_of_load(body_)));
  const double departure =
      planted(Mutant::lost_energy_unnoticed) ? energy() - start_ : std::abs(energy() - start_);
  const double bound = limits_.energy_growth * (put_in_ + load_work_);
  if (departure <= bound) return;
  throw NumericalFailure(
      fmt::format(
          "step {}: the energy of {} has departed by {:.6g} from that of its start, the limit is {:.6g} "
          "(monitor.energy_growth times what was put in)",
          step, body_.name(), departure, bound),
      FailureMode::Energy);
}

void BodyCheck::look_for_buckling(std::int64_t step) const {
  const auto nodes = static_cast<Eigen::Index>(section_of_.size());
  const Eigen::Index last = *std::max_element(section_of_.begin(), section_of_.end());
  Positions centre = Positions::Zero(last + 1, 3);
  Eigen::VectorXd count = Eigen::VectorXd::Zero(last + 1);
  for (Eigen::Index node = 0; node < nodes; ++node) {
    const Eigen::Index section = section_of_[static_cast<std::size_t>(node)];
    centre.row(section) += body_.network().rest.row(node) + body_.solid().displacement().row(node);
    count[section] += 1.0;
  }
  for (Eigen::Index section = 0; section <= last; ++section) centre.row(section) /= count[section];
  const double length = static_cast<double>(last) * body_.network().spacing;
  const Vec3 line = centre.row(last) - centre.row(0);
  if (!(line.norm() < length)) return;
  for (Eigen::Index section = 1; section < last; ++section) {
    const Vec3 from_end = centre.row(section) - centre.row(0);
    const double deflection = (from_end - line * (from_end.dot(line) / line.squaredNorm())).norm() / length;
    if (deflection <= (planted(Mutant::buckling_overlooked) ? 10.0 : 1.0) * limits_.buckled) continue;
    throw NumericalFailure(
        fmt::format("step {}: {} has buckled: section {} stands {:.3g} of its length off the line between "
                    "its ends, the limit is {} (monitor.buckled)",
                    step, body_.name(), section, deflection, limits_.buckled),
        FailureMode::Buckled);
  }
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
    if (volume(vectors, corner.bonds) / corner.volume > 0.0 || planted(Mutant::cells_inside_out)) continue;
    throw NumericalFailure(
        fmt::format("step {}: the cell of {} at node {} is turned inside out (monitor.physical)", step,
                    body_.name(), network.id_of(network.bonds[corner.bonds[0]].first)),
        FailureMode::Unphysical);
  }
}

}  // namespace veriflex::observe
