#include <fmt/format.h>

#include <cmath>
#include <functional>

#include "bond/derive.hpp"
#include "engine/read_scene.hpp"
#include "measures/drivers.hpp"
#include "measures/for_all.hpp"
#include "solid/modes.hpp"

// A block of n x m x h nodes between two rigid plates, the upper one moved along x. A section has n - 1 bonds
// along x for n nodes, so that with plane sections the plates feel G (1 - 1/n) per area n m r0^2; free side
// faces carry no shear and yield over about a height, which costs another fixed part of a width. Wide blocks
// therefore have G_eff = G (1 - c/n), and the force that one column of nodes adds is G alone.
namespace veriflex::measures {

namespace {

using observe::Observations;

struct ShearStudy {
  solid::Material material;
  solid::Block block;
};

Observations shear_observations() {
  return {.records = {},
          .metrics = {{"free_sides", {}, "1", "force on the plates per area and shear over G = 4 k_a/r0^3"},
                      {"free_error", {}, "1", "1 less that: it falls as 1/n, n the nodes along the shear"},
                      {"lost_width", {}, "1", "n times that: by how many spacings the block is narrower"},
                      {"plane", {}, "1", "the force with every node moved as the plates say"},
                      {"plane_error", {}, "1", "its relative departure from 1 - 1/n"}}};
}

// Force on the upper plate per area and shear, in linear response; with `plane` every node moves as the
// plates say.
double stiffness(const ShearStudy& study, bool plane) {
  const solid::Block& block = study.block;
  const solid::Network network = scene::build({block, study.material.angle_stiffness});
  const Eigen::Index nodes = network.node_count();
  const Eigen::Index per_section = block.nodes[0] * block.nodes[1];
  Positions u = Positions::Zero(nodes, 3);
  u.col(0) = network.rest.col(2);  // unit shear
  const Positions zero = Positions::Zero(nodes, 3);
  const auto hessian =
      solid::free_hessian(study.material, network, zero, solid::FixedDofs::Constant(nodes, 3, false));
  const auto force = [&](const Positions& displacement) -> Positions {
    const Eigen::VectorXd flat = displacement.reshaped();
    return Eigen::VectorXd(hessian * flat).reshaped(nodes, 3);
  };
  if (!plane) {
    solid::FixedDofs held = solid::FixedDofs::Constant(nodes, 3, false);
    held.topRows(per_section).setConstant(true);
    held.bottomRows(per_section).setConstant(true);
    u += solid::linear_response(study.material, network, held, -force(u));
  }
  return force(u).col(0).tail(per_section).sum() / block.section();
}

void run_shear(const ShearStudy& study, Observations& seen, Progress& progress, engine::Cost& cost) {
  const double r0 = study.block.spacing;
  const double modulus = 4.0 * study.material.angle_stiffness / (r0 * r0 * r0);
  const auto n = static_cast<double>(study.block.nodes[0]);
  double free = 0.0, plane = 0.0;
  for_all(2, "blocks", progress,
          [&](std::size_t piece) { (piece == 0 ? free : plane) = stiffness(study, piece == 1) / modulus; });
  cost.finish("blocks");
  seen.set("free_sides", free);
  seen.set("free_error", 1.0 - free);
  seen.set("lost_width", n * (1.0 - free));
  seen.set("plane", plane);
  seen.set("plane_error", std::abs(plane / (1.0 - 1.0 / n) - 1.0));
}

}  // namespace

engine::Study read_shear(const io::Table& top) {
  const bond::AnyLaw law = engine::read_law(top);
  const double rest_length = engine::read_derivation(top, law).rest_length;
  const scene::SolidSpec solid = engine::read_solid_at_rest(top, law, rest_length);
  const auto* block = std::get_if<solid::Block>(&solid.shape);
  if (block == nullptr || !(solid.angle_stiffness > 0.0)) {
    top.table("solid").fail("shape", "no bar with angles",
                            "without both there is no block that resists shear",
                            "Use shape = \"bar\" and [angle] stiffness");
  }
  if (block->nodes[0] < 2 || block->nodes[0] > 10000) {
    top.table("solid").fail("nodes", fmt::format("{} nodes along x", block->nodes[0]),
                            "a block with 2 to 10000 resists shear", "Give for example [64, 1, 7]");
  }
  const ShearStudy study{{law, solid.angle_stiffness}, *block};
  return {
      .plan = engine::read_plan(top, {.law = law,
                                      .solid = solid,
                                      .method = "linear response by sparse Cholesky; both end sections fixed",
                                      .by = {parts::Kind::Statics}}),
      .declares = shear_observations(),
      .run = std::bind_front(run_shear, study)};
}

}  // namespace veriflex::measures
