#include "scene/coupled_step.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <unordered_map>

#include "base/mutant.hpp"
#include "coupling/transfer.hpp"
#include "scene/markers.hpp"
#include "solid/leapfrog.hpp"
#include "solid/modes.hpp"

namespace veriflex::scene {

namespace {

std::vector<coupling::Transfer> transfers_of(const fluid::Spec& fluid, std::span<const Body> bodies) {
  std::vector<coupling::Transfer> transfers;
  for (const Body& body : bodies) {
    transfers.emplace_back(fluid.grid, closed(fluid), body.coupling->delta, fluid.obstacle);
    transfers.back().locate(markers_at_rest(body));
  }
  return transfers;
}

/// Nodes that two bodies touch: their places in both lists.
std::vector<std::pair<Eigen::Index, Eigen::Index>> shared_nodes(const coupling::Transfer& a,
                                                                const coupling::Transfer& b) {
  std::unordered_map<std::int64_t, Eigen::Index> places;
  for (std::size_t i = 0; i < a.nodes().size(); ++i) places.emplace(a.nodes()[i], i);
  std::vector<std::pair<Eigen::Index, Eigen::Index>> shared;
  for (std::size_t i = 0; i < b.nodes().size(); ++i) {
    const auto found = places.find(b.nodes()[i]);
    if (found != places.end()) shared.emplace_back(found->second, static_cast<Eigen::Index>(i));
  }
  return shared;
}

/// A: what a unit force at one marker gives to all, three markers at a time.
Eigen::SparseMatrix<double> exchange_of(const std::vector<coupling::Transfer>& transfers,
                                        const std::vector<Eigen::Index>& markers) {
  std::vector<Eigen::Triplet<double>> entries;
  Positions spread, back;
  Eigen::Index from = 0, all = 0;  // first marker of a body, and how many in all
  for (std::size_t giver = 0; giver < transfers.size(); from += markers[giver], ++giver) {
    Eigen::Index to = 0;
    for (std::size_t taker = 0; taker < transfers.size(); to += markers[taker], ++taker) {
      const auto shared = shared_nodes(transfers[giver], transfers[taker]);
      if (shared.empty()) continue;
      Positions found = Positions::Zero(static_cast<Eigen::Index>(transfers[taker].nodes().size()), 3);
      for (Eigen::Index first = 0; first < markers[giver]; first += 3) {
        const Eigen::Index count = std::min<Eigen::Index>(3, markers[giver] - first);
        Positions unit = Positions::Zero(markers[giver], 3);
        for (Eigen::Index i = 0; i < count; ++i) unit(first + i, i) = 1.0;
        transfers[giver].spread(unit, spread);
        for (const auto& [there, here] : shared) found.row(here) = spread.row(there);
        transfers[taker].interpolate(found, back);
        for (Eigen::Index i = 0; i < count; ++i) {
          for (Eigen::Index m = 0; m < markers[taker]; ++m) {
            if (back(m, i) != 0.0) entries.emplace_back(to + m, from + first + i, back(m, i));
          }
        }
      }
    }
    all += markers[giver];
  }
  Eigen::SparseMatrix<double> exchange(all, all);
  exchange.setFromTriplets(entries.begin(), entries.end());
  return exchange;
}

}  // namespace

std::vector<std::vector<std::size_t>> bodies_that_share_nodes(const Scene& scene) {
  std::vector<std::size_t> coupled;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (scene.fluid && scene.bodies[i].coupling) coupled.push_back(i);
  }
  if (coupled.empty()) return {};
  if (coupled.size() == 1) return {coupled};
  std::vector<std::vector<std::size_t>> groups;
  std::vector<std::vector<coupling::Transfer>> supports;  // of each group's bodies
  for (const std::size_t i : coupled) {
    std::vector<std::size_t> group{i};
    std::vector<coupling::Transfer> own = transfers_of(*scene.fluid, std::span(&scene.bodies[i], 1));
    for (std::size_t g = groups.size(); g-- > 0;) {
      const bool do_share = std::any_of(supports[g].begin(), supports[g].end(), [&](const auto& other) {
        return !shared_nodes(own.front(), other).empty();
      });
      if (!do_share) continue;
      group.insert(group.begin(), groups[g].begin(), groups[g].end());
      std::move(supports[g].begin(), supports[g].end(), std::back_inserter(own));
      groups.erase(groups.begin() + static_cast<std::ptrdiff_t>(g));
      supports.erase(supports.begin() + static_cast<std::ptrdiff_t>(g));
    }
    groups.push_back(std::move(group));
    supports.push_back(std::move(own));
  }
  return groups;
}

CoupledStep::CoupledStep(const fluid::Spec& fluid, std::span<const Body> bodies, FluidMemory memory)
    : memory_(memory) {
  std::vector<std::vector<std::int32_t>> nodes;
  std::vector<Eigen::Index> markers;
  for (const Body& body : bodies) {
    nodes.push_back(coupled_nodes(body));
    markers.push_back(static_cast<Eigen::Index>(nodes.back().size()));
  }
  exchange_ = exchange_of(transfers_of(fluid, bodies), markers);
  place_.assign(static_cast<std::size_t>(marker_values()), -1);
  std::vector<Eigen::Triplet<double>> entries;  // of the stiffness
  Eigen::Index first_marker = 0, first = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Body& body = bodies[i];
    const CouplingSpec& coupling = *body.coupling;
    Part part{.first = first,
              .count = 0,
              .first_marker = first_marker,
              .markers = markers[i],
              .node_mass = body.conditions.node_mass,
              .drag = body.conditions.drag,
              .marker_volume = coupling.marker_volume,
              .substeps = body.substeps.count,
              .forcing_iterations = coupling.forcing_iterations,
              .subcycled = coupling.subcycled,
              .implicit = body.scheme == solid::Scheme::ImplicitMidpoint};
    if (!body.motion) {
      const Positions rest = Positions::Zero(body.network.node_count(), 3);
      const solid::FixedDofs held = solid::prescribed_dofs(body.conditions, body.network.node_count());
      const Sparse stiffness = solid::free_hessian(body.material, body.network, rest, held);
      part.count = stiffness.rows();
      for (Eigen::Index column = 0; column < part.count; ++column) {
        for (Sparse::InnerIterator entry(stiffness, column); entry; ++entry)
          entries.emplace_back(first + entry.row(), first + column, entry.value());
      }
      if (body.substeps.safety > 0.0) {
        part.substeps =
            solid::Leapfrog(body.material, body.network, body.conditions, 1.0, body.substeps, rest, rest)
                .substeps();
      }
      const solid::DofMap dofs(held);
      for (Eigen::Index axis = 0; axis < 3; ++axis) {
        for (Eigen::Index m = 0; m < part.markers; ++m) {
          const int number =
              dofs.number[axis * body.network.node_count() + nodes[i][static_cast<std::size_t>(m)]];
          if (number < 0) continue;
          place_[static_cast<std::size_t>(axis * exchange_.rows() + first_marker + m)] =
              static_cast<int>(first) + number;
        }
      }
    }
    first += part.count;
    first_marker += part.markers;
    parts_.push_back(std::move(part));
  }
  stiffness_.resize(first, first);
  stiffness_.setFromTriplets(entries.begin(), entries.end());
  for (Part& part : parts_) prepare(part);
  const auto same = [&](const Part& part) {
    const Part& one = parts_.front();
    return part.count > 0 && part.node_mass == one.node_mass && part.drag == one.drag &&
           part.marker_volume == one.marker_volume && part.substeps == one.substeps &&
           part.subcycled == one.subcycled && part.implicit == one.implicit && part.forcing_iterations == 1 &&
           one.forcing_iterations == 1;
  };
  is_uniform_ = parts_.size() == 1 || std::all_of(parts_.begin(), parts_.end(), same);
}

void CoupledStep::set_node_mass(double mass) {
  for (Part& part : parts_) {
    part.node_mass = mass;
    prepare(part);
  }
}

CoupledStep::Vector CoupledStep::at_markers(const Vector& free) const {
  Vector values(marker_values());
  for (Eigen::Index m = 0; m < values.size(); ++m) {
    const int place = place_[static_cast<std::size_t>(m)];
    values[m] = place < 0 ? 0.0 : free[place];
  }
  return values;
}

CoupledStep::Vector CoupledStep::at_coordinates(const Vector& markers) const {
  Vector free = Vector::Zero(free_count());
  for (Eigen::Index m = 0; m < markers.size(); ++m) {
    const int place = place_[static_cast<std::size_t>(m)];
    if (place >= 0) free[place] += markers[m];
  }
  return free;
}

CoupledStep::Vector CoupledStep::exchanged(const Vector& force) const {
  const Eigen::Index markers = exchange_.rows();
  Vector given(force.size());
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    given.segment(axis * markers, markers) = exchange_ * force.segment(axis * markers, markers);
  }
  return given;
}

CoupledStep::Sparse CoupledStep::answering() const {
  Vector root(exchange_.rows());
  for (const Part& part : parts_)
    root.segment(part.first_marker, part.markers).setConstant(std::sqrt(part.marker_volume));
  return root.asDiagonal() * exchange_ * root.asDiagonal();
}

bool CoupledStep::couples_free_coordinates() const {
  return std::any_of(place_.begin(), place_.end(), [](int place) { return place >= 0; });
}

/// What stands at the markers of one body, 0 at all others.
CoupledStep::Vector CoupledStep::own(const Part& part, const Vector& markers) const {
  Vector of_part = Vector::Zero(marker_values());
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const Eigen::Index at = axis * exchange_.rows() + part.first_marker;
    of_part.segment(at, part.markers) = markers.segment(at, part.markers);
  }
  return of_part;
}

/// What each body asks of its coupled nodes: the fluid's velocity, and more with further rounds of forcing,
/// which know of the body's own force alone.
CoupledStep::Vector CoupledStep::wanted_velocity(const Vector& v, const Vector& W) const {
  Vector wanted = W;
  for (const Part& part : parts_) {
    if (part.forcing_iterations == 1) continue;
    Vector missing = own(part, W - at_markers(v));
    for (int round = 1; round < part.forcing_iterations; ++round) {  // coupling::add_further_rounds
      missing -= part.marker_volume * own(part, exchanged(missing));
      wanted += missing;
    }
  }
  return wanted;
}

void CoupledStep::prepare(Part& part) const {
  if (!part.implicit || part.count == 0) return;
  Sparse middle = 0.5 * stiffness_.block(part.first, part.first, part.count, part.count);
  for (Eigen::Index i = 0; i < part.count; ++i) middle.coeffRef(i, i) += 2.0 * part.node_mass + part.drag;
  if (part.subcycled) {
    const Vector coupled = at_coordinates(own(part, Vector::Ones(marker_values())));
    for (Eigen::Index i = 0; i < part.count; ++i)
      middle.coeffRef(i, i) += part.marker_volume * coupled[part.first + i];
  }
  part.middle = std::make_shared<const solid::Cholesky>(middle);
}

/// A step of a body by the implicit midpoint rule; `mean` becomes its force.
void CoupledStep::move_implicitly(const Part& part, Vector& f, Vector& v, const Vector& wanted,
                                  Vector& mean) const {
  auto own_f = f.segment(part.first, part.count);
  auto own_v = v.segment(part.first, part.count);
  const Vector known =
      part.marker_volume * own(part, part.subcycled ? wanted : Vector(wanted - at_markers(v)));
  Vector middle = Vector::Zero(free_count());
  middle.segment(part.first, part.count) = part.middle->solve(
      2.0 * part.node_mass * own_v + own_f + at_coordinates(known).segment(part.first, part.count));
  mean += part.subcycled ? Vector(part.marker_volume * own(part, wanted - at_markers(middle))) : known;
  own_v = 2.0 * middle.segment(part.first, part.count) - own_v;
  f -= stiffness_ * middle;  // couples the coordinates of a body to each other only
}

/// The sub-steps of a body; `mean` becomes its mean force.
void CoupledStep::move(const Part& part, Vector& f, Vector& v, const Vector& wanted, Vector& mean) const {
  const double step = 1.0 / part.substeps;
  const double half_drag = 0.5 * part.drag * step / part.node_mass;
  const double kick = step / part.node_mass / (1.0 + half_drag);
  const auto force_now = [&] { return Vector(part.marker_volume * own(part, wanted - at_markers(v))); };
  const auto stiffness = stiffness_.middleCols(part.first, part.count);  // couples them to each other only
  auto own_f = f.segment(part.first, part.count);
  auto own_v = v.segment(part.first, part.count);
  Vector force = force_now();
  for (int i = 0; i < part.substeps; ++i) {
    own_v *= (1.0 - half_drag) / (1.0 + half_drag);
    if (part.subcycled && i > 0) force = force_now();
    mean += force / part.substeps;
    own_v += kick * (own_f + at_coordinates(force).segment(part.first, part.count));
    f -= (planted(Mutant::map_of_one_substep) ? 1.0 : step) * (stiffness * own_v);
  }
}

CoupledStep::Vector CoupledStep::next(const Vector& state) const {
  Vector f = state.head(free_count());
  Vector v = state.segment(free_count(), free_count());
  Vector W = state.tail(marker_values());
  const Vector wanted = wanted_velocity(v, W);
  Vector mean = Vector::Zero(marker_values());
  for (const Part& part : parts_) {
    if (part.middle)
      move_implicitly(part, f, v, wanted, mean);
    else
      move(part, f, v, wanted, mean);
  }
  if (memory_ == FluidMemory::Keeps) {
    W -= (planted(Mutant::map_without_reaction) ? 0.5 : 1.0) * exchanged(mean);
  } else {
    W.setZero();
  }
  Vector after(size());
  after << f, v, W;
  return after;
}

}  // namespace veriflex::scene
