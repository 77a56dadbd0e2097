/// What the cross-section of a lattice beam resists with, counted over its springs and angles.
///
/// Bending in the x-z plane: with curvature 1 every spring along z at x is strained by x, every straight
/// angle along z opens by the bond's length a, and every pair of a bond along x and one along z by a/2; in
/// shear each such pair opens by the shear angle.
#pragma once

#include "io/document.hpp"
#include "scene/plan.hpp"
#include "solid/elastic.hpp"

namespace veriflex::measures {

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

/// Shear stiffness over GA: sections do not stay plane when the axial force of each line of nodes has to
/// change along the beam. With L the graph Laplacian of the section's bonds (right angles) and D the second
/// differences along its lines (straight angles, a quarter as stiff), 1/kappa = N_x r0^2 x.(L + D'D/4)^-1
/// x/(x.x)^2: the energy of the shear that these changes ask for, against that of an even one. 1 up to three
/// nodes across, 5/6 for a thick strip  [1].
double shear_factor(const scene::SolidSpec& spec);

double spacing_of(const scene::SolidSpec& spec);

/// Bonds and angles of the case. Throws InputError where there are no angles.
solid::Material read_material_with_angles(const io::Table& top);

/// The same body with so many sections along z.
scene::SolidSpec with_sections(scene::SolidSpec spec, std::int64_t sections);

}  // namespace veriflex::measures
