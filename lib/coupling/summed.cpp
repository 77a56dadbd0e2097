#include "coupling/summed.hpp"

#include <algorithm>

#include "base/mutant.hpp"

namespace veriflex::coupling {

void SummedForces::clear() { shares_.clear(); }

void SummedForces::add(std::span<const std::int64_t> nodes, const Positions& force) {
  shares_.reserve(shares_.size() + nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    shares_.push_back({nodes[i], shares_.size(), force.row(static_cast<Eigen::Index>(i))});
  }
}

void SummedForces::sum() {
  std::sort(shares_.begin(), shares_.end(), [](const Share& a, const Share& b) {
    return a.node != b.node ? a.node < b.node : a.order < b.order;
  });
  nodes_.clear();
  force_.resize(static_cast<Eigen::Index>(shares_.size()), 3);
  Eigen::Index row = -1;
  for (const Share& share : shares_) {
    if (!nodes_.empty() && nodes_.back() == share.node) {
      force_.row(row) += (planted(Mutant::shared_node_of_first_body) ? 0.0 : 1.0) * share.force.transpose();
    } else {
      nodes_.push_back(share.node);
      force_.row(++row) = share.force;
    }
  }
  force_.conservativeResize(row + 1, 3);
  part_.takes(parts::array_bytes(shares_, nodes_, force_));
}

}  // namespace veriflex::coupling
