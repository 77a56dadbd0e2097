#include "advise_rod.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string_view>

#include "advisers.hpp"
#include "base/error.hpp"
#include "bond/harmonic.hpp"
#include "engine/columns.hpp"
#include "engine/only.hpp"
#include "engine/rates.hpp"
#include "engine/result.hpp"
#include "engine/symbols.hpp"
#include "io/hdf5.hpp"
#include "measures/solid/beam_section.hpp"
#include "scene/coupling_stability.hpp"
#include "scene/markers.hpp"
#include "solid/modes.hpp"
#include "studies/advise.hpp"

namespace veriflex {

namespace {

namespace fs = std::filesystem;

constexpr const char* drag_study = "cost-cylinder-markers";
constexpr const char* filament_study = "cost-filament";
constexpr const char* rounds_key = "coupling.forcing_iterations";
constexpr double angle_over_bond = 0.025 / 0.26;  // k_a/(k r0^2) of the paper
constexpr std::int64_t enough_sections = 9;       // largest frequencies are those of any longer rod
constexpr int most_substeps = 64;   // beyond, a step in one piece costs less (docs/findings/solid.md)
constexpr double least_tau = 0.51;  // see engine::quantities(), and
constexpr double largest_mach = 0.1;
// Of the wanted error: what the drag of the section, the Mach number and the box may take.
constexpr double drag_share = 0.5, mach_share = 0.25, box_share = 0.25;

io::Hdf5File open_study(const fs::path& results, const std::string& id) {
  const fs::path path = results / (id + ".h5");
  std::error_code unknown;
  if (!fs::is_regular_file(path, unknown)) {
    throw InputError({path.string()}, "there is no such result",
                     fmt::format("how the drag of a section depends on its resolution is taken from {}", id),
                     fmt::format("veriflex run {} --out {}, which takes some minutes", id, results.string()));
  }
  return io::Hdf5File(path);
}

std::string value_of(const std::vector<std::string>& setting, const std::string& key) {
  for (const std::string& one : setting) {
    if (one.starts_with(key + "=")) return one.substr(key.size() + 1);
  }
  throw std::logic_error("no " + key + " in an advice");
}

/// The section: radius in spacings, and how its markers meet the fluid.
struct Section {
  double radius, tau, error;
  std::string delta;
  int iterations;
};

/// Without further rounds of forcing, and without their axis.
studies::SweptRows one_round_only(const studies::SweptRows& all) {
  studies::SweptRows kept{{}, {}, {}, {}};
  const observe::Column* rounds = nullptr;
  for (const observe::Column& axis : all.axes) {
    if (axis.name == rounds_key)
      rounds = &axis;
    else
      kept.axes.push_back({axis.name, axis.symbol, axis.dimension, axis.meaning, {}});
  }
  if (rounds == nullptr) return all;
  for (std::size_t i = 0; i < all.error.size(); ++i) {
    if (!rounds->texts.empty() || rounds->values[i] != 1.0) continue;
    std::size_t to = 0;
    for (const observe::Column& axis : all.axes) {
      if (&axis == rounds) continue;
      observe::Column& column = kept.axes[to++];
      if (axis.texts.empty())
        column.values.push_back(axis.values[i]);
      else
        column.texts.push_back(axis.texts[i]);
    }
    kept.error.push_back(all.error[i]);
    kept.seconds.push_back(all.seconds[i]);
    kept.memory.push_back(all.memory[i]);
  }
  return kept;
}

/// For an elastic body with one round of forcing: further ones see the body's velocity of before the step,
/// and light bodies do not bear that.
Section section_for(double error, bool is_elastic, const fs::path& results) {
  const io::Hdf5File file = open_study(results, drag_study);
  studies::SweptRows rows = rows_of(file, drag_study);
  if (is_elastic) rows = one_round_only(rows);
  const studies::Advice found = studies::advise(rows, {.error = error, .budget = {}});
  return {std::stod(value_of(found.setting, "immersed.radius")),
          std::stod(value_of(found.setting, "fluid.relaxation_time")), found.error,
          studies::bare(value_of(found.setting, "coupling.delta")),
          is_elastic ? 1 : std::stoi(value_of(found.setting, rounds_key))};
}

/// What the driven filament's family says of boxes and storage, in lengths of its rod.
struct Filament {
  std::array<double, 3> box;  // across, along, in the plane of the motion
  double box_error, storage_error, slenderness;
};

std::optional<Filament> filament_for(double error, const fs::path& results) {
  const fs::path path = results / (std::string(filament_study) + ".h5");
  std::error_code unknown;
  if (!fs::is_regular_file(path, unknown)) return std::nullopt;
  const io::Hdf5File file(path);
  if (file.attribute("/", "outcome") != "completed") return std::nullopt;
  const io::Table top =
      engine::parse_case(engine::only(file.texts("/case"), path.string(), "/case"), path.string());
  const observe::Record sweep = engine::read_record(file, "sweep");
  const std::vector<double>& errors = engine::numbers_in(sweep, error_of_sweep(file), file);
  const std::vector<double>& periods = engine::numbers_in(sweep, "filament.periods", file);
  const std::vector<double>& boxes = engine::numbers_in(sweep, "fluid.nodes.2", file);
  const std::vector<std::string>& storages = engine::words_in(sweep, "fluid.storage", file);
  const std::vector<double>& substeps = engine::numbers_in(sweep, "filament.substeps", file);
  if (periods.empty()) return std::nullopt;
  const double last = *std::max_element(periods.begin(), periods.end());
  std::map<std::tuple<double, double, double>, std::map<std::string, double>> by_storage;
  std::map<double, double> of_box;  // the smallest error with it
  for (std::size_t i = 0; i < errors.size(); ++i) {
    if (!std::isfinite(errors[i])) continue;
    by_storage[{periods[i], boxes[i], substeps[i]}][storages[i]] = errors[i];
    if (periods[i] < last) continue;
    const auto at = of_box.try_emplace(boxes[i], errors[i]).first;
    at->second = std::min(at->second, errors[i]);
  }
  if (of_box.empty()) return std::nullopt;
  double storage_error = 0.0;
  for (const auto& [setting, of] : by_storage) {
    if (of.size() == 2)
      storage_error = std::max(storage_error, std::abs(of.begin()->second - of.rbegin()->second));
  }
  auto box = std::find_if(of_box.begin(), of_box.end(), [&](const auto& one) { return one.second <= error; });
  if (box == of_box.end()) box = std::prev(of_box.end());
  const std::vector<studies::Axis> axes = own_axes(top, file);
  const auto axis = std::find_if(axes.begin(), axes.end(),
                                 [](const studies::Axis& a) { return a.name() == "fluid.nodes.2"; });
  if (axis == axes.end()) return std::nullopt;
  const auto values = studies::values_at(*axis, fmt::format("{}", box->first));
  if (!values || values->size() < 3) return std::nullopt;
  const io::Table solid = top.table("solid");
  const double length = static_cast<double>(solid.integer("sections", 2, 1'000'000) - 1);
  return Filament{{std::stod((*values)[1]) / length, std::stod((*values)[2]) / length, box->first / length},
                  box->second,
                  storage_error,
                  length / (2.0 * solid.number("radius"))};
}

/// Along y.
scene::Body rod_of(const Section& section, std::int64_t sections, double modulus, double node_mass,
                   const Vec3& place) {
  solid::Network network = solid::rod_lattice({section.radius, sections, 1.0});
  solid::add_angles(network);
  network.rest = scene::turned(network.rest, 1);
  network.vectors = scene::turned(network.vectors, 1);
  scene::Body body{{bond::Harmonic{modulus, 1.0}, angle_over_bond * modulus}, std::move(network)};
  body.axis = 1;
  body.conditions.node_mass = node_mass;
  body.place = place;
  body.coupling.emplace();
  body.coupling->delta = row_named(coupling::deltas, section.delta).value;
  body.coupling->forcing_iterations = section.iterations;
  body.coupling->subcycled = true;
  return body;
}

/// As many sub-steps, a power of two, as take half of leap-frog's linear limit; 0: a step in one piece costs
/// less.
int substeps_for(const scene::Body& body) {
  const double omega = solid::largest_frequency(
      body.material, body.network, Positions::Zero(body.network.node_count(), 3),
      solid::FixedDofs::Constant(body.network.node_count(), 3, false), body.conditions.node_mass);
  for (int count = 1; count <= most_substeps; count *= 2) {
    if (omega / count <= 1.0) return count;
  }
  return 0;
}

/// What the settings are found from, one after the other.
struct Found {
  RodAdvice advice;
  Section section;
  engine::Lattice lattice;
  double length = 0.0, amplitude = 0.0;  // [spacings]
  Vec3 place = Vec3::Zero();             // of the rod's first section
  std::int64_t steps = 0;
  fluid::Spec fluid{};
  std::optional<scene::Body> body{};

  void add(std::string setting, std::string why) {
    advice.settings.push_back({std::move(setting), std::move(why)});
  }
  void add_error(double error, std::string what) {
    advice.error += error;
    advice.errors.push_back(fmt::format("{} {:.2g}", what, error));
  }
  std::int64_t sections() const { return std::lround(length) + 1; }
};

/// Resolution and time step: the study's, unless the flow would be compressed by more than its share of the
/// error.
Found resolved(const RodInFlow& rod, double error, const fs::path& results) {
  Section section = section_for(drag_share * error, rod.flow.young_modulus.has_value(), results);
  std::string why_radius = fmt::format("{}: drag to {:.2g} as Re tends to 0; here Re = {:.3g}", drag_study,
                                       section.error, rod.flow.speed * rod.flow.length / rod.flow.viscosity);
  engine::Physical flow = rod.flow;
  flow.spacings = 2.0 * section.radius;
  flow.mach = std::min(largest_mach, std::sqrt(mach_share * error));
  const double coarse = *engine::lattice_of(flow).told.relaxation_time;
  if (coarse < least_tau) {  // tau - 1/2 at that Mach number grows with the resolution
    section.radius = std::ceil(2.0 * section.radius * (least_tau - 0.5) / (coarse - 0.5)) / 2.0;
    flow.spacings = 2.0 * section.radius;
    why_radius =
        fmt::format("for tau = {} at Ma = {:.2g}; {} asks for less", least_tau, flow.mach, drag_study);
  }
  const double tau = std::min(section.tau, *engine::lattice_of(flow).told.relaxation_time);
  flow.relaxation_time = tau;
  const engine::Lattice lattice = engine::lattice_of(flow);
  const engine::Units& units = lattice.units;
  const double mach = *lattice.told.speed * std::sqrt(3.0);
  Found found{.advice = {},
              .section = section,
              .lattice = lattice,
              .length = rod.rod_length / units.spacing,
              .amplitude = rod.amplitude / units.spacing};
  found.advice.quantities = engine::quantities(lattice.told, units);
  found.add(fmt::format("body.0.shape.rod.radius={}", io::toml_text(section.radius)), why_radius);
  found.add(fmt::format("body.0.shape.rod.sections={}", found.sections()), "the rod's length");
  found.add(fmt::format("fluid.relaxation_time={}", io::toml_text(tau)),
            tau < section.tau
                ? fmt::format("Ma^2 = {:.2g}; below the tau that {} swept", mach * mach, drag_study)
                : std::string(drag_study));
  found.add(
      fmt::format("units={{ spacing = {}, time_step = {}, density = {} }}", io::toml_text(units.spacing),
                  io::toml_text(units.time_step), io::toml_text(units.density)),
      "diameter over the resolution; viscosity (tau - 1/2)/3");
  found.add(fmt::format("body.0.coupling={{ delta = \"{}\", forcing_iterations = {}, subcycled = true }}",
                        section.delta, section.iterations),
            fmt::format("{}; what follows the sub-steps carries more (coupled-limit-stiffness)", drag_study));
  found.add_error(section.error, "drag of the section");
  found.add_error(mach * mach, "Ma^2");
  return found;
}

/// The box, and what the fluid is stored as. A family of driven filaments says nothing of a stream, in which
/// a rod may also bend as far as it is long.
void choose_box(const RodInFlow& rod, double error, const fs::path& results, Found& found) {
  const double radius = found.section.radius, length = found.length;
  const bool is_driven = rod.amplitude > 0.0;
  const std::optional<Filament> filament = filament_for(box_share * error, results);
  // Across, along and in the plane of the motion.
  std::array<double, 3> wide{20.0 * radius, 2.0 * length,
                             20.0 * radius + (is_driven ? 2.0 * found.amplitude : length)};
  if (filament && is_driven) {
    for (std::size_t axis = 0; axis < 3; ++axis) wide[axis] = filament->box[axis] * length;
  }
  std::array<std::int64_t, 3> box{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t multiple = axis == 0 ? 16 : 4;  // rows along x are swept 16 nodes at a time
    box[axis] = static_cast<std::int64_t>(std::ceil(wide[axis] / static_cast<double>(multiple))) * multiple;
  }
  found.fluid = {.grid = {box}, .relaxation_time = *found.lattice.told.relaxation_time};
  if (!is_driven) {
    auto& along = found.fluid.walls[2].emplace();
    along.openings = {fluid::Inflow{{0.0, 0.0, *found.lattice.told.speed}}, fluid::Outflow{}};
  }
  found.place = {0.5 * static_cast<double>(box[0]), 0.5 * static_cast<double>(box[1] - found.sections() + 1),
                 is_driven ? 0.5 * static_cast<double>(box[2]) : 10.0 * radius};
  const std::string nodes = fmt::format("fluid.nodes=[{}]", fmt::join(box, ", "));
  if (filament && is_driven) {
    found.add(nodes,
              fmt::format("{}: the line to {:.2g}, of a rod of {:.3g} diameters, here {:.3g}", filament_study,
                          filament->box_error, filament->slenderness, length / (2.0 * radius)));
    found.add_error(filament->box_error, "box");
  } else {
    found.add(nodes, is_driven ? fmt::format("not known: a guess without a result of {} in {}",
                                             filament_study, results.string())
                               : "not known: a guess, with room for a rod that lies down");
    found.advice.errors.push_back("box: not known");
  }
  if (!filament) {
    found.add("fluid.storage=\"double\"", "not known, and safe");
    return;
  }
  if (filament->storage_error <= 0.1 * error) found.fluid.storage = fluid::Storage::Float;
  found.add(
      fmt::format("fluid.storage=\"{}\"", found.fluid.storage == fluid::Storage::Float ? "float" : "double"),
      fmt::format("{}: float moves the line by {:.1g}", filament_study, filament->storage_error));
}

/// By how much a rod of the lattice is stiffer in bending than a round one of its modulus and radius.
double stiffer_in_bending(double radius) {
  const solid::Material material{bond::Harmonic{1.0, 1.0}, angle_over_bond};
  const scene::SolidSpec spec{.shape = solid::Rod{radius, 2, 1.0}, .angle_stiffness = angle_over_bond};
  return measures::section_of(material, spec, 1.0).bending() /
         (0.25 * std::numbers::pi * std::pow(radius, 4));
}

/// What an elastic rod is made of and how it is stepped, found with a few of its sections.
void choose_body(Found& found) {
  const engine::Told::Body& told = found.lattice.told.bodies.front();
  const std::int64_t few = std::min(found.sections(), enough_sections);
  const auto across = static_cast<std::int64_t>(std::ceil(2.0 * found.section.radius)) + 12;
  const fluid::Spec around{.grid = {{across, few + 8, across}},
                           .relaxation_time = found.fluid.relaxation_time};
  const double stiffer = stiffer_in_bending(found.section.radius), modulus = told.young_modulus / stiffer;
  const Vec3 middle(0.5 * static_cast<double>(across), 4.0, 0.5 * static_cast<double>(across));
  scene::Body body = rod_of(found.section, few, modulus, told.density, middle);
  found.add(fmt::format("body.0.bond={{ law = \"harmonic\", bond_stiffness = {}, rest_length = 1.0 }}",
                        io::toml_text(modulus)),
            fmt::format("E = k/r0 of the lattice, over {:.3g}: so much stiffer it bends than a round rod "
                        "(beam-rod-harmonic)",
                        stiffer));
  found.add(fmt::format("body.0.angle={{ stiffness = {} }}", io::toml_text(body.material.angle_stiffness)),
            "k_a/(k r0^2) as in the paper: no law fixes it");
  found.add(fmt::format("body.0.node_mass={}", io::toml_text(told.density)), "density ratio");
  if (const int substeps = substeps_for(body); substeps > 0) {
    body.substeps.count = substeps;
    found.add(fmt::format("body.0.substeps={}", substeps), "half of leap-frog's linear limit");
  } else {
    body.scheme = solid::Scheme::ImplicitMidpoint;
    found.add("body.0.integrator=\"implicit-midpoint\"",
              fmt::format("otherwise more than {} sub-steps (stiff-filament)", most_substeps));
  }
  found.advice.coupling_growth = scene::coupling_growth(around, body).factor;
  found.body = rod_of(found.section, found.sections(), modulus, told.density, found.place);
  found.body->substeps = body.substeps;
  found.body->scheme = body.scheme;
}

/// A case of the settings. Comments say where each comes from.
std::string written(const RodInFlow& rod, double error, const Found& found) {
  const auto setting = [&](const std::string& key) {
    const auto one = std::find_if(found.advice.settings.begin(), found.advice.settings.end(),
                                  [&](const Advised& a) { return a.setting.starts_with(key + "="); });
    return one == found.advice.settings.end()
               ? std::string()
               : fmt::format("# {}\n{} = {}\n", one->why, key.substr(key.rfind('.') + 1),
                             one->setting.substr(key.size() + 1));
  };
  const double speed = *found.lattice.told.speed;
  const bool is_driven = rod.amplitude > 0.0, is_elastic = rod.flow.young_modulus.has_value();
  std::string text = fmt::format(
      "title = \"A rod {}, with the settings that are advised for an error of {:.3g}\"\n"
      "question = \"What does the fluid do to the rod?\"\n"
      "equation = \"F_int = rho_f V (u_f - u_s)\"\nsources = []\ntier = \"full\"\ntopics = [\"scene\"]\n"
      "driver = \"scene\"\n\n",
      is_driven ? "driven at one end" : "in a stream", error);
  text += setting("units") + "\n[fluid]\n";
  for (const char* key : {"fluid.nodes", "fluid.relaxation_time", "fluid.storage"}) text += setting(key);
  if (!is_driven) {
    text += fmt::format(
        "initial = {{ flow = \"uniform\", velocity = [0.0, 0.0, {0}] }}\n"
        "walls_z = {{ low_inflow = {{ velocity = [0.0, 0.0, {0}] }}, high_outflow = {{}} }}\n",
        io::toml_text(speed));
  }
  text += fmt::format(
      "\n[[body]]\nname = \"rod\"\nshape = {{ rod = {{ radius = {}, sections = {} }} }}\naxis = \"y\"\n"
      "place = [{:.1f}, {:.1f}, {:.1f}]\n",
      io::toml_text(found.section.radius), found.sections(), found.place[0], found.place[1], found.place[2]);
  for (const char* key : {"body.0.bond", "body.0.angle", "body.0.node_mass", "body.0.substeps",
                          "body.0.integrator", "body.0.coupling"})
    text += setting(key);
  const double period = 2.0 * std::numbers::pi * found.amplitude / speed;
  if (is_elastic && is_driven) {
    text += fmt::format(
        "drive = {{ nodes = \"first section\", direction = \"z\", amplitude = {}, period = {} }}\n",
        io::toml_text(found.amplitude), io::toml_text(period));
  } else if (is_elastic) {
    text += "clamped = \"first section\"\n";
  } else if (is_driven) {
    text += fmt::format("motion = {{ amplitude = [0.0, 0.0, {}], period = {} }}\n",
                        io::toml_text(found.amplitude), io::toml_text(period));
  } else {
    text += "motion = { velocity = [0.0, 0.0, 0.0] }\n";
  }
  text += "\n[run]\n" + setting("run.steps");
  const std::int64_t every = std::max<std::int64_t>(1, found.steps / 100);
  for (const char* what : {"forces", "tip"}) {
    if (is_elastic || what == std::string_view("forces"))
      text += fmt::format("\n[[observe]]\nwhat = \"{}\"\nevery = {}\n", what, every);
  }
  return text;
}

/// Steps, time and memory of a run.
void price(const RodInFlow& rod, int threads, Found& found) {
  constexpr double lengths_passed = 10.0;
  const double duration = rod.duration.value_or(lengths_passed * rod.rod_length / rod.flow.speed);
  found.steps = static_cast<std::int64_t>(std::ceil(duration / found.lattice.units.time_step));
  found.add(fmt::format("run.steps={}", found.steps), fmt::format("{:.3g} s", duration));
  scene::Scene scene{.fluid = found.fluid, .bodies = {}};
  if (found.body) scene.bodies.push_back(*found.body);
  found.advice.memory = 0.0;
  for (const scene::Built& built : scene::plan_scene(scene).built) *found.advice.memory += built.memory_bytes;
  if (const auto work = scene::expected_work(scene, found.steps))
    found.advice.seconds = engine::seconds_of(*work, engine::rates_for(*work, threads));
}

}  // namespace

RodAdvice advise_rod(const RodInFlow& rod, double error, const fs::path& results, int threads) {
  Found found = resolved(rod, error, results);
  choose_box(rod, error, results, found);
  if (rod.flow.young_modulus) choose_body(found);
  price(rod, threads, found);
  found.advice.scene = written(rod, error, found);
  return found.advice;
}

}  // namespace veriflex
