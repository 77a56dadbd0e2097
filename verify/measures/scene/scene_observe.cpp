#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/error.hpp"
#include "base/memory.hpp"
#include "base/mutant.hpp"
#include "base/reduce.hpp"
#include "engine/read_scene.hpp"
#include "measures/scene/scene.hpp"

// The [[observe]] entries of a scene: what each looks at, the record that it makes, and what a check may ask
// of it.

namespace veriflex::measures {

namespace {

using observe::Column;
using observe::Record;

struct Kind {
  std::string what, title;
  observe::Series (*series)(const scene::Scene&);  // null: looks at places or nodes
};

const std::vector<Kind>& kinds() {
  static const std::vector<Kind> all{
      {"probe", "The fluid at single nodes", nullptr},
      {"line", "The fluid on a line of nodes", nullptr},
      {"plane", "The fluid on a plane of nodes", nullptr},
      {"box", "The fluid in a box of nodes", nullptr},
      {"centre line", "The nodes of a body's axis", nullptr},
      {"nodes", "Nodes of a body", nullptr},
      {"energies", "Energies of bodies and fluid", &observe::energies},
      {"momentum", "Momentum of bodies and fluid", &observe::momentum},
      {"forces", "Forces on bodies in the last step", &observe::forces},
      {"rigid motion", "Bodies as rigid ones", &observe::rigid_motion},
      {"deformation", "Principal stretches of bodies", &observe::deformation},
      {"tip", "Displacements of bodies' last sections", &observe::tips},
      {"strain", "Extreme strains of bonds", &observe::strains},
      {"slip", "Slip at the coupled nodes", &observe::slip},
      {"body snapshot", "When files of whole bodies were written", nullptr},
      {"fluid snapshot", "When files of the fluid were written", nullptr},
  };
  return all;
}

const fluid::Spec& need_fluid(const io::Table& t, const scene::Scene& scene) {
  if (!scene.fluid)
    t.fail("what", "it looks at a fluid", "the scene has none", "Add [fluid], or look at a body");
  return *scene.fluid;
}

void read_places(const io::Table& t, const scene::Scene& scene, Observation& to) {
  const Grid& grid = need_fluid(t, scene).grid;
  if (to.what == "probe") {
    to.probes = true;
    for (const io::Table& point : t.tables("point")) {
      const auto [x, y, z] = read_node(point, "node", grid);
      to.places.push_back(grid.index(x, y, z));
      if (to.places.size() > 1 && point.has("weight") == to.weights.empty()) {
        point.fail("weight", "some points have a weight and some have none",
                   "with weights they are summed, without each stands for itself",
                   "Give all of them one, or none");
      }
      if (point.has("weight")) to.weights.push_back(point.number("weight"));
    }
    if (to.places.empty())
      t.fail("point", "no point is given", "a probe looks at some",
             "Write for example point = [{ node = [0, 0, 0] }]");
  } else if (to.what == "line") {
    to.places =
        observe::line(grid, static_cast<std::size_t>(engine::read_axis(t)), read_node(t, "through", grid));
  } else if (to.what == "plane") {
    const auto normal = static_cast<std::size_t>(engine::read_axis(t));
    to.places = observe::plane(grid, normal, t.integer("at", 0, grid.size[normal] - 1));
  } else {
    const auto from = read_node(t, "from", grid), until = read_node(t, "to", grid);
    for (std::int64_t z = from[2]; z <= until[2]; ++z) {
      for (std::int64_t y = from[1]; y <= until[1]; ++y) {
        for (std::int64_t x = from[0]; x <= until[0]; ++x) to.places.push_back(grid.index(x, y, z));
      }
    }
    if (to.places.empty())
      t.fail("to", "the box holds no node", "it ends before it begins", "Exchange from and to");
  }
  to.fields = read_fields(t);
}

void read_body_nodes(const io::Table& t, const scene::Scene& scene, Observation& to) {
  std::vector<std::string> names;
  for (const scene::Body& body : scene.bodies) names.push_back(body.name);
  if (names.empty()) t.fail("what", "it looks at a body", "the scene has none", "Add a [[body]]");
  const std::string name = t.choice("body", names);
  to.body = static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  to.title += " " + name;
  const scene::Body& body = scene.bodies[to.body];
  const Positions& rest = body.network.rest;
  if (to.what == "nodes" && t.has_list("nodes")) {
    to.nodes = read_node_list(t, "nodes", rest.rows());
    return;
  }
  for (Eigen::Index i = 0; i < rest.rows(); ++i) {
    const bool on_axis = rest(i, (body.axis + 1) % 3) == 0.0 && rest(i, (body.axis + 2) % 3) == 0.0;
    if (to.what == "nodes" || on_axis) to.nodes.push_back(static_cast<std::int32_t>(i));
  }
  if (to.nodes.empty()) {
    t.fail("what", fmt::format("{} has no node on its axis", name), "the axis goes through the body's origin",
           "Use what = \"nodes\"");
  }
}

observe::Due read_due(const io::Table& t, double period) {
  if (t.has("every") && t.has("phases")) {
    t.fail("phases", "both every and phases", "either says when it is due", "Give one");
  }
  if (t.has("every")) return {static_cast<double>(t.integer("every", 1, 1'000'000'000))};
  if (!t.has("phases")) return {INFINITY};
  const std::int64_t phases = t.integer("phases", 1, 1'000'000);
  if (period == 0.0) {
    t.fail("phases", "phases of nothing", "no body of the scene is driven or oscillates",
           "Give every instead");
  }
  if (period < static_cast<double>(phases)) {
    t.fail("phases", fmt::format("{} phases of a period of {} steps", phases, period),
           "there is one look a step at most", "Ask for fewer");
  }
  return {period / static_cast<double>(phases)};
}

std::string read_name(const io::Table& t, const std::string& what, const std::vector<Observation>& before) {
  std::string name = what;
  std::replace(name.begin(), name.end(), ' ', '_');
  name = t.text("name", name);
  if (!is_plain_name(name)) {
    t.fail("name", fmt::format("'{}' is no name of a record", name), "a check asks for it as name.column",
           "Use letters, digits, _ and -");
  }
  for (const Observation& other : before) {
    if (other.name != name) continue;
    throw InputError(t.place(), fmt::format("two records are called '{}'", name),
                     "a check could not tell them apart", "Give each [[observe]] a name of its own");
  }
  return name;
}

/// `mean_from`, `reaches` and `swings`: what is asked of the columns of the observation's record in time.
void read_course(const io::Table& t, const Record& record, Observation& to) {
  for (const char* key : {"mean_from", "reaches", "swings"}) {
    if (!t.has(key) || to.is_series()) continue;
    t.fail(key, fmt::format("'{}' has many rows each time", to.what),
           "a column of a series has a course in time", "Leave it out");
  }
  if (t.has("mean_from")) {
    to.mean_from = t.number("mean_from");
    if (to.mean_from > static_cast<double>(to.last_step)) {
      t.fail("mean_from", fmt::format("the run ends at {}", to.last_step), "no row is left to be counted",
             "Let it begin earlier, or make the run longer");
    }
  }
  std::vector<std::string> names;
  for (std::size_t c = 2; c < record.columns.size(); ++c) names.push_back(record.columns[c].name);
  if (t.has("reaches")) {
    const io::Table reaches = t.table("reaches");
    to.reach = {reaches.choice("column", names), reaches.number("value"), reaches.number_if("from")};
  }
  if (t.has("swings")) {
    const io::Table swings = t.table("swings");
    to.swing = {swings.choice("column", names), swings.number("from", 0.0)};
  }
}

/// When a column first comes to a value, between two rows on the straight line  [T].
double time_of(const Record& record, const std::string& column, double value) {
  const std::vector<double>& time = record.find("time")->values;
  const std::vector<double>& values = record.find(column)->values;
  for (std::size_t i = 1; i < values.size(); ++i) {
    const double before = values[i - 1] - value, now = values[i] - value;
    if (before * now > 0.0 || now == before) continue;
    return time[i] - (time[i] - time[i - 1]) * now / (now - before);
  }
  throw NumericalFailure(
      fmt::format("{}.{} did not come to {} within {} steps", record.name, column, value, time.back()),
      FailureMode::NotConverged);
}

/// The first row from that time on.
Eigen::Index row_from(const Record& record, double from) {
  const std::vector<double>& time = record.find("time")->values;
  return std::lower_bound(time.begin(), time.end(), from) - time.begin();
}

/// The rows of whole periods of a column, and the length of one  [T]: from the first to the last time that it
/// rises through its mean.
struct Periods {
  Eigen::Index first = 0, count = 0;
  double period = 0.0;
};
Periods periods_of(const Record& record, const Observation::Swing& swing) {
  const std::vector<double>& time = record.find("time")->values;
  const std::vector<double>& values = record.find(swing.column)->values;
  const Eigen::Index begin = row_from(record, swing.from);
  const Eigen::Map<const Eigen::VectorXd> late(values.data() + begin, std::ssize(values) - begin);
  const double mean = late.size() > 0 && !planted(Mutant::swing_through_zero) ? late.mean() : 0.0;
  std::vector<double> rises;
  std::size_t first = 0, last = 0;
  for (auto i = static_cast<std::size_t>(begin) + 1; i < values.size(); ++i) {
    const double before = values[i - 1] - mean, now = values[i] - mean;
    if (!(before < 0.0 && now >= 0.0)) continue;
    rises.push_back(time[i] - (time[i] - time[i - 1]) * now / (now - before));
    if (rises.size() == 1) first = i;
    last = i;
  }
  if (rises.size() < 3) {
    throw NumericalFailure(
        fmt::format("{}.{} rises through its mean {} times from {} to {}: that is not two periods",
                    record.name, swing.column, rises.size(), swing.from, time.empty() ? 0.0 : time.back()),
        FailureMode::NotConverged);
  }
  return {static_cast<Eigen::Index>(first), static_cast<Eigen::Index>(last - first),
          (rises.back() - rises.front()) /
              static_cast<double>(rises.size() - (planted(Mutant::period_of_one_more) ? 0 : 1))};
}

double time_of(const Record& record, const Observation::Reach& reach) {
  const double until = time_of(record, reach.column, reach.value);
  return reach.from ? until - time_of(record, reach.column, *reach.from) : until;
}

std::size_t rows_of(const Observation& o) {
  return o.is_series() || o.is_snapshot ? 1 : std::max(o.places.size(), o.nodes.size());
}

void append_now(const Observation& o, const scene::Simulation& simulation, Record& record) {
  const auto step = static_cast<double>(simulation.steps());
  if (!o.places.empty()) {
    const Record now = observe::at_nodes(simulation.fluid(), o.places, o.fields, "", "");
    std::vector<double> row{step, step};
    if (!o.weights.empty()) {
      for (std::size_t c = 3; c < now.columns.size(); ++c) {
        row.push_back(
            std::inner_product(o.weights.begin(), o.weights.end(), now.columns[c].values.begin(), 0.0));
      }
      record.append(row);
      return;
    }
    for (std::size_t i = 0; i < o.places.size(); ++i) {
      if (!o.probes) row = {step, step};
      for (std::size_t c = o.probes ? 3 : 0; c < now.columns.size(); ++c) {
        row.push_back(now.columns[c].values[i]);
      }
      if (!o.probes) record.append(row);
    }
    if (o.probes) record.append(row);
    return;
  }
  const Positions X = simulation.body(o.body).positions();
  for (const std::int32_t node : o.nodes) {
    record.append({step, step, static_cast<double>(node), X(node, 0), X(node, 1), X(node, 2)});
  }
}

}  // namespace

std::array<std::int64_t, 3> read_node(const io::Table& table, const std::string& key, const Grid& grid) {
  const std::vector<std::int64_t> at = table.integers(key);
  bool inside = at.size() == 3;
  for (std::size_t i = 0; inside && i < 3; ++i) inside = at[i] >= 0 && at[i] < grid.size[i];
  if (!inside) {
    table.fail(key, fmt::format("'{}' is no node of the box", key),
               fmt::format("its nodes are numbered from 0 to {}, {} and {}", grid.size[0] - 1,
                           grid.size[1] - 1, grid.size[2] - 1),
               fmt::format("Write for example {} = [0, 0, 0]", key));
  }
  return {at[0], at[1], at[2]};
}

observe::Fields read_fields(const io::Table& t) {
  observe::Fields fields{.density = true, .velocity = true, .stress = false};
  if (!t.has("fields")) return fields;
  fields = {};
  for (const std::string& field : t.texts("fields")) {
    if (field == "density") fields.density = true;
    if (field == "velocity") fields.velocity = true;
    if (field == "stress") fields.stress = true;
    if (field != "density" && field != "velocity" && field != "stress") {
      t.fail("fields", fmt::format("'fields' lists '{}'", field), "a fluid has density, velocity and stress",
             "List one or more of these");
    }
  }
  return fields;
}

std::vector<Observation> read_observations(const io::Table& top, const scene::Scene& scene, double period,
                                           std::int64_t steps) {
  std::vector<Observation> all;
  std::vector<std::string> whats;
  for (const Kind& kind : kinds()) whats.push_back(kind.what);
  double bytes = 0.0;
  for (const io::Table& t : top.tables("observe")) {
    Observation o;
    o.what = t.choice("what", whats);
    const Kind& kind =
        *std::find_if(kinds().begin(), kinds().end(), [&](const Kind& k) { return k.what == o.what; });
    o.name = read_name(t, o.what, all);
    o.title = kind.title;
    o.series = kind.series;
    o.due = read_due(t, period);
    o.last_step = steps;
    if (o.series != nullptr) {
      if (o.series(scene).columns.empty()) {
        t.fail("what", fmt::format("'{}' has nothing to look at", o.what), "the scene lacks what it is of",
               "Leave it out");
      }
    } else if (o.what == "body snapshot") {
      read_body_snapshot(t, scene, o);
    } else if (o.what == "fluid snapshot") {
      need_fluid(t, scene);
      read_fluid_snapshot(t, scene, o);
    } else if (o.what == "centre line" || o.what == "nodes") {
      read_body_nodes(t, scene, o);
    } else {
      read_places(t, scene, o);
    }
    read_course(t, empty_record(o, scene), o);
    const double looks = 2.0 + static_cast<double>(steps) / o.due.interval;
    const auto columns = static_cast<double>(empty_record(o, scene).columns.size());
    bytes += 8.0 * looks * static_cast<double>(rows_of(o)) * columns;
    if (bytes > 0.5 * available_memory_bytes()) {
      throw InputError(t.place(), fmt::format("the records take {:.3g} GB", bytes * 1e-9),
                       "they are kept in memory until the run ends", "Look less often, or at less");
    }
    all.push_back(std::move(o));
  }
  return all;
}

Record empty_record(const Observation& o, const scene::Scene& scene) {
  Record record{o.name,
                o.title,
                {{"step", "", "1", "steps made", {}}, {"time", "t", "T", "the same: a step takes 1", {}}}};
  const auto add = [&](const std::vector<Column>& columns, const std::string& suffix) {
    for (Column column : columns) {
      column.name += suffix;
      record.columns.push_back(column);
    }
  };
  if (o.is_snapshot) return record;
  if (o.series != nullptr) {
    add(o.series(scene).columns, "");
  } else if (o.probes) {
    std::vector<Column> columns = observe::columns_of(o.fields);
    columns.erase(columns.begin(), columns.begin() + 3);  // the node's place, which stands in the case
    const bool one = o.places.size() == 1 || !o.weights.empty();
    for (std::size_t i = 0; i < (one ? 1 : o.places.size()); ++i)
      add(columns, one ? "" : fmt::format("_{}", i));
  } else if (!o.places.empty()) {
    add(observe::columns_of(o.fields), "");
  } else {
    add({{"node", "", "1", "number of the node", {}},
         {"x", "x", "L", "in the box, not wrapped", {}},
         {"y", "y", "L", "in the box, not wrapped", {}},
         {"z", "z", "L", "in the box, not wrapped", {}}},
        "");
  }
  return record;
}

std::vector<std::string> measures_of(const Observation& o, const scene::Scene& scene) {
  std::vector<std::string> measures;
  for (const Column& column : empty_record(o, scene).columns) {
    const std::string name = o.name + "." + column.name;
    measures.push_back(name);
    if (!o.is_series() || column.name == "step" || column.name == "time") continue;
    for (const char* of : {".last", ".mean", ".min", ".max"}) measures.push_back(name + of);
    if (o.reach && o.reach->column == column.name) measures.push_back(name + ".reached");
    if (!o.swing) continue;
    for (const char* of : {".swing_mean", ".swing_min", ".swing_max"}) measures.push_back(name + of);
    if (o.swing->column == column.name) measures.push_back(name + ".period");
  }
  return measures;
}

std::shared_ptr<std::vector<double>> add_observers(const Observation& o, const scene::Scene& scene,
                                                   std::vector<Record>& records, std::size_t at,
                                                   std::vector<observe::Observer>& observers) {
  if (o.is_snapshot) {
    observers.push_back({o.due, [&records, at, o](const scene::Simulation& simulation) {
                           const auto step = static_cast<double>(simulation.steps());
                           records[at].append({step, step});
                           hand_over_snapshot(o, simulation, records[at].columns.front().values);
                         }});
    return nullptr;
  }
  if (o.series == nullptr) {
    observers.push_back(
        {o.due,
         [&records, at, o](const scene::Simulation& simulation) { append_now(o, simulation, records[at]); },
         o.places.empty()});
    return nullptr;
  }
  const observe::Series series = o.series(scene);
  if (series.every_step) observers.push_back({observe::Due{1.0}, series.every_step, series.at_bodies});
  observers.push_back({o.due,
                       [&records, at, series](const scene::Simulation& simulation) {
                         if (simulation.steps() == 0 && !series.from_start) return;
                         std::vector<double> row = series.row(simulation);
                         const auto step = static_cast<double>(simulation.steps());
                         row.insert(row.begin(), {step, step});
                         records[at].append(row);
                       },
                       series.at_bodies});
  return series.memory;
}

std::vector<observe::Metric> metrics_of(const Observation& o, const Record& record) {
  std::vector<observe::Metric> metrics;
  if (!o.is_series()) return metrics;
  const Periods periods = o.swing ? periods_of(record, *o.swing) : Periods{};
  const Eigen::Index first = row_from(record, o.mean_from);
  for (std::size_t c = 2; c < record.columns.size(); ++c) {
    const Column& column = record.columns[c];
    const Eigen::Map<const Eigen::VectorXd> values(column.values.data(), std::ssize(column.values));
    const std::string name = fmt::format("{}.{}", o.name, column.name);
    metrics.push_back({name + ".last", column.values.back(), column.dimension, column.meaning});
    const auto counted = values.tail(values.size() - first);
    metrics.push_back({name + ".mean", counted.mean(), column.dimension, "mean over the rows"});
    metrics.push_back({name + ".min", smallest(counted), column.dimension, "least of the rows"});
    metrics.push_back({name + ".max", largest(counted), column.dimension, "largest of the rows"});
    if (o.reach && o.reach->column == column.name) {
      metrics.push_back({name + ".reached", time_of(record, *o.reach), "T",
                         fmt::format("when it first was {}", o.reach->value) +
                             (o.reach->from ? fmt::format(", since it was {}", *o.reach->from) : "")});
    }
    if (!o.swing) continue;
    const auto whole = values.segment(periods.first, periods.count);
    metrics.push_back({name + ".swing_mean", whole.mean(), column.dimension, "mean over whole periods"});
    metrics.push_back({name + ".swing_min", smallest(whole), column.dimension, "least in whole periods"});
    metrics.push_back({name + ".swing_max", largest(whole), column.dimension, "largest in whole periods"});
    if (o.swing->column == column.name)
      metrics.push_back({name + ".period", periods.period, "T", "mean, between rises through its mean"});
  }
  return metrics;
}

}  // namespace veriflex::measures
