#include "observe/snapshot.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "io/lammps_data.hpp"

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

io::VtkGrid picture_of_body(const scene::MovingBody& body, double time) {
  const solid::Network& network = body.network();
  io::VtkGrid grid{time, by_row(body.positions()), io::VtkCell::line, {}, {}, {}};
  VtkArray numbers{"node", 1, {}};
  for (Eigen::Index i = 0; i < network.node_count(); ++i) numbers.values.push_back(static_cast<double>(i));
  grid.on_points = {numbers,
                    {"displacement", 3, by_row(body.displacement())},
                    {"velocity", 3, by_row(velocity_of(body, time))}};
  if (body.is_coupled()) grid.on_points.push_back({"fluid_force", 3, by_row(fluid_force(body))});
  for (const solid::Bond& bond : network.bonds)
    grid.corners.insert(grid.corners.end(), {bond.first, bond.second});
  if (!network.bonds.empty()) {
    grid.on_cells = on_bonds(body);
    return grid;
  }
  grid.cell = io::VtkCell::vertex;
  for (Eigen::Index i = 0; i < network.node_count(); ++i) grid.corners.push_back(i);
  return grid;
}

io::VtkImage picture_of_fluid(const fluid::Fluid& fluid, const std::array<std::int64_t, 3>& from,
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
  io::VtkImage image{time, from, count, {}};
  if (fields.density) image.on_nodes.push_back(std::move(density));
  if (fields.velocity) image.on_nodes.push_back(std::move(velocity));
  if (fields.stress) image.on_nodes.push_back(std::move(stress));
  return image;
}

std::string lammps_data_of(const scene::MovingBody& body, double time) {
  const solid::Network& network = body.network();
  const Positions X = body.positions(), v = velocity_of(body, time);
  const auto id = [&](std::int32_t node) { return network.id_of(node) + (network.ids.empty() ? 1 : 0); };
  const auto xyz = [](const Positions& all, Eigen::Index i) {
    return std::array<double, 3>{all(i, 0), all(i, 1), all(i, 2)};
  };
  io::LammpsData data{};
  std::vector<std::array<double, 3>> velocities;
  for (Eigen::Index i = 0; i < network.node_count(); ++i) {
    data.atoms.push_back({id(static_cast<std::int32_t>(i)), 1, xyz(X, i)});
    velocities.push_back(xyz(v, i));
  }
  data.masses = {{1, body.spec().conditions.node_mass, 0}};
  for (const solid::Bond& bond : network.bonds)
    data.bonds.push_back({std::ssize(data.bonds) + 1, 1, {id(bond.first), id(bond.second)}, 0});
  data.bond_types = data.bonds.empty() ? 0 : 1;

  const auto is_straight = [](const solid::Angle& angle) { return angle.straight; };
  const auto straight = std::count_if(network.angles.begin(), network.angles.end(), is_straight);
  const bool has_right = straight < std::ssize(network.angles);
  data.angle_types = (has_right ? 1 : 0) + (straight > 0 ? 1 : 0);
  for (const solid::Angle& angle : network.angles) {
    const solid::Bond& a = network.bonds[static_cast<std::size_t>(angle.bond_a)];
    const solid::Bond& b = network.bonds[static_cast<std::size_t>(angle.bond_b)];
    const bool from_first = angle.sign_a > 0;  // the bond's vector points away from the apex
    data.angles.push_back({std::ssize(data.angles) + 1,
                           angle.straight ? data.angle_types : 1,
                           {id(from_first ? a.second : a.first), id(from_first ? a.first : a.second),
                            id(angle.sign_b > 0 ? b.second : b.first)},
                           0});
  }
  std::string title = fmt::format("{}, step {}", body.name(), time);
  if (straight > 0) title += fmt::format("; angles of type {} rest at 180 degrees", data.angle_types);
  if (has_right) title += "; angles of type 1 rest at 90 degrees";
  return io::write_lammps_data(data, velocities, title);
}

}  // namespace veriflex::observe
