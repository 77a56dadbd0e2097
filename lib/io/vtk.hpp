/// Files of VTK's XML formats, which ParaView reads: points with lines between them, fields on a box of
/// nodes, and the list that makes a series in time of them. Arrays stand behind the XML as they are in
/// memory.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace veriflex::io {

/// `components` numbers for each point or cell, one point after the other.
struct VtkArray {
  std::string name;
  std::size_t components;
  std::vector<double> values;
};

/// An UnstructuredGrid (.vtu): points (x, y, z one after the other) and lines between them; without lines
/// each point is a vertex, and there is no data of cells.
std::string vtk_lines(double time, const std::vector<double>& points,
                      const std::vector<std::array<std::int64_t, 2>>& lines,
                      const std::vector<VtkArray>& on_points, const std::vector<VtkArray>& on_lines);

/// An ImageData (.vti) of nodes one apart, x fastest, the first at `origin`.
std::string vtk_image(double time, const std::array<std::int64_t, 3>& origin,
                      const std::array<std::int64_t, 3>& nodes, const std::vector<VtkArray>& on_nodes);

/// A file of a series, and when it is of. Several parts may be of one time.
struct VtkMember {
  double time;
  int part;
  std::string file;
};

/// A collection (.pvd) of files beside it.
std::string vtk_collection(const std::vector<VtkMember>& members);

}  // namespace veriflex::io
