/// Vectors of space and of degrees of freedom.
#pragma once

#include <Eigen/Core>

namespace veriflex {

using Vec3 = Eigen::Vector3d;
using Positions = Eigen::Matrix3Xd;  // one column per node  [L]

}  // namespace veriflex
