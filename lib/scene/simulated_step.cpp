#include "scene/simulated_step.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <random>

#include "base/error.hpp"
#include "base/stop.hpp"
#include "fluid/links.hpp"
#include "solid/dof_map.hpp"
#include "solid/modes.hpp"

namespace veriflex::scene {

namespace {

using Vector = SimulatedStep::Vector;

constexpr double amplitude = 1e-8;      // of the largest number of a state that is put in
constexpr double farthest = 1e-2;       // of one that is read out: beyond, it is not linear
constexpr double least_shift = 1e-3;    // of the stiffness in a length, over the largest of K
constexpr double strainless = 1e-9;     // stiffness over the largest of K below which nothing is strained
constexpr double rounded = 1e-7;        // of an image of a state of 1: what is smaller may be rounding
constexpr double known_exactly = 1e-6;  // to which an invariant must be one
constexpr double resting = 1e-4;        // displacement of a body at rest in a run  [L]

/// Uniform in -1 ... 1, the same everywhere.
double uniform(std::mt19937& random) { return 2.0 * static_cast<double>(random()) / 4294967296.0 - 1.0; }

/// (-1) to the power of the coordinate along the axis, of the sum of the other two, or of both.
double sign_of(const std::array<std::int64_t, 3>& node, int axis, bool along, bool across) {
  std::int64_t power = 0;
  for (int i = 0; i < 3; ++i) {
    if (i == axis ? along : across) power += node[static_cast<std::size_t>(i)];
  }
  return power % 2 == 0 ? 1.0 : -1.0;
}

}  // namespace

Scene at_rest(Scene scene) {
  scene.initial_flow = {};
  scene.uniform_force = {};
  if (scene.fluid) {
    scene.fluid->body_force.setZero();
    scene.fluid->representation = fluid::Representation::Populations;  // these are what is perturbed
    for (auto& walls : scene.fluid->walls) {
      if (!walls) continue;
      walls->low_velocity = walls->high_velocity = Vec3::Zero();
      for (auto& opening : walls->openings) {
        if (std::holds_alternative<fluid::Inflow>(opening)) opening = fluid::Inflow{Vec3::Zero()};
        if (std::holds_alternative<fluid::Outflow>(opening)) opening = fluid::Outflow{};
      }
    }
  }
  for (Body& body : scene.bodies) {
    body.conditions.load.resize(0, 3);
    if (body.conditions.drive) body.conditions.drive->amplitude = 0.0;
    if (body.motion) body.motion = Motion{};
  }
  return scene;
}

SimulatedStep::SimulatedStep(const Scene& scene) {
  if (!scene.fluid) {
    throw BadParameter("fluid", "the scene has no fluid",
                       "bodies alone neither grow nor decay: their "
                       "oscillations all stand on the unit circle",
                       "Add a fluid, or ask for the step limit of leap-frog");
  }
  if (scene.fluid->storage != fluid::Storage::Double) {
    throw BadParameter("fluid.storage", "the growth of small states is asked of float populations",
                       "their rounding is as large as what should grow", "Use storage = \"double\"");
  }
  const Scene still = at_rest(scene);
  simulation_ = std::make_unique<Simulation>(still);
  rest_ = simulation_->state();
  for (std::size_t i = 0; i < still.bodies.size(); ++i) {
    if (!still.bodies[i].motion) add_body(still.bodies[i], i);
  }
  fluid_nodes_ = fluid::outside_of_obstacle(*scene.fluid);
  weight_.resize(first_population_ + fluid::Q * static_cast<Eigen::Index>(fluid_nodes_.size()));
  for (const auto& body : bodies_) {
    weight_.segment(body->first, body->count()).setConstant(body->shift);
    weight_.segment(body->first + body->count(), body->count()).setConstant(body->node_mass);
  }
  for (Eigen::Index i = first_population_; i < weight_.size(); ++i) {
    weight_[i] = 1.0 / (3.0 * fluid::w(static_cast<int>((i - first_population_) % fluid::Q)));
  }
  find_invariants();
}

void SimulatedStep::add_body(const Body& body, std::size_t number) {
  const Positions rest = Positions::Zero(body.network.node_count(), 3);
  const solid::FixedDofs held = solid::prescribed_dofs(body.conditions, body.network.node_count());
  const solid::DofMap dofs(held);
  if (dofs.count == 0) return;
  auto free = std::make_unique<FreeBody>();
  free->number = number;
  free->first = first_population_;
  for (Eigen::Index i = 0; i < dofs.number.size(); ++i) {
    if (dofs.number[i] >= 0) free->coordinates.push_back(i);
  }
  free->node_mass = body.conditions.node_mass;
  free->stiffness = solid::free_hessian(body.material, body.network, rest, held);
  const double largest = std::max(solid::infinity_norm(free->stiffness), free->node_mass * 1e-12);
  // A body that stands under pressure may have negative stiffnesses, and no length may.
  const bool is_stable = solid::eigenvalues_below(free->stiffness, -strainless * largest) == 0;
  free->shift = is_stable ? least_shift * largest : 2.0 * largest;
  Sparse shifted = free->stiffness;
  for (Eigen::Index i = 0; i < shifted.rows(); ++i) shifted.coeffRef(i, i) += strainless * largest;
  free->strained.compute(shifted);
  first_population_ += 2 * free->count();
  bodies_.push_back(std::move(free));
}

/// Each pass leaves of a mode of stiffness k the part k/(k + shift): all where the body is strained, nothing
/// where it is not.
SimulatedStep::Vector SimulatedStep::strained(const FreeBody& body, const Vector& u) const {
  Vector found = Vector::Zero(u.size());
  for (int pass = 0; pass < 3; ++pass) found += body.strained.solve(body.stiffness * (u - found));
  return found;
}

State SimulatedStep::perturbed(const Vector& state, double scale) const {
  State put = rest_;
  for (const auto& body : bodies_) {
    solid::Integrator::State& elastic = *put.bodies[body->number].elastic;
    for (Eigen::Index i = 0; i < body->count(); ++i) {
      const Eigen::Index at = body->coordinates[static_cast<std::size_t>(i)];
      elastic.displacement.data()[at] += scale * state[body->first + i];
      elastic.velocity.data()[at] += scale * state[body->first + body->count() + i];
    }
  }
  Eigen::Index next = first_population_;
  for (const std::int64_t node : fluid_nodes_) {
    for (double& h : put.fluid->populations[static_cast<std::size_t>(node)]) h += scale * state[next++];
  }
  return put;
}

SimulatedStep::Vector SimulatedStep::read() const {
  const State now = simulation_->state();
  Vector state(size());
  for (const auto& body : bodies_) {
    const solid::Integrator::State& elastic = *now.bodies[body->number].elastic;
    for (Eigen::Index i = 0; i < body->count(); ++i) {
      const Eigen::Index at = body->coordinates[static_cast<std::size_t>(i)];
      state[body->first + i] = elastic.displacement.data()[at];
      state[body->first + body->count() + i] = elastic.velocity.data()[at];
    }
  }
  Eigen::Index next = first_population_;
  for (const std::int64_t node : fluid_nodes_) {
    for (const double h : now.fluid->populations[static_cast<std::size_t>(node)]) state[next++] = h;
  }
  return state;
}

const SimulatedStep::Vector& SimulatedStep::rest_after(int steps) const {
  const auto known = rest_later_.find(steps);
  if (known != rest_later_.end()) return known->second;
  simulation_->restore(rest_);
  for (int i = 0; i < steps; ++i) simulation_->advance();
  steps_made_ += steps;
  Vector later = read();
  for (const auto& body : bodies_) {
    const double moved = later.segment(body->first, body->count()).lpNorm<Eigen::Infinity>();
    if (!(moved <= resting)) {
      throw NumericalFailure(
          fmt::format(
              "{} does not rest where it stands: without loads it moves by {:.2g} in {} steps, so that "
              "there is no state whose perturbations could be followed",
              simulation_->body(body->number).name(), moved, steps),
          FailureMode::Equilibrium);
    }
  }
  return rest_later_.emplace(steps, std::move(later)).first->second;
}

SimulatedStep::Vector SimulatedStep::run(const Vector& state, int steps) const {
  stop_if_asked("linearised step", steps_made_);
  const Vector& rest = rest_after(steps);
  const double largest = state.lpNorm<Eigen::Infinity>();
  if (largest == 0.0) return state;
  const double scale = amplitude / largest;
  simulation_->restore(perturbed(state, scale));
  for (int i = 0; i < steps; ++i) simulation_->advance();
  steps_made_ += steps;
  Vector later = read() - rest;
  if (!(later.lpNorm<Eigen::Infinity>() < farthest)) {
    throw NumericalFailure(fmt::format("a small state grew {:.2g} times in {} steps",
                                       later.lpNorm<Eigen::Infinity>() / amplitude, steps),
                           FailureMode::Coupling);
  }
  return later / scale;
}

SimulatedStep::Vector SimulatedStep::after(const Vector& state, int steps) const {
  return without_neutral(run(state, steps));
}

SimulatedStep::Vector SimulatedStep::without_neutral(const Vector& state) const {
  Vector rest = state;
  if (conserved_.cols() > 0) rest -= unchanged_ * (pairing_ * (conserved_.transpose() * state));
  for (const auto& body : bodies_) {
    rest.segment(body->first, body->count()) = strained(*body, rest.segment(body->first, body->count()));
  }
  return rest;
}

/// What strains a body is found by functions of its stiffness, which are symmetric.
SimulatedStep::Vector SimulatedStep::without_neutral_transposed(const Vector& pairing) const {
  Vector rest = pairing;
  for (const auto& body : bodies_) {
    rest.segment(body->first, body->count()) = strained(*body, rest.segment(body->first, body->count()));
  }
  if (conserved_.cols() > 0) rest -= conserved_ * (pairing_.transpose() * (unchanged_.transpose() * rest));
  return rest;
}

SimulatedStep::Sparse SimulatedStep::matrix() const {
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index column = 0; column < size(); ++column) {
    const Vector image = run(Vector::Unit(size(), column), 1);
    for (Eigen::Index row = 0; row < size(); ++row) {
      if (std::abs(image[row]) > rounded) entries.emplace_back(row, column, image[row]);
    }
  }
  Sparse matrix(size(), size());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

SimulatedStep::Sparse SimulatedStep::weights() const {
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index i = 0; i < size(); ++i) entries.emplace_back(i, i, weight_[i]);
  for (const auto& body : bodies_) {
    for (Eigen::Index column = 0; column < body->count(); ++column) {
      for (Sparse::InnerIterator entry(body->stiffness, column); entry; ++entry)
        entries.emplace_back(body->first + entry.row(), body->first + column, entry.value());
    }
  }
  Sparse weights(size(), size());
  weights.setFromTriplets(entries.begin(), entries.end());
  return weights;
}

SimulatedStep::Vector SimulatedStep::noise() const {
  std::mt19937 random(1);
  Vector state(size());
  for (double& x : state) x = uniform(random);
  // As much in each body and in the fluid, and where a weight is large a smaller number.
  state.array() /= weight_.array().sqrt();
  state = without_neutral(state);
  const auto normalise = [&](Eigen::Index first, Eigen::Index count) {
    if (count == 0) return;
    Vector part = Vector::Zero(size());
    part.segment(first, count) = state.segment(first, count);
    const double size_of_part = length(part);
    if (size_of_part > 0.0) state.segment(first, count) /= size_of_part;
  };
  for (const auto& body : bodies_) normalise(body->first, 2 * body->count());
  normalise(first_population_, size() - first_population_);
  state = without_neutral(state);
  return state / length(state);
}

SimulatedStep::Vector SimulatedStep::weighted(const Vector& state) const {
  Vector B = weight_.cwiseProduct(state);
  for (const auto& body : bodies_) {
    B.segment(body->first, body->count()) += body->stiffness * state.segment(body->first, body->count());
  }
  return B;
}

double SimulatedStep::share_of_bodies(const Vector& state) const {
  const Vector B = weighted(state);
  return state.head(first_population_).dot(B.head(first_population_)) / state.dot(B);
}

/// A candidate is taken out when a step is seen to keep it, as a sum and as a state.
void SimulatedStep::find_invariants() {
  struct Candidate {
    Vector sum, state;
    double factor;  // by which a step takes both
  };
  const Grid& grid = simulation_->fluid().spec().grid;
  // A population with c_a != 0 moves by one node along a, and by one along both other axes or along neither.
  const auto candidate = [&](int axis, bool along, bool across) {
    Candidate made{Vector::Zero(size()), Vector::Zero(size()), along ? -1.0 : 1.0};
    Eigen::Index next = first_population_;
    for (const std::int64_t node : fluid_nodes_) {
      const double sign = sign_of(grid.node(node), axis, along, across);
      for (std::size_t q = 0; q < fluid::Q; ++q, ++next) {
        made.sum[next] = sign * (axis < 0 ? 1.0 : fluid::c[q][static_cast<std::size_t>(axis)]);
        made.state[next] = fluid::w(static_cast<int>(q)) * made.sum[next];
      }
    }
    if (axis < 0 || along || across) return made;
    for (const auto& body : bodies_) {
      const Eigen::Index nodes = simulation_->body(body->number).network().node_count();
      for (Eigen::Index i = 0; i < body->count(); ++i) {
        if (body->coordinates[static_cast<std::size_t>(i)] / nodes != axis) continue;
        made.sum[body->first + body->count() + i] = body->node_mass;
        made.state[body->first + body->count() + i] = 1.0 / 3.0;  // w c in the fluid is a velocity of 1/3
      }
    }
    return made;
  };
  const Vector any = noise();
  const Vector next = run(any, 1);
  std::vector<Candidate> found;
  const auto keep_if_kept = [&](Candidate made) {
    const double error = length(without_neutral(run(made.state, 1) - made.factor * made.state));
    const double changed = made.sum.dot(next) - made.factor * made.sum.dot(any);
    if (error <= known_exactly * length(made.state) &&
        std::abs(changed) <= known_exactly * made.sum.cwiseAbs().dot(any.cwiseAbs())) {
      found.push_back(std::move(made));
    }
  };
  keep_if_kept(candidate(-1, false, false));
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool along : {false, true}) {
      for (const bool across : {false, true}) keep_if_kept(candidate(axis, along, across));
    }
  }
  conserved_.resize(size(), static_cast<Eigen::Index>(found.size()));
  unchanged_.resize(size(), conserved_.cols());
  for (Eigen::Index k = 0; k < conserved_.cols(); ++k) {
    conserved_.col(k) = found[static_cast<std::size_t>(k)].sum;
    unchanged_.col(k) = found[static_cast<std::size_t>(k)].state;
  }
  pairing_ = (conserved_.transpose() * unchanged_).inverse();
}

}  // namespace veriflex::scene
