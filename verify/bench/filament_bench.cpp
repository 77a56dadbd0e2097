// What a step of the coupled scene costs, part by part: the paper's filament of 1071 nodes in its box.
#include <fmt/format.h>
#include <omp.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <nlohmann/json.hpp>

#include "io/file.hpp"
#include "measures/filament/filament_run.hpp"

namespace {

using namespace veriflex;

nlohmann::json measure(std::array<std::int64_t, 3> box, fluid::Storage storage, const bond::AnyLaw& law) {
  fluid::Spec spec{.grid = {box}, .relaxation_time = 1.0, .storage = storage};
  measures::Stroke stroke{.fluid = spec,
                          .rod = {2.5, 51, 1.0},
                          .law = law,
                          .angle_stiffness = 0.025,
                          .node_mass = 1.0,
                          .substeps = {4, 0.0},
                          .coupling = {},
                          .offset = Vec3::Zero(),
                          .amplitude = 5.0,
                          .reynolds = 10.21,
                          .driven = measures::Driven::Node,
                          .ramp_periods = 0.0,
                          .periods = 1,
                          .monitor = {}};
  scene::Simulation simulation = measures::simulation_of(stroke);
  simulation.advance();
  simulation.advance();
  struct Milliseconds {
    double fluid, coupling, solid, total;
  };
  std::vector<Milliseconds> steps;
  const double nodes = static_cast<double>(spec.grid.count());
  for (int i = 0; i < 40; ++i) {  // pairs, because odd and even steps move different data
    const auto before = simulation.seconds();
    simulation.advance();
    simulation.advance();
    const auto after = simulation.seconds();
    const double fluid = 500.0 * (after.fluid.wall - before.fluid.wall);
    const double coupling = 500.0 * (after.coupling.wall - before.coupling.wall);
    const double solid = 500.0 * (after.solid.wall - before.solid.wall);
    steps.push_back({fluid, coupling, solid, fluid + coupling + solid});
  }
  const auto median = [&](auto part) {
    std::vector<double> values;
    for (const Milliseconds& step : steps) values.push_back(part(step));
    std::nth_element(values.begin(), values.begin() + 20, values.end());
    return values[20];
  };
  const double fluid = median([](const Milliseconds& m) { return m.fluid; });
  const double coupling = median([](const Milliseconds& m) { return m.coupling; });
  const double solid = median([](const Milliseconds& m) { return m.solid; });
  const double total = median([](const Milliseconds& m) { return m.total; });
  const std::string name = fmt::format("{}x{}x{}", box[0], box[1], box[2]);
  const std::string kind = storage == fluid::Storage::Double ? "double" : "float";
  fmt::print(
      "{:>12} {:6} {:8}  {:7.2f} ms a step: fluid {:.2f}, coupling {:.3f}, solid {:.3f} ({:.1f} % of the "
      "fluid)  {:.1f} MLUPS\n",
      name, kind, bond::name_of(law), total, fluid, coupling, solid, 100.0 * (coupling + solid) / fluid,
      nodes * 1e-3 / total);
  return {{"box", name},
          {"storage", kind},
          {"law", bond::name_of(law)},
          {"threads", omp_get_max_threads()},
          {"ms_fluid", fluid},
          {"ms_coupling", coupling},
          {"ms_solid", solid},
          {"ms_total", total},
          {"coupled_nodes", simulation.body().coupled().size()},
          {"touched_nodes", simulation.body().touched_nodes()},
          {"mlups", nodes * 1e-3 / total}};
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Cost of the coupled filament");
  std::string output;
  app.add_option("--output", output, "JSON file");
  try {
    app.parse(argc, argv);
    const bond::AnyLaw harmonic = bond::Harmonic{0.26, 1.0};
    const bond::AnyLaw fene = bond::make_law("fene-lj", [](const std::string& name) -> std::optional<double> {
      if (name == "epsilon") return 0.000287;
      if (name == "sigma") return 1.0407;
      return std::nullopt;
    });
    nlohmann::json runs = nlohmann::json::array();
    for (const auto& box : {std::array<std::int64_t, 3>{40, 112, 80}, {64, 416, 400}}) {
      for (const fluid::Storage storage : {fluid::Storage::Double, fluid::Storage::Float}) {
        for (const bond::AnyLaw& law : {harmonic, fene}) runs.push_back(measure(box, storage, law));
      }
    }
    if (!output.empty()) io::write_file(output, nlohmann::json{{"runs", runs}}.dump(2) + "\n");
  } catch (const CLI::Error& error) {
    return app.exit(error);
  } catch (const std::exception& error) {
    fmt::print(stderr, "filament_bench: {}\n", error.what());
    return 2;
  }
  return 0;
}
