#include "measures/at_once.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <cstddef>

#include "base/memory.hpp"

namespace veriflex::measures {

namespace {

struct Need {
  const fluid::Spec* run;
  double fluid, beside;  // [bytes]
};

scene::Plan plan_of(const io::Table& top, const std::vector<fluid::Spec>& runs, std::size_t at_once,
                    const Beside& beside, double kept) {
  std::vector<Need> needs;
  for (const fluid::Spec& run : runs) {
    engine::check_representation(top, run);
    needs.push_back({&run, fluid::memory_bytes(run) + fluid::start_bytes(run), beside ? beside(run) : 0.0});
  }
  std::stable_sort(needs.begin(), needs.end(),
                   [](const Need& a, const Need& b) { return a.fluid + a.beside > b.fluid + b.beside; });
  scene::Plan plan = engine::read_plan(top, {.fluid = *needs.front().run});
  needs.resize(std::min(needs.size(), at_once));
  double fluids = 0.0, others = kept;
  for (const Need& need : needs) {
    fluids += need.fluid;
    others += need.beside;
  }
  if (const double available = available_memory_bytes(); fluids + others > available) {
    const io::Table fluid = top.table("fluid");
    const std::string problem = fmt::format("{} runs at once do not fit into memory", needs.size());
    const std::string why = fmt::format("they take {:.3g} GB, {:.3g} GB are available",
                                        (fluids + others) * 1e-9, available * 1e-9);
    const std::string suggestion = "Use fewer threads or smaller boxes";
    if (fluid.has("nodes")) fluid.fail("nodes", problem, why, suggestion);
    throw InputError(fluid.place(), problem, why, suggestion);
  }
  for (scene::Built& built : plan.built) {
    if (built.module != "fluid") continue;
    if (runs.size() > 1) {
      built.what += fmt::format("; the largest of {} runs, {} at a time", runs.size(), needs.size());
    }
    built.memory_bytes = fluids;
  }
  if (others > 0.0) plan.built.push_back({"observations", "what is kept of the flow to be compared", others});
  return plan;
}

}  // namespace

scene::Plan plan_at_once(const io::Table& top, const std::vector<fluid::Spec>& runs, const Beside& beside,
                         double kept) {
  return plan_of(top, runs, static_cast<std::size_t>(omp_get_max_threads()), beside, kept);
}

scene::Plan plan_in_turn(const io::Table& top, const std::vector<fluid::Spec>& runs, double kept) {
  return plan_of(top, runs, 1, {}, kept);
}

}  // namespace veriflex::measures
