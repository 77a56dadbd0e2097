#include "observe/snapshot.hpp"

#include <algorithm>

#include "io/vtk.hpp"

namespace veriflex::observe {

namespace {

using io::VtkArray;

// Rows one after the other.
std::vector<double> by_row(const Positions& matrix) {
  std::vector<double> values;
  values.reserve(static_cast<std::size_t>(matrix.size()));
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    for (Eigen::Index j = 0; j < 3; ++j) values.push_back(matrix(i, j));
  }
  return values;
}

Positions velocity_of(const scene::MovingBody& body, double time) {
  if (body.is_elastic()) return body.solid().velocity();
  const Vec3 velocity = body.spec().motion->velocity_at(time);
  return velocity.transpose().replicate(body.network().node_count(), 1);
}

Positions fluid_force(const scene::MovingBody& body) {
  Positions force = Positions::Zero(body.network().node_count(), 3);
  const Positions& exchanged = body.exchanged();
  for (Eigen::Index i = 0; i < exchanged.rows(); ++i)
    force.row(body.coupled()[static_cast<std::size_t>(i)]) = exchanged.row(i);
  return force;
}

std::vector<VtkArray> on_bonds(const scene::MovingBody& body) {
  if (!body.is_elastic()) return {};
  const solid::Network& network = body.network();
  const Positions& u = body.solid().displacement();
  VtkArray strain{"strain", 1, {}}, tension{"tension", 1, {}};
  std::visit(
      [&](const auto& law) {
        for (std::size_t b = 0; b < network.bonds.size(); ++b) {
          const Vec3 rest = network.vectors.row(static_cast<Eigen::Index>(b));
          const Vec3 stretched =
              rest + (u.row(network.bonds[b].second) - u.row(network.bonds[b].first)).transpose();
          strain.values.push_back(stretched.norm() / rest.norm() - 1.0);
          tension.values.push_back(law.tension(stretched.norm()));
        }
      },
      body.spec().material.law);
  return {strain, tension};
}

}  // namespace

std::string snapshot_of_body(const scene::MovingBody& body, double time) {
  VtkArray numbers{"node", 1, {}};
  for (Eigen::Index i = 0; i < body.network().node_count(); ++i)
    numbers.values.push_back(static_cast<double>(i));
  std::vector<VtkArray> on_nodes{numbers,
                                 {"displacement", 3, by_row(body.displacement())},
                                 {"velocity", 3, by_row(velocity_of(body, time))}};
  if (body.is_coupled()) on_nodes.push_back({"fluid_force", 3, by_row(fluid_force(body))});
  std::vector<std::array<std::int64_t, 2>> lines;
  for (const solid::Bond& bond : body.network().bonds) lines.push_back({bond.first, bond.second});
  return io::vtk_lines(time, by_row(body.positions()), lines, on_nodes, on_bonds(body));
}

std::string snapshot_of_fluid(const fluid::Fluid& fluid, const std::array<std::int64_t, 3>& from,
                              const std::array<std::int64_t, 3>& to, const Fields& fields, double time) {
  const Grid& grid = fluid.spec().grid;
  const std::array<std::int64_t, 3> count{to[0] - from[0] + 1, to[1] - from[1] + 1, to[2] - from[2] + 1};
  VtkArray density{"density", 1, {}}, velocity{"velocity", 3, {}}, stress{"stress", 6, {}};
  std::vector<std::int64_t> row(static_cast<std::size_t>(count[0]));
  std::vector<fluid::Populations> populations(row.size());
  for (std::int64_t z = from[2]; z <= to[2]; ++z) {
    for (std::int64_t y = from[1]; y <= to[1]; ++y) {
      for (std::int64_t x = 0; x < count[0]; ++x)
        row[static_cast<std::size_t>(x)] = grid.index(from[0] + x, y, z);
      fluid.populations(row, populations);
      for (const fluid::Populations& h : populations) {
        const double rho = 1.0 + fluid::density_deviation(h);
        const Vec3 u = fluid::momentum(h) / rho;
        if (fields.density) density.values.push_back(rho);
        if (fields.velocity) velocity.values.insert(velocity.values.end(), {u[0], u[1], u[2]});
        if (!fields.stress) continue;
        const Mat3 s = fluid::viscous_stress(h, fluid.spec().relaxation_time);
        stress.values.insert(stress.values.end(), {s(0, 0), s(1, 1), s(2, 2), s(0, 1), s(1, 2), s(0, 2)});
      }
    }
  }
  std::vector<VtkArray> all;
  if (fields.density) all.push_back(std::move(density));
  if (fields.velocity) all.push_back(std::move(velocity));
  if (fields.stress) all.push_back(std::move(stress));
  return io::vtk_image(time, from, count, all);
}

}  // namespace veriflex::observe
