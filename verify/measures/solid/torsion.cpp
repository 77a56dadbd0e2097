#include <fmt/format.h>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>

#include "analytic/exact_solid.hpp"
#include "bond/derive.hpp"
#include "engine/read_scene.hpp"
#include "measures/drivers.hpp"
#include "measures/for_all.hpp"
#include "measures/solid/beam_section.hpp"
#include "solid/modes.hpp"

// A square bar of n x n nodes under end couples. In the middle, far from both ends, sections turn rigidly and
// warp, u = turn (-y z, x z, phi(x, y)), as Saint-Venant's do. On this lattice phi makes
//   2 k_a sum (phi' - y)^2 over bonds along x + 2 k_a sum (phi' + x)^2 over those along y      right angles
//   + 1/2 k_a sum (phi'' r0)^2 over the lines of the section                                 straight angles
// least per section. Without the last line its dual is Prandtl's stress function on the (n-1)^2 faces between
// the bonds, with the standard five-point Laplacian, and zero one spacing beyond the outer faces: the side is
// n r0, the same convention as for the area, and J is a finite double sum of sines. The straight angles
// stiffen the warping.
namespace veriflex::measures {

namespace {

using observe::Observations;

struct TorsionStudy {
  solid::Material material;
  double spacing;                           // r0  [L]
  std::int64_t side;                        // n
  std::optional<std::int64_t> slenderness;  // spacings along the bar over n; without it no bar is built
};

Observations torsion_observations(const TorsionStudy& study) {
  Observations all;
  all.metrics = {
      {"section", {}, "1", "J/(n r0)^4 by the warping of one section"},
      {"section_right_angles", {}, "1", "the same without straight angles, by the double sine series"},
      {"saint_venant", {}, "1", "J/(n r0)^4 by the series for a square"},
      {"over_saint_venant", {}, "1", "the section's over that"},
      {"section_error", {}, "1", "departure of the section from Saint-Venant's"},
      {"section_error_right_angles", {}, "1", "the same without straight angles"}};
  if (study.slenderness) {
    all.metrics.insert(
        all.metrics.end(),
        {{"bar", {}, "1", "J/(n r0)^4 of the bar, with G = 4 k_a/r0^3"},
         {"bar_right_angles", {}, "1", "of the bar without straight angles"},
         {"bar_error", {}, "1", "departure of the bar from the warping of its section"},
         {"series_error", {}, "1", "departure of the bar without straight angles from the sine series"}});
  }
  return all;
}

// J of the lattice with right angles alone, over r0^4: 2 sum of Prandtl's function, by its double sine
// series.
double right_angle_constant(std::int64_t n) {
  const auto size = static_cast<double>(n);
  double total = 0.0;
  for (std::int64_t i = 1; i < n; i += 2) {
    for (std::int64_t j = 1; j < n; j += 2) {
      const double a = 0.5 * std::numbers::pi * static_cast<double>(i) / size;
      const double b = 0.5 * std::numbers::pi * static_cast<double>(j) / size;
      const double sums = 1.0 / (std::tan(a) * std::tan(b));
      total += sums * sums / (std::sin(a) * std::sin(a) + std::sin(b) * std::sin(b));
    }
  }
  return 4.0 * total / (size * size);
}

// J of the lattice over r0^4 by the warping of one section: the least value of the sums above, over 2 k_a.
double section_constant(std::int64_t n) {
  // One row per right or straight angle term, least squares |rows phi - wanted|^2; the first node does not
  // move.
  std::vector<Eigen::Triplet<double>> entries;
  std::vector<double> wanted;
  const auto add = [&](std::int64_t node, double weight) {
    if (node != 0) entries.emplace_back(static_cast<int>(wanted.size()), static_cast<int>(node - 1), weight);
  };
  for (const std::int64_t along : {std::int64_t{1}, n}) {
    for (std::int64_t line = 0; line < n; ++line) {
      const double offset = static_cast<double>(line) - 0.5 * static_cast<double>(n - 1);
      const std::int64_t first = line * (along == 1 ? n : 1);
      for (std::int64_t i = 0; i + 1 < n; ++i) {
        add(first + (i + 1) * along, 1.0);
        add(first + i * along, -1.0);
        wanted.push_back(along == 1 ? offset : -offset);
      }
      for (std::int64_t i = 1; i + 1 < n; ++i) {
        add(first + (i - 1) * along, 0.5);
        add(first + i * along, -1.0);
        add(first + (i + 1) * along, 0.5);
        wanted.push_back(0.0);
      }
    }
  }
  Eigen::SparseMatrix<double> rows(static_cast<Eigen::Index>(wanted.size()), n * n - 1);
  rows.setFromTriplets(entries.begin(), entries.end());
  const Eigen::Map<const Eigen::VectorXd> right(wanted.data(), static_cast<Eigen::Index>(wanted.size()));
  const Eigen::SparseMatrix<double> normal = rows.transpose() * rows;
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(normal);
  const Eigen::VectorXd phi = factor.solve(rows.transpose() * right);
  return (rows * phi - right).squaredNorm();
}

// Turn of each section: the rigid rotation nearest to its displacement.
std::vector<double> turns(const solid::Network& network, const Positions& u, Eigen::Index per_section) {
  std::vector<double> all;
  for (Eigen::Index first = 0; first < network.node_count(); first += per_section) {
    Eigen::VectorXd x = network.rest.col(0).segment(first, per_section);
    Eigen::VectorXd y = network.rest.col(1).segment(first, per_section);
    x.array() -= x.mean();
    y.array() -= y.mean();
    all.push_back(
        (x.dot(u.col(1).segment(first, per_section)) - y.dot(u.col(0).segment(first, per_section))) /
        (x.squaredNorm() + y.squaredNorm()));
  }
  return all;
}

// Torsional stiffness, couple over twist per length, in the middle of the bar  [M L^3 T^-2]. Half of the bar
// is built: its first section is a plane of antisymmetry of the twist, where nothing moves across the axis
// and the corners not along it. The couple acts on the last section by forces that grow with the distance
// from the axis.
double stiffness(const TorsionStudy& study, bool with_straight) {
  const std::int64_t n = study.side, length = *study.slenderness * n;
  solid::Network network =
      scene::build({solid::Block{{n, n, length + 1}, study.spacing}, study.material.angle_stiffness});
  if (!with_straight) std::erase_if(network.angles, [](const solid::Angle& angle) { return angle.straight; });
  const Eigen::Index per_section = n * n;
  solid::FixedDofs held = solid::FixedDofs::Constant(network.node_count(), 3, false);
  held.topRows(per_section).leftCols(2).setConstant(true);
  for (const Eigen::Index corner : {Eigen::Index{0}, n - 1, per_section - n, per_section - 1}) {
    held(corner, 2) = true;
  }
  Positions load = Positions::Zero(network.node_count(), 3);
  const double centre = 0.5 * static_cast<double>(n - 1) * study.spacing;
  load.col(0).tail(per_section) = centre - network.rest.col(1).tail(per_section).array();
  load.col(1).tail(per_section) = network.rest.col(0).tail(per_section).array() - centre;
  const double couple = load.squaredNorm();
  const Positions u = solid::linear_response(study.material, network, held, load);
  const std::vector<double> turn = turns(network, u, per_section);
  const auto from = static_cast<std::size_t>(length / 3);
  const auto to = static_cast<std::size_t>(length / 2);
  return couple * static_cast<double>(to - from) * study.spacing / (turn[to] - turn[from]);
}

void run_torsion(const TorsionStudy& study, Observations& seen, Progress& progress, engine::Cost& cost) {
  const auto n = static_cast<double>(study.side);
  const double continuum = analytic::torsion_constant_of_square();
  const double section = section_constant(study.side) / std::pow(n, 4);
  const double series = right_angle_constant(study.side) / std::pow(n, 4);
  seen.set("section", section);
  seen.set("section_right_angles", series);
  seen.set("saint_venant", continuum);
  seen.set("over_saint_venant", section / continuum);
  seen.set("section_error", std::abs(section / continuum - 1.0));
  seen.set("section_error_right_angles", std::abs(series / continuum - 1.0));
  cost.finish("section");
  if (!study.slenderness) return;
  const double r0 = study.spacing;
  const double unit = 4.0 * study.material.angle_stiffness / (r0 * r0 * r0) * std::pow(n * r0, 4);
  double whole = 0.0, right = 0.0;
  for_all(2, "bars", progress,
          [&](std::size_t i) { (i == 0 ? whole : right) = stiffness(study, i == 0) / unit; });
  cost.finish("bars");
  seen.set("bar", whole);
  seen.set("bar_right_angles", right);
  seen.set("bar_error", std::abs(whole / section - 1.0));
  seen.set("series_error", std::abs(right / series - 1.0));
}

}  // namespace

engine::Study read_torsion(const io::Table& top) {
  const solid::Material material = read_material_with_angles(top);
  const io::Table t = top.table("torsion");
  TorsionStudy study{.material = material,
                     .spacing = engine::read_derivation(top, material.law).rest_length,
                     .side = t.integer("side", 2, 1000),
                     .slenderness = {}};
  if (t.has("slenderness")) study.slenderness = t.integer("slenderness", 2, 100);
  scene::Outline scene{.law = material.law, .method = "warping of one section by sparse Cholesky"};
  if (study.slenderness) {
    scene.solid = scene::SolidSpec{
        solid::Block{{study.side, study.side, *study.slenderness * study.side + 1}, study.spacing},
        material.angle_stiffness};
    scene.method = "linear response by sparse Cholesky; half a bar under end couples";
    scene.by = {parts::Kind::Statics};
  }
  scene::Plan plan;
  try {
    plan = scene::plan(scene);
  } catch (const BadParameter& bad) {
    t.fail("side", bad.problem, bad.why, "Use a thinner bar, or a smaller slenderness");
  }
  return {.plan = plan, .declares = torsion_observations(study), .run = std::bind_front(run_torsion, study)};
}

}  // namespace veriflex::measures
