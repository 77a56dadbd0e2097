#include "scene/coupling_stability.hpp"

#include <Spectra/GenEigsSolver.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <random>

#include "solid/freedom.hpp"
#include "solid/modes.hpp"

namespace veriflex::scene {

namespace {

using Vector = Eigen::VectorXd;

constexpr Eigen::Index dense_size = 200;  // of the state; below, a dense solver is faster and cannot fail
constexpr int warming_steps = 200;        // what decays is gone
constexpr int krylov_size = 30;
constexpr int most_restarts = 40;
constexpr double tolerance = 1e-7;
constexpr double nothing = 1e-6;  // a node mass below which none is looked for  [M]

/// One step as Simulation and Leapfrog make it. The elastic force f = - K u takes the displacement's place:
/// in u a rigid motion grows with time at constant velocity, which is no instability, and in f it is nothing.
class Step {
 public:
  using Scalar = double;

  Step(const fluid::Spec& fluid, const Body& body, const CouplingSpec& coupling, double memory)
      : coupling_(coupling),
        memory_(memory),
        transfer_(fluid.grid, closed(fluid), coupling.delta),
        freedom_(prescribed(body)),
        stiffness_(solid::free_hessian(body.material, body.network, at_rest(body), prescribed(body))),
        nodes_(coupled_nodes(body.network, coupling)) {
    const Positions rest = at_rest(body);
    substeps_ = solid::Leapfrog(body.material, body.network, body.conditions, 1.0, body.substeps, rest, rest)
                    .substeps();
    step_ = 1.0 / substeps_;
    half_drag_ = 0.5 * body.conditions.drag * step_ / body.conditions.node_mass;
    kick_ = step_ / body.conditions.node_mass / (1.0 + half_drag_);
    Positions markers(static_cast<Eigen::Index>(nodes_.size()), 3);
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      markers.row(static_cast<Eigen::Index>(i)) =
          body.network.rest.row(nodes_[i]) + coupling.origin.transpose();
    }
    transfer_.locate(markers);
    for (int axis = 0; axis < 3; ++axis) {
      for (const std::int32_t node : nodes_) {
        place_.push_back(freedom_.number[axis * body.network.node_count() + node]);
      }
    }
  }

  // For Spectra: size of the state (f, v, W), and the state a step later.
  Eigen::Index rows() const { return 2 * freedom_.count + static_cast<Eigen::Index>(place_.size()); }
  Eigen::Index cols() const { return rows(); }
  void perform_op(const double* before, double* after) const {
    Eigen::Map<Vector>(after, rows()) = next(Eigen::Map<const Vector>(before, rows()));
  }

  Vector next(const Vector& state) const {
    Vector f = state.head(freedom_.count);
    Vector v = state.segment(freedom_.count, freedom_.count);
    const auto markers = static_cast<Eigen::Index>(nodes_.size());
    Positions W = Eigen::Map<const Positions>(state.data() + 2 * freedom_.count, markers, 3);

    Positions wanted = W;
    coupling::add_further_rounds(transfer_, W - at_markers(v), coupling_.marker_volume, coupling_.iterations,
                                 wanted);
    Positions force = coupling_.marker_volume * (wanted - at_markers(v));
    Positions mean = Positions::Zero(markers, 3);
    for (int i = 0; i < substeps_; ++i) {
      v *= (1.0 - half_drag_) / (1.0 + half_drag_);
      if (coupling_.live && i > 0) force = coupling_.marker_volume * (wanted - at_markers(v));
      mean += force / substeps_;
      v += kick_ * f;
      for (Eigen::Index m = 0; m < force.size(); ++m) {
        const int place = place_[static_cast<std::size_t>(m)];
        if (place >= 0) v[place] += kick_ * force.data()[m];
      }
      f -= step_ * (stiffness_ * v);
    }
    W = memory_ * (W - exchanged(mean));

    Vector after(rows());
    after << f, v, Eigen::Map<const Vector>(W.data(), W.size());
    return after;
  }

  /// A state without elastic force.
  Vector start() const {
    std::mt19937 random(1);  // its numbers are the same everywhere
    Vector state = Vector::Zero(rows());
    for (Eigen::Index i = freedom_.count; i < state.size(); ++i) {
      state[i] = 2.0 * static_cast<double>(random()) / 4294967296.0 - 1.0;
    }
    return state;
  }

 private:
  static Positions at_rest(const Body& body) { return Positions::Zero(body.network.node_count(), 3); }
  static solid::Held prescribed(const Body& body) {
    solid::Held held = body.conditions.held;
    if (held.size() == 0) held = solid::Held::Constant(body.network.node_count(), 3, false);
    if (const auto& drive = body.conditions.drive) {
      for (const std::int32_t node : drive->nodes) held(node, drive->axis) = true;
    }
    return held;
  }

  Positions at_markers(const Vector& v) const {
    Positions values(static_cast<Eigen::Index>(nodes_.size()), 3);
    for (Eigen::Index m = 0; m < values.size(); ++m) {
      const int place = place_[static_cast<std::size_t>(m)];
      values.data()[m] = place < 0 ? 0.0 : v[place];
    }
    return values;
  }

  /// A F
  Positions exchanged(const Positions& F) const {
    Positions spread, back;
    transfer_.spread(F, spread);
    transfer_.interpolate(spread, back);
    return back;
  }

  CouplingSpec coupling_;
  double memory_;
  coupling::Transfer transfer_;
  solid::Freedom freedom_;
  Eigen::SparseMatrix<double> stiffness_;
  std::vector<std::int32_t> nodes_;
  std::vector<int> place_;  // of each coupled coordinate among the free ones; -1 where prescribed
  int substeps_;
  double step_, half_drag_, kick_;
};

}  // namespace

double coupling_growth(const fluid::Spec& fluid, const Body& body, const CouplingSpec& coupling,
                       double memory) {
  Step step(fluid, body, coupling, memory);
  if (step.rows() <= dense_size) {
    Eigen::MatrixXd map(step.rows(), step.cols());
    for (Eigen::Index i = 0; i < step.cols(); ++i) map.col(i) = step.next(Vector::Unit(step.rows(), i));
    return std::max(1.0, Eigen::EigenSolver<Eigen::MatrixXd>(map, false).eigenvalues().cwiseAbs().maxCoeff());
  }
  Vector state = step.start();
  for (int i = 0; i < warming_steps; ++i) state = step.next(state).normalized();
  Spectra::GenEigsSolver<Step> solver(step, 1, krylov_size);
  solver.init(state.data());
  solver.compute(Spectra::SortRule::LargestMagn, most_restarts, tolerance);
  // A motion that grows stands apart from the many that neither grow nor decay, and is found; these are so
  // close to each other that none is, and then nothing grows.
  const auto found = solver.eigenvalues();
  return found.size() > 0 ? std::max(1.0, found.cwiseAbs().maxCoeff()) : 1.0;
}

double critical_node_mass(const fluid::Spec& fluid, Body body, const CouplingSpec& coupling, double accuracy,
                          double memory) {
  const auto grows = [&](double mass) {
    body.conditions.node_mass = mass;
    return coupling_growth(fluid, body, coupling, memory) > 1.0 + growth_resolution;
  };
  double stable = body.conditions.node_mass, unstable = stable;
  if (grows(stable)) {
    while (grows(stable)) {
      unstable = stable;
      stable *= 1.25;
    }
  } else {
    while (!grows(unstable)) {
      stable = unstable;
      unstable /= 1.25;
      if (unstable < nothing) return 0.0;
    }
  }
  while (stable - unstable > accuracy * unstable) {
    const double middle = 0.5 * (stable + unstable);
    (grows(middle) ? unstable : stable) = middle;
  }
  return stable;
}

}  // namespace veriflex::scene
