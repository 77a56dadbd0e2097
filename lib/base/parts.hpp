/// What of a scene this program has built: each part says so while it exists, with the memory that it takes.
/// A plan of a run is held against this, so that it says what was there and not what somebody expected.
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "base/named.hpp"

namespace veriflex::parts {

enum class Kind {
  Bonds,
  Angles,
  LeapFrog,
  Midpoint,
  RungeKutta,
  Statics,
  Hessian,
  Constraints,
  Drive,
  Loads,
  Populations,
  Moments,
  InitialFlow,
  Walls,
  Obstacle,
  BodyForce,
  UniformForce,
  Coupling,
  Sum,
};

/// In the order of Kind.
inline constexpr std::array kinds{
    Named<Kind>{Kind::Bonds, "bonds", "bonds", "nodes and the bonds between them"},
    Named<Kind>{Kind::Angles, "angles", "angles", "list of angles, and their arrangement for the loop"},
    Named<Kind>{Kind::LeapFrog, "leap-frog", "leap_frog", "displacement, velocity, forces"},
    Named<Kind>{Kind::Midpoint, "implicit midpoint", "implicit_midpoint", "displacement and velocity"},
    Named<Kind>{Kind::RungeKutta, "Runge-Kutta", "runge_kutta", "displacement, velocity and their stages"},
    Named<Kind>{Kind::Statics, "statics", "statics", "Hessian and its Cholesky factor"},
    Named<Kind>{Kind::Hessian, "Hessian", "hessian",
                "while it is put together, for a solution or a look at a state"},
    Named<Kind>{Kind::Constraints, "constraints", "constraints", "pass over fixed coordinates"},
    Named<Kind>{Kind::Drive, "drive", "drive", "pass over driven coordinates"},
    Named<Kind>{Kind::Loads, "loads", "loads", "pass over dead loads"},
    Named<Kind>{Kind::Populations, "populations", "populations", "fifteen a node"},
    Named<Kind>{Kind::Moments, "moments", "moments", "density and momentum of each node, in two copies"},
    Named<Kind>{Kind::InitialFlow, "initial flow", "initial_flow", "populations until the first step"},
    Named<Kind>{Kind::Walls, "walls", "walls", "half-way bounce-back at the ends of the box"},
    Named<Kind>{Kind::Obstacle, "obstacle", "obstacle", "nodes inside, and links that they cut"},
    Named<Kind>{Kind::BodyForce, "body force", "body_force", "compiled into the sweep"},
    Named<Kind>{Kind::UniformForce, "uniform force", "uniform_force", "a force on every node at each step"},
    Named<Kind>{Kind::Coupling, "coupling", "coupling",
                "supports and weights of markers, and what is exchanged"},
    Named<Kind>{Kind::Sum, "sum of reactions", "sum_of_reactions",
                "of several bodies at the nodes that they share"},
};

/// Memory of arrays: Eigen's as they are, vectors with the room that they have  [bytes].
template <class... Arrays>
double array_bytes(const Arrays&... arrays) {
  const auto one = []<class Array>(const Array& array) {
    if constexpr (requires { typename Array::Scalar; }) {
      return static_cast<double>(array.size()) * sizeof(typename Array::Scalar);
    } else if constexpr (std::is_same_v<typename Array::value_type, bool>) {
      return static_cast<double>(array.capacity() / 8);
    } else {
      return static_cast<double>(array.capacity() * sizeof(typename Array::value_type));
    }
  };
  return (one(arrays) + ...);
}

/// Held by a part of a scene. A copy is another part; a part that was moved from is none.
class Built {
 public:
  Built() = default;
  /// `shared`: what several parts hold together counts once, by its address.
  Built(Kind kind, double bytes, const void* shared = nullptr);
  Built(const Built& other);
  Built(Built&& other) noexcept;
  Built& operator=(Built other) noexcept;
  ~Built();

  /// Its memory has become that  [bytes].
  void takes(double bytes);

 private:
  Kind kind_{};
  double bytes_ = 0.0;
  const void* shared_ = nullptr;
  bool exists_ = false;
};

/// Of one kind since restart().
struct Made {
  std::uint64_t count = 0;  // that were built
  double bytes = 0.0;       // most that those existing together took
};
using AllMade = std::array<Made, kinds.size()>;  // in the order of Kind
AllMade made();

/// The most that all parts took together, and what the allocators had given out then, beyond what they had at
/// restart()  [bytes].
struct Peak {
  double bytes = 0.0, allocated = 0.0;
};
Peak peak();

/// Forgets all parts that no longer exist.
void restart();

/// What is built while it lives does not count as built: a state that is put back may need more than the run
/// that it came from.
class Aside {
 public:
  Aside() = default;
  ~Aside();
  Aside(const Aside&) = delete;
  Aside& operator=(const Aside&) = delete;

 private:
  AllMade made_ = made();
};

}  // namespace veriflex::parts
