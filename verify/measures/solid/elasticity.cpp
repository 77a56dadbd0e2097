#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/root.hpp"
#include "bond/derive.hpp"
#include "engine/read_scene.hpp"
#include "measures/drivers.hpp"
#include "solid/elastic.hpp"

namespace veriflex::measures {

namespace {

using observe::Observations;

struct ElasticityStudy {
  solid::Material material;
  double spacing;              // [L]
  double width;                // of differences by the strain, inside what is smooth around rest  [1]
  std::vector<double> shears;  // engineering shear strains of the simple-shear curve  [1]
};

Observations elasticity_observations(const ElasticityStudy& study) {
  Observations all;
  all.metrics = {{"c11", {}, "M L^-1 T^-2", "stress along a stretched axis over its strain"},
                 {"c12", {}, "M L^-1 T^-2", "stress across a stretched axis over its strain"},
                 {"c44", {}, "M L^-1 T^-2", "shear stress over engineering shear strain"},
                 {"c44_simple", {}, "M L^-1 T^-2", "the same by simple shear"},
                 {"anisotropy", {}, "1", "2 C44/(C11 - C12): 1 for an isotropic solid (Zener)"},
                 {"poisson_in_shear", {}, "1", "E/(2 G) - 1 with E = C11, G = C44"}};
  if (study.shears.empty()) return all;
  all.records = {{"simple_shear",
                  "Shear stress of the lattice in simple shear",
                  {{"shear", "", "1", "engineering shear strain", {}},
                   {"shear_stress", "", "M L^-1 T^-2", "along the sheared axis", {}},
                   {"secant_ratio", "", "1", "shear stress / (C44 shear)", {}}}}};
  return all;
}

// One node of the infinite lattice: its three bonds along +x, +y, +z and its fifteen angles. A homogeneous
// deformation F of the lattice turns each bond vector into F times itself.
solid::Network unit_cell(double spacing, bool angles) {
  solid::Network cell;
  cell.spacing = spacing;
  cell.rest = Positions::Zero(1, 3);
  cell.bonds.assign(3, {0, 0});
  cell.vectors = spacing * Mat3::Identity();
  if (!angles) return cell;
  for (std::int32_t p = 0; p < 3; ++p) {
    cell.angles.push_back({p, p, 1, -1, true});
    for (std::int32_t q = p + 1; q < 3; ++q) {
      for (const int a : {1, -1}) {
        for (const int b : {1, -1}) {
          cell.angles.push_back({p, q, static_cast<std::int8_t>(a), static_cast<std::int8_t>(b), false});
        }
      }
    }
  }
  return cell;
}

// First Piola-Kirchhoff stress of the lattice under the deformation gradient F  [M L^-1 T^-2].
Mat3 stress(const ElasticityStudy& study, const solid::Network& cell, const Mat3& deformation) {
  solid::Workspace work;
  work.d = cell.vectors * deformation.transpose();
  Positions unused;
  solid::visit(study.material, [&](const auto& law, const auto& angle) {
    if (!solid::gradient(law, angle, cell, work, unused))
      throw NumericalFailure("a degenerate angle in a strained cell");
    return 0;
  });
  return work.g.transpose() * cell.vectors / (cell.spacing * cell.spacing * cell.spacing);
}

// Derivative at rest of the stress component (i, j) by the strain that `strained` builds.
template <class Strained>
double modulus(const ElasticityStudy& study, const solid::Network& cell, int i, int j, Strained strained) {
  return central_derivative([&](double e) { return stress(study, cell, strained(e))(i, j); }, 0.0,
                            study.width)
      .value;
}

void run_elasticity(const ElasticityStudy& study, Observations& seen, engine::Cost& cost) {
  const solid::Network cell = unit_cell(study.spacing, study.material.angle_stiffness != 0.0);
  const auto stretch = [](double e) { return Mat3(Vec3(1.0 + e, 1.0, 1.0).asDiagonal()); };
  const auto pure_shear = [](double e) {
    Mat3 f = Mat3::Identity();
    f(0, 1) = f(1, 0) = 0.5 * e;
    return f;
  };
  const auto simple_shear = [](double e) {
    Mat3 f = Mat3::Identity();
    f(0, 1) = e;
    return f;
  };
  const double c11 = modulus(study, cell, 0, 0, stretch);
  const double c12 = modulus(study, cell, 1, 1, stretch);
  const double c44 = modulus(study, cell, 0, 1, pure_shear);
  seen.set("c11", c11);
  seen.set("c12", c12);
  seen.set("c44", c44);
  seen.set("c44_simple", modulus(study, cell, 0, 1, simple_shear));
  seen.set("anisotropy", 2.0 * c44 / (c11 - c12));
  seen.set("poisson_in_shear", c11 / (2.0 * c44) - 1.0);
  cost.finish("moduli");
  for (const double shear : study.shears) {
    const double s = stress(study, cell, simple_shear(shear))(0, 1);
    seen.open("simple_shear").append({shear, s, s / (c44 * shear)});
  }
  cost.finish("shear");
}

}  // namespace

engine::Study read_elasticity(const io::Table& top) {
  const bond::AnyLaw law = engine::read_law(top);
  const bond::Derivation derivation = engine::read_derivation(top, law);
  const double rest_length = derivation.rest_length;
  ElasticityStudy study{.material = {law, engine::read_angle_stiffness(top)},
                        .spacing = rest_length,
                        .width = std::min(1e-4, 0.01 * derivation.smooth_radius / rest_length),
                        .shears = {}};
  if (!(study.width > 1e-10)) {
    top.table("bond").fail("law", "the law changes too close to its rest length",
                           fmt::format("only {:.3g} of it are smooth, too little for differences",
                                       derivation.smooth_radius / rest_length),
                           "Look at its limits and its cut-off");
  }
  if (top.has("elasticity")) {
    const io::Table t = top.table("elasticity");
    study.shears = t.numbers("shears");
    for (const double shear : study.shears) {
      if (shear == 0.0 || !bond::domain(law).contains(rest_length * std::hypot(1.0, shear))) {
        t.fail("shears", fmt::format("'shears' holds {}", shear),
               "it must be nonzero and keep bonds in the law's domain", "Leave it out");
      }
    }
  }
  return {.plan = engine::read_plan(top, {.law = law}),
          .declares = elasticity_observations(study),
          .run = [study](Observations& seen, Progress&, engine::Cost& cost) {
            run_elasticity(study, seen, cost);
          }};
}

}  // namespace veriflex::measures
