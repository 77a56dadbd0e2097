#include "io/vtk.hpp"

#include <fmt/format.h>

#include <bit>
#include <string_view>

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
             const std::vector<Value>& values) {
    xml_ += fmt::format(
        "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" offset=\"{}\"/>\n",
        type, name, components, data_.size());
    const std::uint64_t bytes = values.size() * sizeof(Value);
    data_.append(reinterpret_cast<const char*>(&bytes), sizeof bytes);
    data_.append(reinterpret_cast<const char*>(values.data()), bytes);
  }

  void arrays(const char* of, const std::vector<VtkArray>& all) {
    xml_ += fmt::format("<{}>\n", of);
    for (const VtkArray& one : all) array("Float64", one.name, one.components, one.values);
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

}  // namespace

std::string vtk_lines(double time, const std::vector<double>& points,
                      const std::vector<std::array<std::int64_t, 2>>& lines,
                      const std::vector<VtkArray>& on_points, const std::vector<VtkArray>& on_lines) {
  constexpr std::uint8_t vertex = 1, line = 3;  // VTK's types of cells
  const std::size_t count = points.size() / 3;
  const bool has_lines = !lines.empty();
  std::vector<std::int64_t> ends, offsets;
  for (const std::array<std::int64_t, 2>& one : lines) {
    ends.insert(ends.end(), {one[0], one[1]});
    offsets.push_back(std::ssize(ends));
  }
  for (std::size_t i = 0; !has_lines && i < count; ++i) {
    ends.push_back(static_cast<std::int64_t>(i));
    offsets.push_back(std::ssize(ends));
  }
  Document file("UnstructuredGrid", time);
  file.add(fmt::format("<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n", count, offsets.size()));
  file.arrays("PointData", on_points);
  file.arrays("CellData", has_lines ? on_lines : std::vector<VtkArray>{});
  file.add("<Points>\n");
  file.array("Float64", "Points", 3, points);
  file.add("</Points>\n<Cells>\n");
  file.array("Int64", "connectivity", 1, ends);
  file.array("Int64", "offsets", 1, offsets);
  file.array("UInt8", "types", 1, std::vector<std::uint8_t>(offsets.size(), has_lines ? line : vertex));
  file.add("</Cells>\n</Piece>\n");
  return file.text("");
}

std::string vtk_image(double time, const std::array<std::int64_t, 3>& origin,
                      const std::array<std::int64_t, 3>& nodes, const std::vector<VtkArray>& on_nodes) {
  const std::string extent = fmt::format("0 {} 0 {} 0 {}", nodes[0] - 1, nodes[1] - 1, nodes[2] - 1);
  Document file("ImageData", time);
  file.add(fmt::format("<Piece Extent=\"{}\">\n", extent));
  file.arrays("PointData", on_nodes);
  file.add("</Piece>\n");
  return file.text(fmt::format(" WholeExtent=\"{}\" Origin=\"{} {} {}\" Spacing=\"1 1 1\"", extent, origin[0],
                               origin[1], origin[2]));
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

}  // namespace veriflex::io
