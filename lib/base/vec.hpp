/// Vectors of space and of degrees of dofs.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace veriflex {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

/// One row per node, stored by columns: all x, then all y, then all z, so that loops over nodes or bonds
/// vectorise. Coordinate `axis` of node i is element axis * rows + i of data().
using Positions = Eigen::Matrix<double, Eigen::Dynamic, 3>;

}  // namespace veriflex
