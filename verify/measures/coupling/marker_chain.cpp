#include "measures/coupling/marker_chain.hpp"

#include <algorithm>
#include <cmath>

#include "engine/read_scene.hpp"
#include "scene/markers.hpp"

namespace veriflex::measures {

scene::Body read_marker_chain(const io::Table& top, const io::Table& own, const fluid::Spec& fluid) {
  const bond::AnyLaw law = engine::read_law(top);
  if (std::abs(engine::read_derivation(top, law).rest_length - 1.0) > 1e-6) {
    top.table("bond").fail("law", "it does not rest at 1",
                           "the theory is that of markers on neighbouring nodes of the fluid",
                           "Use a law that rests at 1");
  }
  scene::CouplingSpec coupling = engine::read_coupling(top);
  if (coupling.delta != coupling::Delta::FourPoint || coupling.forcing_iterations != 1) {
    top.table("coupling")
        .fail("delta", "it is not the 4-point kernel, in one iteration",
              "the theory is that of these markers",
              "Write delta = \"4-point\" and leave out forcing_iterations");
  }
  if (coupling.coupled != scene::Coupled::Boundary && coupling.coupled != scene::Coupled::All) {
    top.table("coupling")
        .fail("nodes", "not every node is coupled", "the theory is that of a chain of markers",
              "Leave it out, or write \"all\"");
  }
  const std::int64_t nodes = own.integer("nodes", 7, 1001);
  solid::Network network = solid::cubic_lattice({{1, 1, nodes}, 1.0});
  solid::add_angles(network);
  network.rest = scene::turned(network.rest, 0);
  network.vectors = scene::turned(network.vectors, 0);
  solid::Conditions conditions;
  conditions.node_mass = engine::need_positive(own, "node_mass", own.number("node_mass"));
  const auto& size = fluid.grid.size;
  return {.material = {law, 0.0},
          .network = std::move(network),
          .conditions = std::move(conditions),
          .substeps = {static_cast<int>(own.integer("substeps", 1, 10000)), 0.0},
          .place = {static_cast<double>(size[0] / 2 - (nodes - 1) / 2), static_cast<double>(size[1] / 2),
                    static_cast<double>(size[2] / 2)},
          .axis = 0,
          .coupling = std::move(coupling)};
}

void check_empty_box(const io::Table& top, const fluid::Spec& fluid) {
  const auto closed = fluid::closed(fluid);
  const bool has_walls = std::any_of(closed.begin(), closed.end(), [](bool end) { return end; });
  if (!has_walls && !fluid.has_obstacle() && !fluid.is_forced()) return;
  top.table("fluid").fail("nodes", "the box is not empty", "the theory is that of a periodic box",
                          "Leave out walls, obstacle and body_force");
}

}  // namespace veriflex::measures
