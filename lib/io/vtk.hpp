/// Pictures of a body and of a fluid as files that ParaView reads: VTK's XML formats, or its HDF5 format
/// (VTKHDF), and the lists that make series in time of them.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace veriflex::io {

/// `components` numbers for each point or cell, one point after the other.
struct VtkArray {
  std::string name;
  std::size_t components;
  std::vector<double> values;
};

/// Cells by VTK's numbers.
enum class VtkCell : std::uint8_t { vertex = 1, line = 3, pixel = 8 };

/// An UnstructuredGrid: points (x, y, z one after the other), and cells of one kind between them, whose
/// corners are numbers of points, one cell after the other.
struct VtkGrid {
  double time;
  std::vector<double> points;
  VtkCell cell;
  std::vector<std::int64_t> corners;
  std::vector<VtkArray> on_points, on_cells;
};

/// An ImageData: nodes one apart, x fastest, the first at `origin`.
struct VtkImage {
  double time;
  std::array<std::int64_t, 3> origin, nodes;
  std::vector<VtkArray> on_nodes;
};

/// XML (.vtu, .vti), with the arrays behind it as they are in memory.
std::string vtk_xml(const VtkGrid& grid);
std::string vtk_xml(const VtkImage& image);

/// VTKHDF 1.0 (.hdf), its arrays compressed without loss, behind the seal of all our HDF5 files. An image
/// that is flat along an axis is written as a grid of its nodes: VTK's readers of flat images fail, that of
/// 9.1 by overwriting its memory.
std::vector<char> vtk_hdf(const VtkGrid& grid);
std::vector<char> vtk_hdf(const VtkImage& image);

/// A file of a series, and when it is of. Several parts may be of one time.
struct VtkMember {
  double time;
  int part;
  std::string file;
};

/// Lists of files beside them: of XML (.pvd), and of any kind (.<kind>.series, which knows no parts).
std::string vtk_collection(const std::vector<VtkMember>& members);
std::string vtk_series(const std::vector<VtkMember>& members);

}  // namespace veriflex::io
