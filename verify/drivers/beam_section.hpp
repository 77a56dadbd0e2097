/// What the cross-section of a lattice beam resists with, counted over its springs and angles.
///
/// Bending in the x-z plane: with curvature 1 every spring along z at x is strained by x, every straight
/// angle along z opens by the bond's length a, and every pair of a bond along x and one along z by a/2; in
/// shear each such pair opens by the shear angle.
#pragma once

#include "scene/plan.hpp"
#include "solid/elastic.hpp"

namespace veriflex::drivers {

struct BeamSection {
  double nodes;
  double spring_bending;    // k a sum x^2             [M L^3 T^-2]
  double straight_bending;  // k_a a per node
  double right_bending;     // k_a a per bond along x
  double shear;             // GA = 4 k_a/a per bond along x, sections staying plane  [M L T^-2]
  double radius;            // of the rod; 0 for other shapes  [L]

  double bending() const { return spring_bending + straight_bending + right_bending; }
};

/// The section of a body whose bonds along z have the length `axial` [L], all others their rest length.
BeamSection section_of(const solid::Material& material, const scene::SolidSpec& spec, double axial);

double spacing_of(const scene::SolidSpec& spec);

/// The same body with so many sections along z.
scene::SolidSpec with_sections(scene::SolidSpec spec, std::int64_t sections);

}  // namespace veriflex::drivers
