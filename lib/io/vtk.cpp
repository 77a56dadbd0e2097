#include "io/vtk.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <span>

#include "io/hdf5.hpp"

namespace veriflex::io {

namespace {

static_assert(std::endian::native == std::endian::little, "the files say so");

// A file whose arrays are appended to its XML.
class Document {
 public:
  Document(const char* kind, double time) {
    xml_ = fmt::format(
        "<?xml version=\"1.0\"?>\n"
        "<VTKFile type=\"{0}\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
        "<{0}{{}}>\n"
        "<FieldData><DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" "
        "format=\"ascii\">{1}</DataArray></FieldData>\n",
        kind, time);
    end_ = fmt::format("</{}>\n", kind);
  }

  void add(const std::string& xml) { xml_ += xml; }

  template <class Value>
  void array(const char* type, const std::string& name, std::size_t components,
             std::span<const Value> values) {
    xml_ += fmt::format(
        "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" offset=\"{}\"/>\n",
        type, name, components, data_.size());
    const std::uint64_t bytes = values.size_bytes();
    data_.append(reinterpret_cast<const char*>(&bytes), sizeof bytes);
    data_.append(reinterpret_cast<const char*>(values.data()), bytes);
  }

  void arrays(const char* of, const std::vector<VtkArray>& all) {
    xml_ += fmt::format("<{}>\n", of);
    for (const VtkArray& one : all) array<double>("Float64", one.name, one.components, one.values);
    xml_ += fmt::format("</{}>\n", of);
  }

  // `attributes`: of the element that is named after the file's kind.
  std::string text(const std::string& attributes) const {
    std::string all = xml_;
    all.replace(all.find("{}"), 2, attributes);
    return all + end_ + "<AppendedData encoding=\"raw\">\n_" + data_ + "\n</AppendedData>\n</VTKFile>\n";
  }

 private:
  std::string xml_, end_, data_;
};

// Where each cell begins among the corners, and where the last one ends.
std::vector<std::int64_t> offsets_of(const VtkGrid& grid) {
  const std::int64_t each = grid.cell == VtkCell::vertex ? 1 : grid.cell == VtkCell::line ? 2 : 4;
  std::vector<std::int64_t> offsets{0};
  while (offsets.back() < std::ssize(grid.corners)) offsets.push_back(offsets.back() + each);
  return offsets;
}

std::vector<std::uint8_t> types_of(const VtkGrid& grid) {
  return std::vector<std::uint8_t>(offsets_of(grid).size() - 1, static_cast<std::uint8_t>(grid.cell));
}

}  // namespace

std::string vtk_xml(const VtkGrid& grid) {
  const std::size_t count = grid.points.size() / 3;
  const std::vector<std::int64_t> offsets = offsets_of(grid);
  const std::size_t cells = offsets.size() - 1;
  Document file("UnstructuredGrid", grid.time);
  file.add(fmt::format("<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n", count, cells));
  file.arrays("PointData", grid.on_points);
  file.arrays("CellData", grid.on_cells);
  file.add("<Points>\n");
  file.array<double>("Float64", "Points", 3, grid.points);
  file.add("</Points>\n<Cells>\n");
  file.array<std::int64_t>("Int64", "connectivity", 1, grid.corners);
  file.array<std::int64_t>("Int64", "offsets", 1, std::span(offsets).subspan(1));
  file.array<std::uint8_t>("UInt8", "types", 1, types_of(grid));
  file.add("</Cells>\n</Piece>\n");
  return file.text("");
}

std::string vtk_xml(const VtkImage& image) {
  const std::array<std::int64_t, 3>& nodes = image.nodes;
  const std::string extent = fmt::format("0 {} 0 {} 0 {}", nodes[0] - 1, nodes[1] - 1, nodes[2] - 1);
  Document file("ImageData", image.time);
  file.add(fmt::format("<Piece Extent=\"{}\">\n", extent));
  file.arrays("PointData", image.on_nodes);
  file.add("</Piece>\n");
  return file.text(fmt::format(" WholeExtent=\"{}\" Origin=\"{} {} {}\" Spacing=\"1 1 1\"", extent,
                               image.origin[0], image.origin[1], image.origin[2]));
}

namespace {

constexpr const char* group = "/VTKHDF";

void begin(Hdf5Image& file, const char* kind, double time) {
  constexpr std::array<std::int64_t, 2> version{1, 0};
  file.group(group);
  file.attribute(group, "Version", version);
  file.ascii_attribute(group, "Type", kind);
  // Not as FieldData: the reader of 9.1 takes an image's for a field of its nodes.
  file.attribute(group, "TimeValue", std::array{time});
}

// `shape`: of the points or cells.
void put_arrays(Hdf5Image& file, const char* of, const std::vector<VtkArray>& all,
                const std::vector<std::size_t>& shape) {
  for (const VtkArray& one : all) {
    std::vector<std::size_t> whole = shape;
    if (one.components > 1) whole.push_back(one.components);
    file.array(fmt::format("{}/{}/{}", group, of, one.name), one.values, whole);
  }
}

// The nodes of an image of less than three dimensions as points, and cells between neighbours.
VtkGrid grid_of(const VtkImage& image) {
  const std::array<std::int64_t, 3>& n = image.nodes;
  const std::array<std::int64_t, 3> stride{1, n[0], n[0] * n[1]};
  std::vector<std::int64_t> along;  // strides along which there are neighbours
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (n[axis] > 1) along.push_back(stride[axis]);
  }
  constexpr std::array cells{VtkCell::vertex, VtkCell::line, VtkCell::pixel};
  VtkGrid grid{image.time, {}, cells[along.size()], {}, image.on_nodes, {}};
  for (std::int64_t z = 0; z < n[2]; ++z) {
    for (std::int64_t y = 0; y < n[1]; ++y) {
      for (std::int64_t x = 0; x < n[0]; ++x) {
        for (const std::int64_t at : {image.origin[0] + x, image.origin[1] + y, image.origin[2] + z})
          grid.points.push_back(static_cast<double>(at));
        const bool is_last =
            (n[0] > 1 && x == n[0] - 1) || (n[1] > 1 && y == n[1] - 1) || (n[2] > 1 && z == n[2] - 1);
        if (is_last) continue;
        const std::int64_t first = x * stride[0] + y * stride[1] + z * stride[2];
        grid.corners.push_back(first);
        for (const std::int64_t step : along) grid.corners.push_back(first + step);
        if (along.size() == 2) grid.corners.push_back(first + along[0] + along[1]);
      }
    }
  }
  return grid;
}

}  // namespace

std::vector<char> vtk_hdf(const VtkGrid& grid) {
  const std::size_t count = grid.points.size() / 3;
  const std::vector<std::int64_t> offsets = offsets_of(grid);
  const std::size_t cells = offsets.size() - 1;
  Hdf5Image file;
  begin(file, "UnstructuredGrid", grid.time);
  const auto put = [&](const char* name, const auto& values, const std::vector<std::size_t>& shape) {
    file.array(fmt::format("{}/{}", group, name), values, shape);
  };
  put("NumberOfPoints", std::array{static_cast<std::int64_t>(count)}, {1});
  put("NumberOfCells", std::array{static_cast<std::int64_t>(cells)}, {1});
  put("NumberOfConnectivityIds", std::array{std::ssize(grid.corners)}, {1});
  put("Points", grid.points, {count, 3});
  put("Connectivity", grid.corners, {grid.corners.size()});
  put("Offsets", offsets, {offsets.size()});
  put("Types", types_of(grid), {cells});
  put_arrays(file, "PointData", grid.on_points, {count});
  put_arrays(file, "CellData", grid.on_cells, {cells});
  return file.bytes(snapshot_seal);
}

std::vector<char> vtk_hdf(const VtkImage& image) {
  const std::array<std::int64_t, 3>& n = image.nodes;
  if (std::count(n.begin(), n.end(), 1) > 0) return vtk_hdf(grid_of(image));
  Hdf5Image file;
  begin(file, "ImageData", image.time);
  constexpr std::array axes{1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
  const std::array<double, 3> origin{static_cast<double>(image.origin[0]),
                                     static_cast<double>(image.origin[1]),
                                     static_cast<double>(image.origin[2])};
  file.attribute(group, "WholeExtent", std::array<std::int64_t, 6>{0, n[0] - 1, 0, n[1] - 1, 0, n[2] - 1});
  file.attribute(group, "Origin", origin);
  file.attribute(group, "Spacing", std::array{1.0, 1.0, 1.0});
  file.attribute(group, "Direction", axes);
  put_arrays(
      file, "PointData", image.on_nodes,
      {static_cast<std::size_t>(n[2]), static_cast<std::size_t>(n[1]), static_cast<std::size_t>(n[0])});
  return file.bytes(snapshot_seal);
}

std::string vtk_collection(const std::vector<VtkMember>& members) {
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" "
      "byte_order=\"LittleEndian\">\n<Collection>\n";
  for (const VtkMember& one : members) {
    text += fmt::format("<DataSet timestep=\"{}\" part=\"{}\" file=\"{}\"/>\n", one.time, one.part, one.file);
  }
  return text + "</Collection>\n</VTKFile>\n";
}

std::string vtk_series(const std::vector<VtkMember>& members) {
  std::string text = "{\n\"file-series-version\": \"1.0\",\n\"files\": [\n";
  for (const VtkMember& one : members) {
    text += fmt::format("{{\"name\": \"{}\", \"time\": {}}}{}\n", one.file, one.time,
                        &one == &members.back() ? "" : ",");
  }
  return text + "]\n}\n";
}

}  // namespace veriflex::io
