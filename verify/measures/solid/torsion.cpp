#include <fmt/format.h>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <cmath>
#include <numbers>

#include "analytic/exact_solid.hpp"
#include "base/reduce.hpp"
#include "bond/derive.hpp"
#include "engine/read_scene.hpp"
#include "measures/drivers.hpp"
#include "measures/for_all.hpp"
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
using observe::Record;

struct TorsionStudy {
  solid::Material material;
  double spacing;                      // r0  [L]
  std::vector<std::int64_t> sides;     // n of the bars, rising
  std::vector<std::int64_t> sections;  // n of the sections without a bar, rising
  std::int64_t slenderness;            // spacings along the bar over n
};

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
double stiffness(const TorsionStudy& study, std::int64_t n, bool with_straight) {
  const std::int64_t length = study.slenderness * n;
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

void run(const TorsionStudy& study, Observations& seen, Progress& progress, engine::Cost& cost) {
  const std::size_t count = study.sides.size();
  const double r0 = study.spacing;
  const double modulus = 4.0 * study.material.angle_stiffness / (r0 * r0 * r0);
  std::vector<double> whole(count), right(count);
  for_all(2 * count, "bars", progress, [&](std::size_t piece) {
    const std::size_t i = count - 1 - piece / 2;  // the thickest first
    (piece % 2 == 0 ? whole : right)[i] = stiffness(study, study.sides[i], piece % 2 == 0);
  });
  cost.finish("bars");
  const double continuum = analytic::torsion_constant_of_square();
  Record record{"torsion",
                "Torsion constant of square bars",
                {{"side", "n", "1", "nodes along each side", {}},
                 {"bar", "J/(n r0)^4", "1", "of the bar, with G = 4 k_a/r0^3", {}},
                 {"section", "", "1", "by the warping of one section", {}},
                 {"bar_right_angles", "", "1", "of the bar without straight angles", {}},
                 {"sine_series", "", "1", "without straight angles, by the double sine series", {}},
                 {"saint_venant", "", "1", "by the series for a square", {}}}};
  double bar_error = 0.0;
  double series_error = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const double n = static_cast<double>(study.sides[i]);
    const double unit = modulus * std::pow(n * r0, 4);
    const double section = section_constant(study.sides[i]) / std::pow(n, 4);
    const double series = right_angle_constant(study.sides[i]) / std::pow(n, 4);
    record.append({n, whole[i] / unit, section, right[i] / unit, series, continuum});
    bar_error = worse(bar_error, std::abs(whole[i] / unit / section - 1.0));
    series_error = worse(series_error, std::abs(right[i] / unit / series - 1.0));
  }
  Record convergence{"convergence",
                     "Departure of the torsion constant from Saint-Venant's",
                     {{"spacing_over_side", "1/n", "1", "", {}},
                      {"error_lattice", "", "1", "of the lattice", {}},
                      {"error_right_angles", "", "1", "without straight angles", {}}}};
  std::vector<double> ratio;  // of the sections' J over Saint-Venant's
  for (const std::int64_t side : study.sections) {
    const double unit = std::pow(static_cast<double>(side), 4) * continuum;
    ratio.push_back(section_constant(side) / unit);
    convergence.append({1.0 / static_cast<double>(side), std::abs(ratio.back() - 1.0),
                        std::abs(right_angle_constant(side) / unit - 1.0)});
  }
  cost.finish("sections");
  const std::size_t last = study.sections.size() - 1;
  const double finer =
      static_cast<double>(study.sections[last]) / static_cast<double>(study.sections[last - 1]);
  const auto order = [&](const char* column) {
    const std::vector<double>& error = convergence.find(column)->values;
    return std::log(error[last - 1] / error[last]) / std::log(finer);
  };
  const double limit = ratio[last] + (ratio[last] - ratio[last - 1]) / (finer * finer - 1.0);
  seen.metrics = {
      {"bar_error", bar_error, "1", "bars against the warping of their section, worst of the sides"},
      {"series_error", series_error, "1",
       "bars without straight angles against the double sine series, worst of the sides"},
      {"thickest_bar_error", std::abs(record.find("bar")->values.back() / continuum - 1.0), "1",
       "departure of the thickest bar from Saint-Venant's constant"},
      {"order_lattice", order("error_lattice"), "1", "order in 1/n of the sections' departure, last two"},
      {"order_right_angles", order("error_right_angles"), "1", "the same without straight angles"},
      {"extrapolated_error", std::abs(limit - 1.0), "1",
       "departure of the sections after Richardson's extrapolation of order 2"}};
  seen.records = {record, convergence};
}

}  // namespace

engine::Study read_torsion(const io::Table& top) {
  const bond::AnyLaw law = engine::read_law(top);
  const double rest_length = engine::read_derivation(top, law).rest_length;
  const io::Table t = top.table("torsion");
  const TorsionStudy study{.material = {law, engine::read_angle_stiffness(top)},
                           .spacing = rest_length,
                           .sides = t.integers("sides"),
                           .sections = t.integers("sections"),
                           .slenderness = t.integer("slenderness", 2, 100)};
  if (!(study.material.angle_stiffness > 0.0)) {
    top.table("bond").fail("law", "a bar of bonds alone", "without angles it has no shear stiffness",
                           "Add [angle] stiffness");
  }
  const auto check_rising = [&](const char* key, const std::vector<std::int64_t>& sides, std::int64_t max) {
    bool rising = sides.size() >= 2 && sides.front() >= 2 && sides.back() <= max;
    for (std::size_t i = 1; i < sides.size(); ++i) rising &= sides[i] > sides[i - 1];
    if (!rising) {
      t.fail(key, fmt::format("'{}' are not two or more rising numbers from 2 to {}", key, max),
             "each is the number of nodes along a side", "Give for example [3, 4, 6]");
    }
  };
  check_rising("sides", study.sides, 60);
  check_rising("sections", study.sections, 1000);
  const std::int64_t n = study.sides.back();
  scene::Plan plan;
  try {
    plan =
        scene::plan({.law = law,
                     .solid = scene::SolidSpec{solid::Block{{n, n, study.slenderness * n + 1}, rest_length},
                                               study.material.angle_stiffness},
                     .method = "linear response by sparse Cholesky; half a bar under end couples",
                     .by = {parts::Kind::Statics}});
  } catch (const BadParameter& bad) {
    t.fail("sides", bad.problem, bad.why, "Use thinner bars, or a smaller slenderness");
  }
  return {
      .plan = plan,
      .measures = {"bar_error", "series_error", "thickest_bar_error", "order_lattice", "order_right_angles",
                   "extrapolated_error", "torsion.side", "torsion.bar", "torsion.section"},
      .run = [study](Observations& seen, Progress& progress, engine::Cost& cost) {
        run(study, seen, progress, cost);
      }};
}

}  // namespace veriflex::measures
