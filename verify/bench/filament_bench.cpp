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

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

nlohmann::json measure(std::array<std::int64_t, 3> box, double relaxation_time, fluid::Storage storage,
                       const bond::AnyLaw& law) {
  fluid::Spec spec{.grid = {box}, .relaxation_time = relaxation_time, .storage = storage};
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
  scene::Simulation coupled = measures::simulation_of(stroke);
  scene::Simulation alone({.fluid = spec});
  // Odd and even steps move different data.
  const std::int64_t steps = std::max<std::int64_t>(2, coupled.steps_at_once());
  const int rounds = steps > 2 ? 15 : 40;
  coupled.advance(steps);
  alone.advance(steps);
  std::vector<double> far, near, coupling, solid, total, bare;
  for (int i = 0; i < rounds; ++i) {
    const auto before = coupled.seconds();
    const double bare_before = alone.seconds().fluid.wall;
    coupled.advance(steps);
    alone.advance(steps);
    const auto after = coupled.seconds();
    const auto of_step = [&](double seconds) { return 1e3 * seconds / static_cast<double>(steps); };
    near.push_back(of_step(after.near.wall - before.near.wall));
    far.push_back(of_step(after.fluid.wall - before.fluid.wall) - near.back());
    coupling.push_back(of_step(after.coupling.wall - before.coupling.wall));
    solid.push_back(of_step(after.solid.wall - before.solid.wall));
    total.push_back(far.back() + near.back() + coupling.back() + solid.back());
    bare.push_back(of_step(alone.seconds().fluid.wall - bare_before));
  }
  const double nodes = static_cast<double>(spec.grid.count());
  const std::string name = fmt::format("{}x{}x{}", box[0], box[1], box[2]);
  const std::string kind = storage == fluid::Storage::Double ? "double" : "float";
  fmt::print(
      "{:>10} tau {:3} {:6} {:8} {:7.2f} ms a step: far {:6.2f}, near {:.2f}, exchange {:.3f}, solid {:.3f}"
      "  {:.3f} of the fluid alone  {:6.1f} MLUPS, {} steps at once\n",
      name, relaxation_time, kind, bond::name_of(law), median(total), median(far), median(near),
      median(coupling), median(solid), median(total) / median(bare), nodes * 1e-3 / median(total),
      coupled.steps_at_once());
  return {{"box", name},
          {"relaxation_time", relaxation_time},
          {"storage", kind},
          {"law", bond::name_of(law)},
          {"threads", omp_get_max_threads()},
          {"steps_at_once", coupled.steps_at_once()},
          {"ms_far", median(far)},
          {"ms_near", median(near)},
          {"ms_coupling", median(coupling)},
          {"ms_solid", median(solid)},
          {"ms_total", median(total)},
          {"ms_fluid_alone", median(bare)},
          {"coupled_over_alone", median(total) / median(bare)},
          {"coupled_nodes", coupled.body().coupled().size()},
          {"touched_nodes", coupled.body().touched_nodes()},
          {"mlups", nodes * 1e-3 / median(total)}};
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
      for (const double tau : {1.0, 0.9}) {  // of moments, of populations
        for (const fluid::Storage storage : {fluid::Storage::Double, fluid::Storage::Float}) {
          for (const bond::AnyLaw& law : {harmonic, fene}) runs.push_back(measure(box, tau, storage, law));
        }
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
