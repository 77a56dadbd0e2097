#include "engine/read_scene.hpp"

#include <fmt/format.h>

namespace veriflex::engine {

namespace {

constexpr std::int64_t most_nodes = 1'000'000'000'000;

[[noreturn]] void fail_at(const io::Section& section, const BadParameter& bad) {
  section.fail(bad.parameter, bad.problem, bad.why, bad.suggestion);
}

std::array<std::int64_t, 3> read_nodes(const io::Section& solid, const std::string& shape) {
  if (shape == "pair") return {1, 1, 2};
  if (shape == "chain") return {1, 1, solid.integer("nodes", 2, most_nodes)};
  const std::vector<std::int64_t> nodes = solid.integers("nodes");
  if (nodes.size() != 3) {
    solid.fail("nodes", fmt::format("'nodes' has {} numbers", nodes.size()),
               "a bar has n, m and l nodes along x, y and z", "Write for example nodes = [4, 4, 12]");
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const std::int64_t least = i == 2 ? 2 : 1;
    if (nodes[i] < least || nodes[i] > most_nodes) {
      solid.fail("nodes", fmt::format("'nodes' holds {}", nodes[i]),
                 fmt::format("the number along {} must lie between {} and {}", "xyz"[i], least, most_nodes),
                 "Choose a number in that range");
    }
  }
  return {nodes[0], nodes[1], nodes[2]};
}

}  // namespace

bond::AnyLaw read_law(const io::Section& top) {
  const io::Section table = top.table("bond");
  const std::string name = table.text("law");
  try {
    return bond::make_law(name, [&](const std::string& parameter) -> std::optional<double> {
      return table.has(parameter) ? std::optional(table.number_or_infinity(parameter)) : std::nullopt;
    });
  } catch (const MissingParameter& missing) {
    table.number(missing.parameter);  // throws, and knows about misspelt keys
    throw;
  } catch (const BadParameter& bad) {
    fail_at(table, bad);
  }
}

bond::Derivation read_derivation(const io::Section& top, const bond::AnyLaw& law) {
  try {
    return bond::derive(law);
  } catch (const BadParameter& bad) {
    fail_at(top.table("bond"), bad);
  } catch (const NumericalFailure& failure) {
    throw InputError(top.table("bond").place(), "the bond law has no usable rest state", failure.what(),
                     "Look at the size of its parameters");
  }
}

double read_angle_stiffness(const io::Section& top) {
  if (!top.has("angle")) return 0.0;
  const io::Section table = top.table("angle");
  const double stiffness = table.number("stiffness");
  if (!(stiffness >= 0.0)) {
    table.fail("stiffness", fmt::format("'stiffness' is {}", stiffness), "k_a cannot be negative",
               "Give 0 or more");
  }
  return stiffness;
}

scene::SolidSpec read_solid(const io::Section& top, double rest_length) {
  const io::Section table = top.table("solid");
  const std::string shape = table.choice("shape", {"pair", "chain", "bar", "rod"});
  const double spacing = table.number("spacing", rest_length);
  if (!(spacing > 0.0)) {
    table.fail("spacing", fmt::format("'spacing' is {}", spacing), "it is a length",
               "Give a positive number");
  }
  const double angle_stiffness = read_angle_stiffness(top);
  if (shape == "rod") {
    const double radius = table.number("radius");
    if (!(radius >= 0.0) || radius > 1000.0) {
      table.fail("radius", fmt::format("'radius' is {}", radius), "it is in spacings, from 0 to 1000",
                 "2.5 gives 21 nodes a section");
    }
    return {.shape = solid::Rod{radius, table.integer("sections", 1, most_nodes), spacing},
            .angle_stiffness = angle_stiffness};
  }
  return {.shape = solid::Block{read_nodes(table, shape), spacing}, .angle_stiffness = angle_stiffness};
}

scene::Plan read_plan(const io::Section& top, const scene::Scene& scene) {
  try {
    return scene::plan(scene);
  } catch (const BadParameter& bad) {
    fail_at(top.table("solid"), bad);
  }
}

}  // namespace veriflex::engine
