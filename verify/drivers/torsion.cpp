#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "bond/derive.hpp"
#include "drivers/drivers.hpp"
#include "drivers/for_all.hpp"
#include "engine/exact_solid.hpp"
#include "engine/read_scene.hpp"
#include "solid/modes.hpp"

// A square bar of n x n nodes under end couples. In the middle, far from both ends, sections turn rigidly and
// warp, u = turn (-y z, x z, phi(x, y)), as Saint-Venant's do. On this lattice phi makes
//   2 k_a sum (phi' - y)^2 over bonds along x + 2 k_a sum (phi' + x)^2 over those along y      right angles
//   + 1/2 k_a sum (phi'' r0)^2 over the lines of the section                                 straight angles
// least per section. Without the last line its dual is Prandtl's stress function on the (n-1)^2 faces between
// the bonds, with the standard five-point Laplacian, and zero one spacing beyond the outer faces: the side is
// n r0, the same convention as for the area, and J is a finite double sum of sines. The straight angles
// stiffen the warping.
namespace veriflex::drivers {

namespace {

using observe::Observations;
using observe::Record;

struct TorsionStudy {
  solid::Material material;
  double spacing;                   // r0  [L]
  std::vector<std::int64_t> sides;  // n, rising
  std::int64_t slenderness;         // spacings along the bar over n
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
  solid::Held held = solid::Held::Constant(network.node_count(), 3, false);
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

Observations run(const TorsionStudy& study, Progress& progress, engine::Cost& cost) {
  const std::size_t count = study.sides.size();
  const double r0 = study.spacing;
  const double modulus = 4.0 * study.material.angle_stiffness / (r0 * r0 * r0);
  std::vector<double> whole(count), right(count);
  for_all(2 * count, "bars", progress, [&](std::size_t piece) {
    const std::size_t i = count - 1 - piece / 2;  // the thickest first
    (piece % 2 == 0 ? whole : right)[i] = stiffness(study, study.sides[i], piece % 2 == 0);
  });
  cost.finish("bars");
  const double continuum = engine::torsion_constant_of_square();
  Record record{"torsion",
                "Torsion constant of the square bar",
                {{"side", "n", "1", "nodes along each side", {}},
                 {"constant", "J/(n r0)^4", "1", "of the lattice, with G = 4 k_a/r0^3", {}},
                 {"right_angles", "", "1", "the same without straight angles", {}},
                 {"right_angles_exact", "", "1", "by the double sine series of the five-point Laplacian", {}},
                 {"saint_venant", "", "1", "by the series for a square", {}}}};
  Record convergence{"convergence",
                     "Departure of the torsion constant from Saint-Venant's",
                     {{"spacing_over_side", "1/n", "1", "", {}},
                      {"error_lattice", "", "1", "of the lattice", {}},
                      {"error_right_angles", "", "1", "without straight angles", {}}}};
  std::vector<double> constant(count);
  double worst = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const double n = static_cast<double>(study.sides[i]);
    const double unit = modulus * std::pow(n * r0, 4);
    const double exact = right_angle_constant(study.sides[i]) / std::pow(n, 4);
    constant[i] = whole[i] / unit;
    record.append({n, constant[i], right[i] / unit, exact, continuum});
    convergence.append(
        {1.0 / n, std::abs(constant[i] / continuum - 1.0), std::abs(right[i] / unit / continuum - 1.0)});
    worst = std::max(worst, std::abs(right[i] / unit / exact - 1.0));
  }
  const double ratio =
      static_cast<double>(study.sides[count - 1]) / static_cast<double>(study.sides[count - 2]);
  const auto order = [&](const char* column) {
    const std::vector<double>& error = convergence.find(column)->values;
    return std::log(error[count - 2] / error[count - 1]) / std::log(ratio);
  };
  const double limit =
      constant[count - 1] + (constant[count - 1] - constant[count - 2]) / (ratio * ratio - 1.0);
  Observations seen;
  seen.metrics = {
      {"right_angle_error", worst, "1",
       "bar without straight angles: departure from its exact double sum, worst of the sides"},
      {"lattice_error", std::abs(constant.back() / continuum - 1.0), "1",
       "departure from Saint-Venant's constant, thickest bar"},
      {"order_lattice", order("error_lattice"), "1", "order in 1/n of that departure, last two sides"},
      {"order_right_angles", order("error_right_angles"), "1", "the same without straight angles"},
      {"extrapolated_error", std::abs(limit / continuum - 1.0), "1",
       "departure after Richardson's extrapolation of order 2"},
      {"straight_angle_part", whole.back() / right.back() - 1.0, "1",
       "what straight angles add to the stiffness of the thickest bar"}};
  seen.records = {record, convergence};
  return seen;
}

}  // namespace

engine::Study read_torsion(const io::Section& top) {
  const bond::AnyLaw law = engine::read_law(top);
  const double rest_length = engine::read_derivation(top, law).rest_length;
  const io::Section t = top.table("torsion");
  const TorsionStudy study{.material = {law, engine::read_angle_stiffness(top)},
                           .spacing = rest_length,
                           .sides = t.integers("sides"),
                           .slenderness = t.integer("slenderness", 2, 100)};
  if (!(study.material.angle_stiffness > 0.0)) {
    top.table("bond").fail("law", "a bar of bonds alone", "without angles it has no shear stiffness",
                           "Add [angle] stiffness");
  }
  if (study.sides.size() < 2 || study.sides.front() < 2 || study.sides.back() > 200) {
    t.fail("sides", "fewer than two sides, or one not between 2 and 200", "an order needs two",
           "Give for example [4, 6, 8]");
  }
  for (std::size_t i = 1; i < study.sides.size(); ++i) {
    if (study.sides[i] <= study.sides[i - 1])
      t.fail("sides", "sides do not rise", "the order is taken between neighbours", "Sort them");
  }
  const std::int64_t n = study.sides.back();
  return {.plan = engine::read_plan(
              top, {.law = law,
                    .solid = scene::SolidSpec{solid::Block{{n, n, study.slenderness * n + 1}, rest_length},
                                              study.material.angle_stiffness},
                    .method = "linear response by sparse Cholesky; half a bar under end couples",
                    .moves = false}),
          .measures = {"right_angle_error", "lattice_error", "order_lattice", "order_right_angles",
                       "extrapolated_error", "straight_angle_part"},
          .run = [study](Progress& progress, engine::Cost& cost) { return run(study, progress, cost); }};
}

}  // namespace veriflex::drivers
