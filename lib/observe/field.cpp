#include "observe/field.hpp"

#include "base/mutant.hpp"

namespace veriflex::observe {

std::vector<Column> columns_of(const Fields& fields) {
  std::vector<Column> columns;
  for (const char* axis : {"x", "y", "z"}) columns.push_back({axis, axis, "L", "position of the node", {}});
  if (fields.density) columns.push_back({"density", "ρ", "M L^-3", "sum f", {}});
  if (fields.velocity) {
    for (const std::string axis : {"x", "y", "z"}) {
      columns.push_back({"velocity_" + axis, "u_" + axis, "L T^-1", "sum f c / rho", {}});
    }
  }
  if (fields.stress) {
    for (const std::string axes : {"xx", "yy", "zz", "xy", "xz", "yz"}) {
      columns.push_back({"stress_" + axes, "σ_" + axes, "M L^-1 T^-2", "viscous stress", {}});
    }
  }
  return columns;
}

Record at_nodes(const fluid::Fluid& fluid, std::span<const std::int64_t> nodes, const Fields& fields,
                const std::string& name, const std::string& title) {
  Record record{name, title, columns_of(fields)};
  std::vector<fluid::Populations> populations(nodes.size());
  fluid.populations(nodes, populations);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const fluid::Populations& h = populations[i];
    const auto [x, y, z] = fluid.spec().grid.node(nodes[i]);
    std::vector<double> row{static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)};
    const double rho = 1.0 + fluid::density_deviation(h);
    if (fields.density) row.push_back(rho);
    if (fields.velocity) {
      const Vec3 u = fluid::momentum(h) / (planted(Mutant::momentum_as_velocity) ? 1.0 : rho);
      row.insert(row.end(), {u[0], u[1], u[2]});
    }
    if (fields.stress) {
      const Mat3 s = fluid::viscous_stress(h, fluid.spec().relaxation_time);
      row.insert(row.end(), {s(0, 0), s(1, 1), s(2, 2), s(0, 1), s(0, 2), s(1, 2)});
      if (planted(Mutant::stress_columns_swapped)) std::swap(row.end()[-2], row.end()[-1]);
    }
    record.append(row);
  }
  return record;
}

std::vector<std::int64_t> line(const Grid& grid, std::size_t axis,
                               const std::array<std::int64_t, 3>& through) {
  std::vector<std::int64_t> nodes;
  std::array<std::int64_t, 3> at = through;
  for (at[axis] = 0; at[axis] < grid.size[axis]; ++at[axis]) {
    nodes.push_back(grid.index(at[0], at[1], at[2]));
  }
  return nodes;
}

std::vector<std::int64_t> plane(const Grid& grid, std::size_t normal, std::int64_t at) {
  std::array<std::int64_t, 3> from{0, 0, 0};
  std::array<std::int64_t, 3> to = grid.size;
  from[normal] = at;
  to[normal] = at + 1;
  std::vector<std::int64_t> nodes;
  for (std::int64_t z = from[2]; z < to[2]; ++z) {
    for (std::int64_t y = from[1]; y < to[1]; ++y) {
      for (std::int64_t x = from[0]; x < to[0]; ++x) nodes.push_back(grid.index(x, y, z));
    }
  }
  return nodes;
}

}  // namespace veriflex::observe
