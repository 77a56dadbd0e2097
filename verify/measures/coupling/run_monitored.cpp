#include "measures/coupling/run_monitored.hpp"

#include <fmt/format.h>

#include "observe/interrupted.hpp"

namespace veriflex::measures {

void run_monitored(const fluid::Fluid& fluid, const observe::MonitorSpec& monitor, const std::string& name,
                   const Steps& steps, const std::function<std::vector<observe::Record>()>& state) {
  observe::Observations good;
  const auto check = [&] {
    const fluid::Extremes seen = observe::check(fluid, monitor);
    good.metrics = observe::last_good(fluid.steps(), seen);
    if (state) good.records = state();
  };
  try {
    check();
    steps([&] {
      if (fluid.steps() % monitor.every == 0) check();
    });
    check();
  } catch (const NumericalFailure& failure) {
    throw observe::Interrupted(NumericalFailure(fmt::format("{}: {}", name, failure.what()), failure.mode),
                               std::move(good));
  }
}

observe::Record last_good_nodes(const Positions& X, const std::string& whose) {
  observe::Record nodes{"last_good_nodes",
                        "Where the nodes were at the last good check, " + whose,
                        {{"node", "", "1", "number of the node", {}},
                         {"x", "", "L", "in the box, not wrapped", {}},
                         {"y", "", "L", "along the body at rest", {}},
                         {"z", "", "L", "along the drive or the stream", {}}}};
  for (Eigen::Index i = 0; i < X.rows(); ++i)
    nodes.append({static_cast<double>(i), X(i, 0), X(i, 1), X(i, 2)});
  return nodes;
}

}  // namespace veriflex::measures
