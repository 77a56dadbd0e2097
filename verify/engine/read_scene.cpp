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
  // Beyond this the numbers of nodes and bonds leave 64 bits; what fits into memory is the plan's matter.
  if (static_cast<double>(nodes[0]) * static_cast<double>(nodes[1]) * static_cast<double>(nodes[2]) >
      static_cast<double>(most_nodes)) {
    solid.fail("nodes", fmt::format("{} x {} x {} nodes are too many", nodes[0], nodes[1], nodes[2]),
               fmt::format("{} is more than any memory holds", most_nodes), "Use fewer nodes");
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

scene::SolidSpec read_solid(const io::Section& top, double spacing) {
  const io::Section table = top.table("solid");
  const std::string shape = table.choice("shape", {"pair", "chain", "bar"});
  return {.block = {.nodes = read_nodes(table, shape), .spacing = spacing},
          .lateral = table.choice("lateral", {"held", "free"}) == "held" ? scene::Lateral::held
                                                                         : scene::Lateral::free};
}

scene::Plan read_plan(const io::Section& top, const scene::Scene& scene) {
  try {
    return scene::plan(scene);
  } catch (const BadParameter& bad) {
    fail_at(top.table("solid"), bad);
  }
}

}  // namespace veriflex::engine
