#include "measures/solid/beam_section.hpp"

#include <Eigen/Cholesky>

#include "engine/read_scene.hpp"

namespace veriflex::measures {

BeamSection section_of(const solid::Material& material, const scene::SolidSpec& spec, double axial) {
  const solid::Network one = scene::build(with_sections(spec, 1));
  const double k = bond::stiffness(material.law, axial);
  const double k_a = material.angle_stiffness;
  const double mean = one.rest.col(0).mean();
  double along_x = 0.0;
  for (Eigen::Index b = 0; b < one.vectors.rows(); ++b) along_x += one.vectors(b, 0) != 0.0 ? 1.0 : 0.0;
  const auto* rod = std::get_if<solid::Rod>(&spec.shape);
  const auto nodes = static_cast<double>(one.node_count());
  return {.nodes = nodes,
          .spring_bending = k * axial * (one.rest.col(0).array() - mean).square().sum(),
          .straight_bending = k_a * axial * nodes,
          .right_bending = k_a * axial * along_x,
          .shear = 4.0 * k_a / axial * along_x,
          .radius = rod != nullptr ? rod->radius * rod->spacing : 0.0};
}

double shear_factor(const scene::SolidSpec& spec) {
  solid::Network one = scene::build(with_sections(spec, 1));
  const Eigen::VectorXd x = one.rest.col(0).array() - one.rest.col(0).mean();
  Eigen::MatrixXd resistance = Eigen::MatrixXd::Ones(x.size(), x.size());  // x sums to zero: no matter to it
  double along_x = 0.0;
  const auto ends = [&](std::int32_t bond) { return one.bonds[static_cast<std::size_t>(bond)]; };
  for (std::int32_t b = 0; b < static_cast<std::int32_t>(one.bonds.size()); ++b) {
    Eigen::VectorXd difference = Eigen::VectorXd::Zero(x.size());
    difference[ends(b).first] -= 1.0;
    difference[ends(b).second] += 1.0;
    resistance += difference * difference.transpose();
    along_x += one.vectors(b, 0) != 0.0 ? 1.0 : 0.0;
  }
  one.angles.clear();
  solid::add_angles(one);
  for (const solid::Angle& angle : one.angles) {
    if (!angle.straight) continue;
    Eigen::VectorXd difference = Eigen::VectorXd::Zero(x.size());
    for (const auto& [bond, sign] : {std::pair(angle.bond_a, angle.sign_a), {angle.bond_b, angle.sign_b}}) {
      difference[ends(bond).second] += sign;
      difference[ends(bond).first] -= sign;
    }
    resistance += 0.25 * difference * difference.transpose();
  }
  const double squares = x.squaredNorm();
  return squares * squares / (along_x * one.spacing * one.spacing * x.dot(resistance.ldlt().solve(x)));
}

double spacing_of(const scene::SolidSpec& spec) {
  return std::visit([](const auto& shape) { return shape.spacing; }, spec.shape);
}

solid::Material read_material_with_angles(const io::Table& top) {
  const solid::Material material{engine::read_law(top), engine::read_angle_stiffness(top)};
  if (!(material.angle_stiffness > 0.0)) {
    top.table("bond").fail("law", "a body of bonds alone", "without angles nothing resists shear",
                           "Add [angle] stiffness");
  }
  return material;
}

scene::SolidSpec with_sections(scene::SolidSpec spec, std::int64_t sections) {
  if (auto* rod = std::get_if<solid::Rod>(&spec.shape)) rod->sections = sections;
  if (auto* block = std::get_if<solid::Block>(&spec.shape)) block->nodes[2] = sections;
  return spec;
}

}  // namespace veriflex::measures
