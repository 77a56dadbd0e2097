#include "observe/series.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <memory>

#include "base/mutant.hpp"
#include "base/reduce.hpp"
#include "fluid/links.hpp"
#include "scene/markers.hpp"

namespace veriflex::observe {

namespace {

using scene::MovingBody;
using scene::Simulation;

const std::string axes = "xyz";

void add_vector(std::vector<Column>& columns, const std::string& name, const std::string& dimension,
                const std::string& meaning) {
  for (const char axis : axes) columns.push_back({name + "_" + axis, "", dimension, meaning, {}});
}

void add(std::vector<double>& row, const Vec3& v) { row.insert(row.end(), {v[0], v[1], v[2]}); }

bool is_coupled(const scene::Scene& scene, const scene::Body& body) { return scene.fluid && body.coupling; }

/// Calls use(body) for each body that moves by its own forces.
template <class Use>
void for_elastic(const Simulation& simulation, Use use) {
  for (std::size_t i = 0; i < simulation.body_count(); ++i) {
    if (simulation.body(i).is_elastic()) use(simulation.body(i));
  }
}

Vec3 exchanged(const MovingBody& body) { return body.exchanged().colwise().sum().transpose(); }

double kinetic_energy(const fluid::Fluid& fluid) {
  double sum = 0.0;
  std::vector<fluid::Populations> h;
  in_parts(fluid.spec().grid, [&](std::span<const std::int64_t> nodes) {
    h.resize(nodes.size());
    fluid.populations(nodes, h);
    for (const fluid::Populations& node : h) {
      sum += 0.5 * fluid::momentum(node).squaredNorm() / (1.0 + fluid::density_deviation(node));
    }
  });
  return sum;
}

}  // namespace

Series energies(const scene::Scene& scene) {
  Series series;
  const std::string energy = "M L^2 T^-2";
  for (const scene::Body& body : scene.bodies) {
    if (body.motion) continue;
    series.columns.push_back({body.name + "_kinetic", "", energy, "of its nodes, velocity now", {}});
    series.columns.push_back({body.name + "_potential", "", energy, "elastic, and of the dead load", {}});
    series.columns.push_back({body.name + "_total", "", energy, "both together", {}});
  }
  if (scene.fluid) series.columns.push_back({"fluid_kinetic", "", energy, "rho u^2/2 of sum f c", {}});
  series.row = [](const Simulation& simulation) {
    std::vector<double> row;
    for_elastic(simulation, [&](const MovingBody& body) {
      const double kinetic = body.solid().kinetic_energy(), potential = body.solid().potential_energy();
      row.insert(row.end(), {kinetic, potential,
                             kinetic + (planted(Mutant::total_without_potential) ? 0.0 : potential)});
    });
    if (simulation.has_fluid()) row.push_back(kinetic_energy(simulation.fluid()));
    return row;
  };
  return series;
}

Series momentum(const scene::Scene& scene) {
  Series series;
  const std::string dimension = "M L T^-1";
  if (scene.fluid) add_vector(series.columns, "fluid", dimension, "sum f c of all nodes");
  for (const scene::Body& body : scene.bodies) {
    if (!body.motion) add_vector(series.columns, body.name, dimension, "m v of its nodes");
  }
  add_vector(series.columns, "total", dimension, "fluid and bodies");
  const std::array<bool, 3> walled =
      scene.fluid ? fluid::closed(*scene.fluid) : std::array<bool, 3>{false, false, false};
  const bool bounded = std::find(walled.begin(), walled.end(), true) != walled.end() ||
                       (scene.fluid && !scene.fluid->obstacle.empty());
  if (bounded) {
    add_vector(series.columns, "walls", dimension,
               "impulse of walls, openings and obstacle on the fluid since the start");
  }
  // The fluid's momentum at the start, and what entered it since from elsewhere than walls: six numbers, none
  // before the start.
  const auto balance = std::make_shared<std::vector<double>>();
  Vec3 per_step = Vec3::Zero();
  if (scene.fluid) {
    per_step = scene.fluid->body_force *
               static_cast<double>(scene.fluid->grid.count() - std::ssize(scene.fluid->obstacle));
  }
  if (bounded) {
    series.memory = balance;
    series.every_step = [balance, per_step](const Simulation& simulation) {
      if (balance->empty()) {
        add(*balance, simulation.fluid().totals().momentum);
        add(*balance, Vec3::Zero());
        return;
      }
      Eigen::Map<Vec3> entered(balance->data() + 3);
      entered += (planted(Mutant::walls_blamed_for_force) ? 0.0 : 1.0) * per_step;
      for (std::size_t i = 0; i < simulation.body_count(); ++i) entered -= exchanged(simulation.body(i));
    };
  }
  series.row = [balance, bounded](const Simulation& simulation) {
    std::vector<double> row;
    Vec3 total = Vec3::Zero();
    Vec3 fluid = Vec3::Zero();
    if (simulation.has_fluid()) {
      fluid = simulation.fluid().totals().momentum;
      add(row, fluid);
      total += fluid;
    }
    for_elastic(simulation, [&](const MovingBody& body) {
      add(row, body.momentum());
      total += body.momentum();
    });
    add(row, total);
    if (bounded) {
      const Eigen::Map<const Vec3> start(balance->data()), entered(balance->data() + 3);
      add(row, fluid - start - entered);
    }
    return row;
  };
  return series;
}

Series forces(const scene::Scene& scene) {
  Series series;
  series.from_start = false;
  const std::string force = "M L T^-2";
  const auto is_supported = [](const solid::Conditions& conditions) {
    return conditions.fixed.size() > 0 || conditions.drive;
  };
  bool supported = false;
  int met = 0;  // by the fluid
  for (const scene::Body& body : scene.bodies) {
    if (is_coupled(scene, body)) {
      add_vector(series.columns, body.name + "_fluid", force, "of the fluid on it");
      ++met;
    }
    if (body.motion || !is_supported(body.conditions)) continue;
    add_vector(series.columns, body.name + "_support", force, "of what holds or drives it");
    supported = true;
  }
  std::vector<fluid::Shore> shores;
  if (scene.fluid) shores = fluid::shores_of(*scene.fluid, fluid::inside_of(*scene.fluid));
  const bool obstacle = scene.fluid && !scene.fluid->obstacle.empty();
  if (obstacle) {
    add_vector(series.columns, "obstacle_fluid", force, "of the fluid on its obstacle");
    ++met;
  }
  const bool several = met > 1;
  if (several) add_vector(series.columns, "total_fluid", force, "of the fluid on all of these");
  // Momentum of each body before the last step, then after it.
  const auto moments = std::make_shared<std::vector<double>>();
  if (supported) {
    series.memory = moments;
    series.every_step = [moments](const Simulation& simulation) {
      const std::size_t count = 3 * simulation.body_count();
      moments->resize(2 * count);
      std::copy_n(moments->begin() + static_cast<std::ptrdiff_t>(count), count, moments->begin());
      moments->resize(count);
      for (std::size_t i = 0; i < simulation.body_count(); ++i) add(*moments, simulation.body(i).momentum());
    };
  }
  series.at_bodies = !obstacle;
  series.row = [moments, is_supported, obstacle, several, shores](const Simulation& simulation) {
    std::vector<double> row;
    Vec3 total = Vec3::Zero();
    const std::size_t bodies = simulation.body_count();
    for (std::size_t i = 0; i < bodies; ++i) {
      const MovingBody& body = simulation.body(i);
      Vec3 fluid = Vec3::Zero();
      if (body.is_coupled()) {
        fluid = exchanged(body);
        add(row, fluid);
        total += fluid;
      }
      if (!body.is_elastic() || !is_supported(body.solid().conditions())) continue;
      const Eigen::Map<const Vec3> before(moments->data() + 3 * i), now(before.data() + 3 * bodies);
      Vec3 support = now - before - (planted(Mutant::support_with_fluid) ? 0.0 : 1.0) * fluid;
      if (body.solid().conditions().load.size() > 0)
        support -= body.solid().conditions().load.colwise().sum().transpose();
      add(row, support);
    }
    if (obstacle) {
      const Vec3 on_obstacle = fluid::force_on_obstacle(simulation.fluid(), shores);
      add(row, on_obstacle);
      total += on_obstacle;
    }
    if (several) add(row, total);
    return row;
  };
  return series;
}

namespace {

/// Rows less their mean.
Positions about_centre(const Positions& X) { return X.rowwise() - X.colwise().mean(); }

/// Of a body whose nodes are of equal mass.
Vec3 angular_velocity(const MovingBody& body) {
  const Positions x = about_centre(body.positions());
  const Positions v = about_centre(body.solid().carried_velocity());
  Mat3 inertia = Mat3::Zero();  // over the mass of a node, as is the angular momentum
  Vec3 momentum = Vec3::Zero();
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    const Vec3 r = x.row(i);
    inertia += r.squaredNorm() * Mat3::Identity() -
               (planted(Mutant::inertia_of_points) ? -1.0 : 1.0) * r * r.transpose();
    momentum += r.cross(Vec3(v.row(i)));
  }
  return inertia.completeOrthogonalDecomposition().solve(momentum);
}

/// Whether the nodes of a body lie neither in a plane nor on a line.
bool is_solid(const scene::Body& body) {
  const Positions X = about_centre(body.network.rest);
  const Mat3 spread = X.transpose() * X;
  return spread.fullPivLu().isInvertible();
}

}  // namespace

Series rigid_motion(const scene::Scene& scene) {
  Series series;
  series.at_bodies = true;
  for (const scene::Body& body : scene.bodies) {
    if (body.motion) continue;
    add_vector(series.columns, body.name, "L", "centre of mass, not wrapped");
    add_vector(series.columns, body.name + "_velocity", "L T^-1", "of the centre of mass");
    add_vector(series.columns, body.name + "_omega", "T^-1", "angular velocity");
    add_vector(series.columns, body.name + "_turn", "1", "how far it has turned since the start");
  }
  const auto turned = std::make_shared<std::vector<double>>();  // empty before the start
  series.memory = turned;
  series.every_step = [turned](const Simulation& simulation) {
    const bool first = turned->empty();
    double* at = turned->data();
    for_elastic(simulation, [&](const MovingBody& body) {
      if (first) {
        add(*turned, Vec3::Zero());
      } else {
        Eigen::Map<Vec3> turn(at);
        turn += angular_velocity(body);
        at += planted(Mutant::turns_of_first_body) ? 0 : 3;
      }
    });
  };
  series.row = [turned](const Simulation& simulation) {
    std::vector<double> row;
    const double* at = turned->data();
    for_elastic(simulation, [&](const MovingBody& body) {
      add(row, body.positions().colwise().mean().transpose());
      add(row, body.solid().carried_velocity().colwise().mean().transpose());
      add(row, angular_velocity(body));
      row.insert(row.end(), at, at + 3);
      at += 3;
    });
    return row;
  };
  return series;
}

Series deformation(const scene::Scene& scene) {
  Series series;
  series.at_bodies = true;
  std::vector<bool> wanted;
  for (const scene::Body& body : scene.bodies) {
    wanted.push_back(!body.motion && is_solid(body));
    if (!wanted.back()) continue;
    series.columns.push_back({body.name + "_stretch_max", "", "1", "largest principal stretch", {}});
    series.columns.push_back({body.name + "_stretch_mid", "", "1", "principal stretch between", {}});
    series.columns.push_back({body.name + "_stretch_min", "", "1", "smallest principal stretch", {}});
    series.columns.push_back({body.name + "_taylor", "D", "1", "(max - min)/(max + min)", {}});
  }
  series.row = [wanted](const Simulation& simulation) {
    std::vector<double> row;
    for (std::size_t i = 0; i < simulation.body_count(); ++i) {
      if (!wanted[i]) continue;
      const MovingBody& body = simulation.body(i);
      const Positions X = about_centre(body.network().rest), u = about_centre(body.displacement());
      // u = X G^T for an affine one: least squares over the nodes.
      const Mat3 G = ((X.transpose() * X).ldlt().solve(X.transpose() * u)).transpose();
      const Vec3 stretch = (Mat3::Identity() + G).jacobiSvd().singularValues();
      row.insert(row.end(),
                 {stretch[0], stretch[1], stretch[2], (stretch[0] - stretch[2]) / (stretch[0] + stretch[2])});
    }
    return row;
  };
  return series;
}

Series tips(const scene::Scene& scene) {
  Series series;
  series.at_bodies = true;
  std::vector<std::vector<std::int32_t>> last_sections;
  for (const scene::Body& body : scene.bodies) {
    if (body.motion) continue;
    add_vector(series.columns, body.name, "L", "mean displacement of its last section");
    last_sections.push_back(scene::end_section(body.network.rest.col(body.axis), body.network.spacing, true));
  }
  series.row = [last_sections](const Simulation& simulation) {
    std::vector<double> row;
    std::size_t at = 0;
    for_elastic(simulation, [&](const MovingBody& body) {
      const Positions u = body.displacement();
      add(row, u(last_sections[at++], Eigen::all).colwise().mean().transpose());
    });
    return row;
  };
  return series;
}

Series strains(const scene::Scene& scene) {
  Series series;
  series.at_bodies = true;
  for (const scene::Body& body : scene.bodies) {
    if (body.motion) continue;
    series.columns.push_back(
        {body.name + "_min", "", "1", "smallest strain of a bond since the last row", {}});
    series.columns.push_back(
        {body.name + "_max", "", "1", "largest strain of a bond since the last row", {}});
  }
  // Smallest and largest by turns, until a bond is seen since the last row.
  std::vector<double> none;
  for (std::size_t i = 0; i < series.columns.size(); i += 2) none.insert(none.end(), {INFINITY, -INFINITY});
  const auto extremes = std::make_shared<std::vector<double>>(none);
  series.memory = extremes;
  series.every_step = [extremes](const Simulation& simulation) {
    double* at = extremes->data();
    for_elastic(simulation, [&](const MovingBody& body) {
      const Positions& u = body.solid().displacement();
      const solid::Network& network = body.network();
      double least = 0.0, greatest = 0.0;
      for (std::size_t b = 0; b < network.bonds.size(); ++b) {
        const Vec3 rest = network.vectors.row(static_cast<Eigen::Index>(b));
        const Vec3 stretched =
            rest + (u.row(network.bonds[b].second) - u.row(network.bonds[b].first)).transpose();
        const double strain = stretched.norm() / rest.norm() - 1.0;
        least = b == 0 ? strain : lesser(least, strain);
        greatest = b == 0 ? strain : worse(greatest, strain);
      }
      at[0] = lesser(at[0], least);
      at[1] = planted(Mutant::strain_of_last_step) ? greatest : worse(at[1], greatest);
      at += 2;
    });
  };
  series.row = [extremes, none](const Simulation&) {
    std::vector<double> row = none;
    row.swap(*extremes);
    return row;
  };
  return series;
}

Series slip(const scene::Scene& scene) {
  Series series;
  series.at_bodies = true;
  series.from_start = false;
  for (const scene::Body& body : scene.bodies) {
    if (!is_coupled(scene, body)) continue;
    series.columns.push_back(
        {body.name + "_rms", "", "L T^-1", "root mean square of |u_f - u_s| over coupled nodes", {}});
    series.columns.push_back({body.name + "_max", "", "L T^-1", "largest |u_f - u_s| of coupled nodes", {}});
  }
  series.row = [](const Simulation& simulation) {
    std::vector<double> row;
    for (std::size_t i = 0; i < simulation.body_count(); ++i) {
      const MovingBody& body = simulation.body(i);
      if (!body.is_coupled()) continue;
      const Eigen::VectorXd squares = body.slip().rowwise().squaredNorm();
      row.push_back(planted(Mutant::slip_without_root) ? squares.mean() : std::sqrt(squares.mean()));
      row.push_back(std::sqrt(largest(squares)));
    }
    return row;
  };
  return series;
}

}  // namespace veriflex::observe
