/// The body of a comparison, from a LAMMPS data file.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/progress.hpp"
#include "measures/peer/table.hpp"
#include "scene/plan.hpp"
#include "solid/elastic.hpp"

namespace veriflex::measures::peer {

inline constexpr int x_axis = 0, y_axis = 1, z_axis = 2;

struct Body {
  solid::Material material;
  solid::Network network;
  std::map<std::int64_t, Eigen::Index> node_of_id;
  std::optional<double> node_mass;    // what the data file gives all of its atoms  [M]
  std::vector<std::string> warnings;  // what the data file says and nobody here uses

  bool has_angles() const { return material.angle_stiffness > 0.0; }
};

/// `peer.data` with the case's law and angle stiffness. Throws InputError, also where coefficients or
/// types of bonds and angles in the file contradict the case.
Body read_body(const io::Table& top, const io::Table& peer);

/// Tells of body.warnings.
void warn(const Body& body, Progress& progress);

/// The node of each row's `id`, in blocks of one row per node. Throws InputError where the table is not of
/// that body.
std::vector<Eigen::Index> nodes_of_rows(const Body& body, const PeerTable& table, const io::Table& peer);

/// Rows `from` onwards of a column of vectors, in the order of nodes.
Positions by_node(const Positions& rows, const std::vector<Eigen::Index>& node_of_row, std::size_t from,
                  Eigen::Index nodes);
std::vector<double> by_node(const std::vector<double>& rows, const std::vector<Eigen::Index>& node_of_row);

/// What is built of it; `method` says how it is solved, empty where nothing is. A body that moves is free.
/// `by`: what solves it, as in scene::Outline.
scene::Plan plan_of(const Body& body, const std::string& method, const std::vector<parts::Kind>& by);

/// Energy at displacement u  [M L^2 T^-2], and its gradient by the nodes. Throws NumericalFailure where it
/// does not exist.
double evaluate(const solid::Material& material, const solid::Network& network, const Positions& u,
                Positions& gradient);

/// Bonds that carry no force, so that angles are seen alone.
inline constexpr bond::Harmonic slack{.bond_stiffness = 0.0, .rest_length = 1.0};

}  // namespace veriflex::measures::peer
