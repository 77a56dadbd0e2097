#include <fmt/format.h>

#include <cmath>

#include "base/reduce.hpp"
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
using observe::Record;

struct ShearStudy {
  solid::Material material;
  solid::Block block;                // its width along x is set by `widths`
  std::vector<std::int64_t> widths;  // nodes along x, rising
};

// Force on the upper plate per area and shear, in linear response; with `plane` every node moves as the
// plates say.
double stiffness(const ShearStudy& study, std::int64_t width, bool plane) {
  solid::Block block = study.block;
  block.nodes[0] = width;
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

void run(const ShearStudy& study, Observations& seen, Progress& progress, engine::Cost& cost) {
  const std::size_t count = study.widths.size();
  const double r0 = study.block.spacing;
  const double modulus = 4.0 * study.material.angle_stiffness / (r0 * r0 * r0);
  std::vector<double> plane(count), free(count);
  for_all(2 * count, "blocks", progress, [&](std::size_t piece) {
    const std::size_t i = count - 1 - piece / 2;
    (piece % 2 == 0 ? free : plane)[i] = stiffness(study, study.widths[i], piece % 2 == 1) / modulus;
  });
  cost.finish("blocks");
  Record record{"shear",
                "Shear stiffness of a block between plates",
                {{"width", "n", "1", "nodes along the shear", {}},
                 {"free_sides", "G_eff/G", "1", "force on the plates per area and shear, G = 4 k_a/r0^3", {}},
                 {"plane", "", "1", "the same with every node moved as the plates say", {}},
                 {"plane_exact", "", "1", "1 - 1/n", {}}}};
  Record convergence{"convergence",
                     "Departure of the shear stiffness from G",
                     {{"spacing_over_width", "1/n", "1", "", {}},
                      {"error_free", "", "1", "free sides", {}},
                      {"error_plane", "", "1", "every node moved as the plates say", {}}}};
  double plane_error = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const auto n = static_cast<double>(study.widths[i]);
    record.append({n, free[i], plane[i], 1.0 - 1.0 / n});
    convergence.append({1.0 / n, std::abs(free[i] - 1.0), std::abs(plane[i] - 1.0)});
    plane_error = worse(plane_error, std::abs(plane[i] / (1.0 - 1.0 / n) - 1.0));
  }
  const auto coarse = static_cast<double>(study.widths[count - 2]);
  const auto fine = static_cast<double>(study.widths[count - 1]);
  seen.metrics = {
      {"plane_error", plane_error, "1", "plane sections: departure from 1 - 1/n, worst width"},
      {"order_free", std::log((1.0 - free[count - 2]) / (1.0 - free[count - 1])) / std::log(fine / coarse),
       "1", "free sides: order in 1/n of the departure from G, last two widths"},
      {"column_error", std::abs((fine * free[count - 1] - coarse * free[count - 2]) / (fine - coarse) - 1.0),
       "1", "departure from G of what the last columns of nodes add: Richardson's extrapolation of order 1"},
      {"lost_width", fine * (1.0 - free[count - 1]), "1",
       "free sides: by how many spacings the block is effectively narrower, widest block"}};
  seen.records = {record, convergence};
}

}  // namespace

engine::Study read_shear(const io::Table& top) {
  const bond::AnyLaw law = engine::read_law(top);
  const double rest_length = engine::read_derivation(top, law).rest_length;
  const scene::SolidSpec solid = engine::read_solid_at_rest(top, law, rest_length);
  const io::Table t = top.table("shear");
  const auto* block = std::get_if<solid::Block>(&solid.shape);
  if (block == nullptr || !(solid.angle_stiffness > 0.0)) {
    top.table("solid").fail("shape", "no bar with angles",
                            "without both there is no block that resists shear",
                            "Use shape = \"bar\" and [angle] stiffness");
  }
  ShearStudy study{{law, solid.angle_stiffness}, *block, t.integers("widths")};
  bool rising = study.widths.size() >= 2 && study.widths.front() >= 2 && study.widths.back() <= 10000;
  for (std::size_t i = 1; i < study.widths.size(); ++i) rising &= study.widths[i] > study.widths[i - 1];
  if (!rising) {
    t.fail("widths", "not two or more rising numbers from 2 to 10000", "an order needs two",
           "Give for example [16, 32, 64]");
  }
  solid::Block widest = *block;
  widest.nodes[0] = study.widths.back();
  return {
      .plan = engine::read_plan(top, {.law = law,
                                      .solid = scene::SolidSpec{widest, solid.angle_stiffness},
                                      .method = "linear response by sparse Cholesky; both end sections fixed",
                                      .by = {parts::Kind::Statics}}),
      .measures = {"plane_error", "order_free", "column_error", "lost_width", "shear.width",
                   "shear.free_sides", "shear.plane"},
      .run = [study](Observations& seen, Progress& progress, engine::Cost& cost) {
        run(study, seen, progress, cost);
      }};
}

}  // namespace veriflex::measures
