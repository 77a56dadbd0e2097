/// The fluid's fields where and when somebody asks for them: nothing is stored otherwise.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "fluid/fluid.hpp"
#include "observe/record.hpp"

namespace veriflex::observe {

/// Which columns a record gets beside the position of the nodes.
struct Fields {
  bool density = false;   // rho  [M L^-3]
  bool velocity = false;  // sum f c / rho, without the half step of a body force  [L T^-1]
  bool stress = false;    // viscous; without a force in its equilibrium  [M L^-1 T^-2]
};

/// The columns of such a record: x, y, z of the node and what is asked for.
std::vector<Column> columns_of(const Fields& fields);

/// One row per node: x, y, z and what was asked for, before the next collision.
Record at_nodes(const fluid::Fluid& fluid, std::span<const std::int64_t> nodes, const Fields& fields,
                const std::string& name, const std::string& title);

/// The nodes of the line along `axis` through a node, from 0 upwards.
std::vector<std::int64_t> line(const Grid& grid, std::size_t axis,
                               const std::array<std::int64_t, 3>& through);

/// The nodes of the plane across `normal` at that place, x fastest.
std::vector<std::int64_t> plane(const Grid& grid, std::size_t normal, std::int64_t at);

}  // namespace veriflex::observe
