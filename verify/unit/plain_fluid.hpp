/// The fluid as a textbook writes it: two lattices, populations f themselves, one node after the other, no
/// care for speed. What the fast loops are compared with, and what they are compared on.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "fluid/fluid.hpp"

namespace veriflex::fluid {

/// A different state at every node, of the size of weak flow, out of equilibrium.
inline std::function<Populations(std::int64_t)> disorder(double amplitude) {
  return [amplitude](std::int64_t node) {
    std::mt19937 random(static_cast<unsigned>(node) + 7U);
    std::uniform_real_distribution<double> noise(-amplitude, amplitude);
    Populations h;
    for (int q = 0; q < Q; ++q) h[static_cast<std::size_t>(q)] = w(q) * noise(random);
    return h;
  };
}

inline Walls sliding() { return {.low_velocity = {0.01, -0.02, 0.03}, .high_velocity = {-0.03, 0.01, 0.02}}; }

/// Fluid enters at the low end, and leaves at the other.
inline Walls passage(bool parabolic = true) {
  return {.openings = {Inflow{.velocity = {0.02, 0.03, 0.01}, .parabolic = parabolic, .rise = 5.0},
                       Outflow{0.99}}};
}

class PlainFluid {
 public:
  PlainFluid(const Spec& spec, const std::function<Populations(std::int64_t)>& start)
      : spec_(spec),
        now_(static_cast<std::size_t>(spec.grid.count())),
        next_(now_.size()),
        solid_(now_.size()) {
    for (const std::int64_t node : spec.obstacle) solid_[static_cast<std::size_t>(node)] = true;
    for (std::size_t node = 0; node < now_.size(); ++node) {
      now_[node] = start(static_cast<std::int64_t>(node));
      for (int q = 0; q < Q; ++q) now_[node][static_cast<std::size_t>(q)] += w(q);
    }
  }

  void step(const std::vector<Vec3>& nodal_force) {
    for (std::size_t node = 0; node < now_.size(); ++node) {
      const Populations after = collided(now_[node], nodal_force[node]);
      for (int q = 0; q < Q; ++q)
        stream(static_cast<std::int64_t>(node), q, after[static_cast<std::size_t>(q)]);
    }
    std::swap(now_, next_);
    ++steps_;
  }

  /// Deviations, as the fast fluid gives them.
  Populations populations(std::int64_t node) const {
    Populations h = now_[static_cast<std::size_t>(node)];
    for (int q = 0; q < Q; ++q) h[static_cast<std::size_t>(q)] -= w(q);
    return h;
  }

 private:
  static Vec3 velocity(int q) {
    const auto& v = c[static_cast<std::size_t>(q)];
    return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
  }

  Populations collided(const Populations& f, const Vec3& nodal_force) const {
    const double rho = density(f);
    const Vec3 j = rho * flow(f);
    const double omega = 1.0 / spec_.relaxation_time;
    const Vec3& g = spec_.body_force;
    const bool guo = spec_.scheme == Scheme::Guo;
    const Vec3 u = (guo ? Vec3(j + 0.5 * g) : j) / rho;
    Populations after;
    for (int q = 0; q < Q; ++q) {
      const Vec3 v = velocity(q);
      const double cu = v.dot(u);
      const double rest = w(q) * rho * (1.0 + 3.0 * cu + 4.5 * cu * cu - 1.5 * u.dot(u));
      const double source =
          guo ? (1.0 - 0.5 * omega) * w(q) * (3.0 * (v - u) + 9.0 * cu * v).dot(g) : 3.0 * w(q) * v.dot(g);
      const double value = f[static_cast<std::size_t>(q)];
      after[static_cast<std::size_t>(q)] =
          value - omega * (value - rest) + source + 3.0 * w(q) * v.dot(nodal_force);
    }
    return after;
  }

  static double density(const Populations& f) {
    double rho = 0.0;
    for (const double each : f) rho += each;
    return rho;
  }

  static Vec3 flow(const Populations& f) {
    Vec3 j = Vec3::Zero();
    for (int q = 0; q < Q; ++q) j += f[static_cast<std::size_t>(q)] * velocity(q);
    return j / density(f);
  }

  /// What comes back from an end of an axis in the place of `value`.
  double at_end(const Walls& walls, bool high, std::size_t axis, const std::array<std::int64_t, 3>& at, int q,
                double value) const {
    const auto& opening = walls.openings[high ? 1 : 0];
    Vec3 moving = high ? walls.high_velocity : walls.low_velocity;
    if (const auto* outflow = std::get_if<Outflow>(&opening)) {
      std::array<std::int64_t, 3> inner = at;
      inner[axis] += high ? -1 : 1;
      auto inside = static_cast<std::size_t>(spec_.grid.index(inner[0], inner[1], inner[2]));
      const auto node = static_cast<std::size_t>(spec_.grid.index(at[0], at[1], at[2]));
      if (inner[axis] < 0 || inner[axis] >= spec_.grid.size[axis] || solid_[inside]) inside = node;
      const auto share = [&](const Populations& f) {
        return 0.5 * (f[static_cast<std::size_t>(opposite(q))] + w(q) * (outflow->density - density(f)));
      };
      return share(now_[node]) + share(now_[inside]);
    }
    if (const auto* inflow = std::get_if<Inflow>(&opening)) {
      const double t = static_cast<double>(steps_ + 1);
      moving = inflow->velocity;
      if (t < inflow->rise) moving *= 0.5 * (1.0 - std::cos(M_PI * t / inflow->rise));
      for (std::size_t other = 0; inflow->parabolic && other < 3; ++other) {
        const double s = (static_cast<double>(at[other]) + 0.5) / static_cast<double>(spec_.grid.size[other]);
        if (other != axis && spec_.walls[other]) moving *= 4.0 * s * (1.0 - s);
      }
    }
    return value - 6.0 * w(q) * velocity(q).dot(moving);
  }

  void stream(std::int64_t node, int q, double value) {
    const auto at = spec_.grid.node(node);
    const auto& v = c[static_cast<std::size_t>(q)];
    std::array<std::int64_t, 3> to{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      to[axis] = at[axis] + v[axis];
      const bool beyond = to[axis] < 0 || to[axis] >= spec_.grid.size[axis];
      if (beyond && spec_.walls[axis]) {
        next_[static_cast<std::size_t>(node)][static_cast<std::size_t>(opposite(q))] =
            at_end(*spec_.walls[axis], v[axis] > 0, axis, at, q, value);
        return;
      }
      to[axis] = (to[axis] + spec_.grid.size[axis]) % spec_.grid.size[axis];
    }
    const auto target = static_cast<std::size_t>(spec_.grid.index(to[0], to[1], to[2]));
    if (solid_[target] != solid_[static_cast<std::size_t>(node)]) {
      next_[static_cast<std::size_t>(node)][static_cast<std::size_t>(opposite(q))] = value;
    } else {
      next_[target][static_cast<std::size_t>(q)] = value;
    }
  }

  Spec spec_;
  std::vector<Populations> now_, next_;
  std::vector<bool> solid_;
  std::int64_t steps_ = 0;
};

}  // namespace veriflex::fluid
