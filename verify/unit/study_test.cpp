// Studies over any case: the grid, the numbers of its table, and rows as programs of their own.
#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "base/work.hpp"
#include "catch.hpp"
#include "engine/asked.hpp"
#include "engine/case.hpp"
#include "engine/reference.hpp"
#include "io/file.hpp"
#include "io/hdf5.hpp"
#include "repository.hpp"
#include "studies/front.hpp"
#include "studies/grid.hpp"
#include "studies/numbers.hpp"
#include "studies/studies.hpp"
#include "unit/command.hpp"

using namespace veriflex;
using namespace veriflex::studies;

namespace fs = std::filesystem;
using Json = nlohmann::json;
using unit::Folder;
using unit::Ran;

namespace {

std::vector<Axis> axes_of(const std::string& toml) {
  return read_axes(io::parse_document(toml, "study.toml"));
}

engine::Asked asked(const std::string& toml) {
  return engine::read_asked(io::parse_document(toml, "check.toml"));
}

// error = factor h^2 with h = 1/n, for two factors.
observe::Record table_of_errors() {
  observe::Record table{"sweep",
                        "",
                        {{"a.factor", "", "1", "", {}},
                         {"a.n", "", "1", "", {}},
                         {"kind", "", "1", "", {}},
                         {"error", "", "L", "", {}},
                         {"value", "", "L", "", {}}}};
  for (const double factor : {1.0, 3.0}) {
    for (const double n : {8.0, 16.0, 32.0}) {
      table.columns[0].values.push_back(factor);
      table.columns[1].values.push_back(n);
      table.columns[2].texts.push_back(factor == 1.0 ? "plain" : "tripled");
      table.columns[3].values.push_back(factor / (n * n));
      table.columns[4].values.push_back(5.0 + factor / (n * n));
    }
  }
  return table;
}

double number_of(const std::string& check) { return number(asked(check), table_of_errors()).value; }

const std::string bar_case = [] {
  std::string text = unit::replaced(unit::good_case, "id = \"bad\"", "id = \"bar\"");
  text = unit::replaced(text, "law = \"fene-lj\"\nepsilon = 1.0\nsigma = 1.0",
                        "law = \"harmonic\"\nbond_stiffness = 0.26\nrest_length = 1.0");
  return text.substr(0, text.find("[[check]]"));
}();
Ran ran(const Folder& folder, const std::string& words) { return folder.shell("\"$V\" " + words); }

/// What a command with --json has made.
io::Hdf5File result_of(const Folder& folder, const Ran& made) {
  return io::Hdf5File(folder.path() / Json::parse(made.out)[0]["result"].get<std::string>());
}

/// Puts a text of the same length into a result file, and a checksum that it matches.
void reseal(const fs::path& path, const std::string& from, const std::string& to) {
  constexpr std::size_t seal_size = 512;
  std::string all = unit::contents(path);
  for (std::size_t at = all.find(from); at != std::string::npos; at = all.find(from, at + 1))
    all.replace(at, from.size(), to);
  const std::size_t sum = all.find("sha256 ") + 7;
  all.replace(sum, 64, io::sha256(std::string_view(all).substr(seal_size)));
  std::ofstream(path, std::ios::binary) << all;
}

/// A row that says it is that one, with two metrics and so many values of them.
std::vector<char> made_row(const fs::path& path, std::size_t values) {
  const io::Hdf5File row(path);
  io::Hdf5Image image;
  image.text("/case", row.texts("/case")[0]);
  image.attribute("/", "variant", row.attribute("/", "variant"));
  image.attribute("/", "outcome", std::string("completed"));
  image.group("/provenance");
  image.attribute("/provenance", "program", row.attribute("/provenance", "program"));
  image.attribute("/provenance", "peak_memory_bytes", std::int64_t{1});
  image.texts("/metrics/name", {"made", "up"});
  image.texts("/metrics/dimension", {"1", "1"});
  image.texts("/metrics/meaning", {"", ""});
  image.numbers("/metrics/value", std::vector<double>(values));
  for (const char* column : {"/repeats/wall_seconds", "/repeats/cpu_seconds", "/timing/wall_seconds",
                             "/timing/cpu_seconds", "/parts/count", "/parts/memory_bytes"}) {
    image.numbers(column, {});
  }
  image.texts("/parts/part", {});
  image.attribute("/parts", "peak_bytes", std::int64_t{0});
  image.group("/work");
  for (const work::Field& field : work::fields) image.attribute("/work", field.name, std::int64_t{0});
  return image.bytes();
}

}  // namespace

TEST_CASE("A grid has every combination once, the last axis fastest") {
  const std::vector<Axis> axes = axes_of(
      "axes = [{ key = \"a.x\", values = [1, 2] }, { keys = [\"b.n\", \"b.t\"], values = [[16, 0.5], [32, "
      "0.25], [64, 0.125]] }]");
  const std::vector<Cell> all = cells(axes);
  REQUIRE(all.size() == 6);
  CHECK(settings(axes, all[0]) == std::vector<std::string>{"a.x=1", "b.n=16", "b.t=0.5"});
  CHECK(settings(axes, all[1]) == std::vector<std::string>{"a.x=1", "b.n=32", "b.t=0.25"});
  CHECK(settings(axes, all[5]) == std::vector<std::string>{"a.x=2", "b.n=64", "b.t=0.125"});
  CHECK(axes[1].numbers == std::vector<double>{16.0, 32.0, 64.0});
}

TEST_CASE("Axes that no run could follow are refused with their place") {
  CHECK_THROWS_WITH(axes_of("axes = [{ key = \"a\", values = [] }]"), ContainsSubstring("study.toml:1:"));
  CHECK_THROWS_WITH(axes_of("axes = [{ key = \"a\", values = [1, 1] }]"), ContainsSubstring("twice"));
  CHECK_THROWS_WITH(axes_of("axes = [{ key = \"a\", values = [1] }, { key = \"a\", values = [2] }]"),
                    ContainsSubstring("two axes"));
  CHECK_THROWS_WITH(axes_of("axes = [{ keys = [\"a\", \"b\"], values = [[1, 2, 3]] }]"),
                    ContainsSubstring("list of 2"));
}

TEST_CASE("Spacings: a resolution that rises, a spacing that falls") {
  CHECK(spacings({8.0, 16.0}) == std::vector<double>{0.125, 0.0625});
  CHECK(spacings({0.5, 0.25}) == std::vector<double>{0.5, 0.25});
  CHECK(spacings({1.0, 3.0, 2.0}).empty());
  CHECK(spacings({-1.0, 1.0}).empty());
}

TEST_CASE("Numbers of a table are those of its definition") {
  CHECK(number_of("metric = \"error\"\nwhere = { \"a.factor\" = 3.0, \"a.n\" = 16 }") == 3.0 / 256.0);
  CHECK(number_of("metric = \"error\"\nwhere = { kind = \"plain\", \"a.n\" = 8 }") == 1.0 / 64.0);
  CHECK(number_of("metric = \"error\"\nof = \"max\"") == 3.0 / 64.0);
  CHECK(number_of("metric = \"error\"\nof = \"min\"\nwhere = { \"a.factor\" = 3 }") == 3.0 / 1024.0);
  CHECK(number_of("metric = \"error\"\nof = \"mean\"\nwhere = { \"a.n\" = 8 }") == Approx(2.0 / 64.0));
  CHECK(number_of("metric = \"error\"\nof = \"order\"\nalong = \"a.n\"\nwhere = { \"a.factor\" = 1.0 }") ==
        Approx(2.0));
  CHECK(number_of("metric = \"error\"\nof = \"exponent\"\nalong = \"a.n\"\nwhere = { \"a.factor\" = 3 }") ==
        Approx(-2.0));
  CHECK(number_of("metric = \"value\"\nof = \"richardson\"\nalong = \"a.n\"\nwhere = { \"a.factor\" = 3 }") ==
        Approx(5.0));
  CHECK(number_of("metric = \"value\"\nof = \"richardson\"\nalong = \"a.n\"\norder = 2\nwhere = { "
                  "\"a.factor\" = 3 }") == Approx(5.0));
  CHECK(number_of("metric = \"error\"\nof = \"ratio\"\nwhere = { \"a.factor\" = 3.0, \"a.n\" = 8 }\nover = { "
                  "\"a.factor\" = 1 }") == Approx(3.0));
}

TEST_CASE("A number of a study is called by all that it asks") {
  CHECK(asked("metric = \"e\"\nof = \"order\"\nalong = \"a.n\"\nwhere = { \"a.f\" = 1 }").name() ==
        "order(e) along a.n at a.f = 1");
  CHECK(asked("metric = \"e\"\nof = \"ratio\"\nwhere = { a = 1, b = 2 }\nover = { a = 3 }").name() ==
        "ratio(e) at a = 1, b = 2 over a = 3");
}

TEST_CASE("The numerical uncertainty of a row or of a limit is the convergence index along an axis") {
  const std::string check = "metric = \"value\"\nwhere = { \"a.factor\" = 3, \"a.n\" = 32 }\n";
  const auto index = [](const std::string& text) {
    return engine::read_asked_gci(io::parse_document(text, "study.toml"));
  };
  const auto observed = index(check + "uncertainty = { gci_along = \"a.n\" }");
  REQUIRE(observed);
  CHECK(observed->name() == "gci(value) along a.n at a.factor = 3");
  CHECK(number(*observed, table_of_errors()).value == Approx(1.25 * 3.0 / 1024.0));
  const auto known = index(check + "uncertainty = { gci_along = \"a.n\", gci_order = 2 }");
  REQUIRE(known);
  CHECK(known->name() == "gci(value) along a.n of order 2 at a.factor = 3");
  CHECK(number(*known, table_of_errors()).value == Approx(3.0 * 3.0 / 1024.0));
  CHECK_FALSE(index(check + "uncertainty = { numerical = 0.1 }"));
  CHECK_FALSE(index("metric = \"value\"\nof = \"max\"\nuncertainty = { gci_along = \"a.n\" }"));
}

TEST_CASE("A curve has the number at each value of the axis across") {
  const engine::Asked asked_for = asked(
      "curve = { record = \"sweep\", x = \"a.factor\", y = \"value\" }\nof = \"richardson\"\nalong = "
      "\"a.n\"");
  const observe::Record curve = numbers_across(asked_for, table_of_errors());
  REQUIRE(curve.columns.size() == 2);
  CHECK(curve.columns[0].name == "factor");
  CHECK(curve.columns[0].values == std::vector<double>{1.0, 3.0});
  REQUIRE(curve.columns[1].name == "value");
  CHECK(curve.columns[1].values[0] == Approx(5.0));
  CHECK(curve.columns[1].values[1] == Approx(5.0));
}

TEST_CASE("What a table does not give is said, never guessed") {
  CHECK_THROWS_WITH(number_of("metric = \"error\""), ContainsSubstring("6 rows are meant"));
  CHECK_THROWS_WITH(number_of("metric = \"error\"\nof = \"order\"\nalong = \"a.n\""),
                    ContainsSubstring("several rows"));
  CHECK_THROWS_WITH(number_of("metric = \"error\"\nwhere = { \"a.n\" = 9 }"),
                    ContainsSubstring("no such row"));
  observe::Record table = table_of_errors();
  table.columns[3].values[2] = NAN;
  CHECK_THROWS_WITH(
      number(asked("metric = \"error\"\nof = \"order\"\nalong = \"a.n\"\nwhere = { \"a.factor\" = 1 }"),
             table),
      ContainsSubstring("has no value"));
  CHECK(std::isnan(number(asked("metric = \"error\"\nof = \"max\""), table).value));
}

TEST_CASE("An axis of which a value is no number gives no order and no curve, and says so") {
  observe::Record table = table_of_errors();
  table.columns[1].values.clear();
  table.columns[1].texts = {"nan", "16", "32", "nan", "16", "32"};
  const std::string pinned = "metric = \"error\"\nalong = \"a.n\"\nwhere = { \"a.factor\" = 1 }\n";
  for (const char* of : {"order", "richardson", "gci", "exponent"}) {
    INFO(of);
    CHECK_THROWS_WITH(number(asked(pinned + "of = \"" + of + "\""), table),
                      ContainsSubstring("not all values of a.n are numbers"));
  }
  CHECK_THROWS_WITH(
      numbers_across(asked("curve = { record = \"sweep\", x = \"a.n\", y = \"value\" }\nof = \"mean\""),
                     table),
      ContainsSubstring("not all values of a.n are numbers"));
}

TEST_CASE("A check that asks a study for what it cannot have is refused at its place") {
  const Folder folder;
  folder.write("bar.toml",
               bar_case +
                   "[sweep]\naxes = [{ key = \"bond.bond_stiffness\", values = [0.1, 0.2] }]\n"
                   "[[check]]\nkind = \"verification\"\nstatement = \"E = k/r0\"\nmetric = "
                   "\"young_modulos\"\nof = \"max\"\n"
                   "target = 0.2\ntarget_kind = \"analytic\"\nsource = \"x\"\ntolerance = { absolute = "
                   "1e-9, reason = \"x\" }\n");
  const Ran ran_it = ran(folder, "validate bar.toml");
  CHECK(ran_it.code == 2);
  CHECK_THAT(ran_it.err,
             ContainsSubstring("bar.toml:") && ContainsSubstring("Did you mean 'young_modulus'?"));
}

TEST_CASE("The front has the rows that no other beats, by rising work") {
  //                      beaten by 1    the cheapest   alike          did not end    the best
  const std::vector<Priced> rows{{0.5, 2.0}, {0.5, 1.0},  {0.1, 3.0}, {0.1, 3.0},
                                 {NAN, 0.0}, {0.01, 9.0}, {0.2, 9.0}};
  CHECK(front(rows) == std::vector<std::size_t>{1, 2, 5});
  CHECK(front({}).empty());
  CHECK(front({{NAN, 1.0}, {INFINITY, 1.0}}).empty());
  CHECK(front({{1.0, 5.0}, {0.5, 5.0}}) == std::vector<std::size_t>{1});
}

TEST_CASE("Each value is the cheapest for the errors that the front says, and costs more elsewhere") {
  // Two storages: the coarse one has half the work, and does not come below an error of 0.04.
  PricedGrid grid{
      axes_of("axes = [{ key = \"s\", values = [\"float\", \"double\"] }, { key = \"n\", values = "
              "[1, 10, 100] }]"),
      {},
      {{0.5, 1.0}, {0.05, 10.0}, {0.04, 100.0}, {0.5, 2.0}, {0.05, 20.0}, {0.005, 200.0}},
      {"error", "", "1", "", {}},
      {"work", "", "1", "", {}}};
  grid.cells = cells(grid.axes);
  const std::vector<observe::Record> records = front_records("sweep", grid);
  REQUIRE(records.size() == 3);
  CHECK(records[0].find("s")->texts == std::vector<std::string>{"float", "float", "float", "double"});

  const observe::Record& settings = records[1];
  CHECK(settings.find("value")->texts == std::vector<std::string>{"float", "double", "1", "10", "100"});
  CHECK(settings.find("cheapest_from")->values == std::vector<double>{0.04, 0.005, 0.5, 0.05, 0.005});
  CHECK(settings.find("cheapest_below")->values[0] == INFINITY);
  CHECK(settings.find("cheapest_below")->values[1] == 0.04);
  CHECK(settings.find("work_over_cheapest")->values == std::vector<double>{1.0, 1.0, 1.0, 1.0, 1.0});

  const observe::Record& reached = records[2];
  CHECK(reached.find("asked")->values[0] == 0.1);
  CHECK(reached.find("work")->values[0] == 10.0);
  CHECK(reached.find("next_step")->texts[0] == "n = 100");
  CHECK(reached.find("next_error")->values[0] == 0.04);
  CHECK(reached.find("asked")->values[1] == 0.01);
  CHECK(reached.find("next_step")->texts[1] == "nothing on this grid");
  CHECK(reached.columns.front().size() == 2);
}

TEST_CASE("A value that is never the cheapest says how much it costs at best") {
  PricedGrid grid{axes_of("axes = [{ key = \"k\", values = [1, 2] }]"),
                  {{0}, {1}},
                  {{0.1, 1.0}, {0.1, 3.0}},
                  {"error", "", "1", "", {}},
                  {"work", "", "1", "", {}}};
  const observe::Record settings = front_records("sweep", grid)[1];
  CHECK(std::isnan(settings.find("cheapest_from")->values[1]));
  CHECK(settings.find("work_over_cheapest")->values[1] == 3.0);
}

TEST_CASE("A sweep that is asked for an error has its front, and timed rows have repeats") {
  const Folder folder;
  folder.write("bar.toml", bar_case);
  const Ran ran_it =
      ran(folder,
          "sweep bar.toml --over solid.nodes='[3, 3, 6],[3, 3, 9]' --error young_modulus --timed "
          "--repeats 2 --json --out out");
  REQUIRE(ran_it.code == 0);
  const io::Hdf5File file = result_of(folder, ran_it);
  CHECK(file.numbers("/records/sweep_front/bytes_moved").size() >= 1);
  CHECK(file.numbers("/records/sweep_cost_front/wall_seconds").size() >= 1);
  const std::vector<double> least = file.numbers("/records/sweep_cost/min_wall_seconds");
  const std::vector<double> middle = file.numbers("/records/sweep_cost/wall_seconds");
  const std::vector<double> most = file.numbers("/records/sweep_cost/max_wall_seconds");
  CHECK(least[0] > 0.0);
  CHECK(middle[0] == Approx((least[0] + most[0]) / 2));
  // Without an exact value the last row stands for it: of 0.1, 0.2 and 0.4, a quarter and a half of the last.
  const Ran finest = ran(folder,
                         "sweep bar.toml --over bond.bond_stiffness=0.1,0.2,0.4 --error young_modulus "
                         "--against-finest --json --out out");
  REQUIRE(finest.code == 0);
  const io::Hdf5File against = result_of(folder, finest);
  const std::vector<double> errors = against.numbers("/records/sweep/error");
  CHECK(errors[0] == Approx(0.75));
  CHECK(errors[1] == Approx(0.5));
  CHECK(std::isnan(errors[2]));
  // Of a study of which no run can be read, the reader is told, not the missing error.
  const Ran unread =
      ran(folder, "sweep bar.toml --over bond.bond_stiffness=-1,-2 --error young_modulus --out out");
  CHECK(unread.code == 2);
  CHECK_THAT(unread.err, ContainsSubstring("no run of the study can be read"));
  // A part of the grid has no front, and no finest row.
  CHECK(ran(folder,
            "sweep bar.toml --over bond.bond_stiffness=0.1,-1 --error young_modulus --against-finest "
            "--shard 1/2 --out part")
            .code == 0);
  // A row that shares the finest value of an axis hides its error along it.
  const Ran two = ran(folder,
                      "sweep bar.toml --over bond.bond_stiffness=0.1,0.2 --over 'solid.nodes.2=6,9' "
                      "--error young_modulus --against-finest --json --out out");
  REQUIRE(two.code == 0);
  const io::Hdf5File pair = result_of(folder, two);
  const std::vector<double> judged = pair.numbers("/records/sweep/error");
  CHECK(judged[0] == Approx(0.5));
  CHECK(std::count_if(judged.begin(), judged.end(), [](double e) { return std::isnan(e); }) == 3);
  CHECK_THAT(ran(folder, "sweep bar.toml --over bond.bond_stiffness=0.1,0.2 --repeats 2 --out out").err,
             ContainsSubstring("the rows are not timed"));
  CHECK_THAT(ran(folder, "sweep bar.toml --over bond.bond_stiffness=0.1,0.2 --error young --out out").err,
             ContainsSubstring("young_modulus"));
}

TEST_CASE("The error of a row may be that of a curve against a reference") {
  const Folder folder;
  const std::string points = "strain,stress\n0.01,0.0026\n0.02,0.0052\n";
  folder.write("springs.csv", points);
  folder.write("springs.toml",
               "schema = 1\nid = \"springs\"\nkind = \"analytic\"\nsource = \"E = k/r0\"\n"
               "obtained = \"by hand\"\n[data]\nfile = \"springs.csv\"\nsha256 = \"" +
                   io::sha256(points) + "\"\n");
  const auto swept = [&](const std::string& curve) {
    folder.write("bar.toml",
                 std::string(bar_case) +
                     "[sweep]\naxes = [{ key = \"bond.bond_stiffness\", values = [0.13, -1, 0.26] }]\n"
                     "curve_error = { record = \"stress_strain\", x = \"strain\", " +
                     curve + " }\n");
    return ran(folder, "run bar.toml --set 'tensile.strains=[0.01, 0.02]' --json --out out");
  };
  const Ran good = swept("y = \"stress\", reference = \"springs\", floor = 0.0");
  REQUIRE(good.code == 0);
  const io::Hdf5File file = result_of(folder, good);
  const std::vector<double> error = file.numbers("/records/sweep/error");
  CHECK(error[0] == Approx(0.5));
  CHECK(std::isnan(error[1]));  // a row that no run made
  CHECK(error[2] < 1e-9);
  CHECK_THAT(swept("y = \"pull\", reference = \"springs\", floor = 0.0").err,
             ContainsSubstring("no run of this case records 'stress_strain.pull'"));
  CHECK_THAT(swept("y = \"residual\", reference = \"springs\", floor = 0.0").err,
             ContainsSubstring("has no column 'residual'"));
  CHECK_THAT(swept("y = \"stress\", reference = \"sprongs\", floor = 0.0").err, ContainsSubstring("sprongs"));
}

TEST_CASE("A case that was not swept is advised by the sweep that is most like it") {
  const Folder folder;
  folder.write("bar.toml", bar_case);
  folder.write("longer.toml", unit::replaced(unit::replaced(bar_case, "id = \"bar\"", "id = \"longer\""),
                                             "[2, 2, 4]", "[2, 2, 6]"));
  const std::string advise = "advise longer.toml --error 1 --json --out out";
  const Ran nothing = ran(folder, advise);
  CHECK(nothing.code == 2);
  CHECK_THAT(nothing.err, ContainsSubstring("no result in out can advise it"));
  REQUIRE(ran(folder,
              "sweep bar.toml --over bond.bond_stiffness=0.1,0.2,0.4,0.8 --error young_modulus --timed --out "
              "out")
              .code == 0);
  const Ran advised = ran(folder, advise);
  REQUIRE(advised.code == 0);
  const Json advice = Json::parse(advised.out);
  CHECK(advice["case"] == "bar");
  REQUIRE(advice["differences"].size() == 1);
  CHECK(advice["differences"][0] == "solid.nodes: [ 2, 2, 4 ], here [ 2, 2, 6 ]");
  // Of another law the sweep says nothing.
  folder.write("longer.toml", unit::replaced(unit::good_case, "id = \"bad\"", "id = \"longer\""));
  CHECK(ran(folder, advise).code == 2);
}

TEST_CASE("A sweep of the command line has a row per run, also of one that fails, and keeps them") {
  const Folder folder;
  folder.write("bar.toml", bar_case);
  const std::string words = "sweep bar.toml --over bond.bond_stiffness=0.13,-1,0.26 --out out --json";
  const Ran first = ran(folder, words);
  REQUIRE(first.code == 0);
  const io::Hdf5File file = result_of(folder, first);
  CHECK(file.texts("/records/sweep/outcome") ==
        std::vector<std::string>{"completed", "refused", "completed"});
  const std::vector<double> modulus = file.numbers("/records/sweep/young_modulus");
  CHECK(modulus[0] == Approx(0.13).epsilon(1e-9));
  CHECK(std::isnan(modulus[1]));
  CHECK(modulus[2] == Approx(0.26).epsilon(1e-9));
  CHECK_THAT(file.texts("/records/sweep/message")[1], ContainsSubstring("bond_stiffness"));
  CHECK(file.numbers("/records/sweep/bond_evaluations")[0] > 0.0);

  // Run again: rows are read, not run. Changed, they are run.
  const auto rows = [&] {
    std::vector<fs::file_time_type> times;
    for (const fs::directory_entry& folder_of_rows : fs::directory_iterator(folder.path() / "out")) {
      if (!folder_of_rows.is_directory()) continue;
      for (const fs::directory_entry& row : fs::directory_iterator(folder_of_rows.path()))
        times.push_back(row.last_write_time());
    }
    std::sort(times.begin(), times.end());
    return times;
  };
  const auto before = rows();
  REQUIRE(before.size() == 3);
  CHECK(ran(folder, words).code == 0);
  CHECK(rows() == before);
  // So they are where another program has left them.
  const fs::path one = [&] {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder.path() / "out"))
      if (entry.path().parent_path() != folder.path() / "out" && entry.is_regular_file()) return entry.path();
    return fs::path();
  }();
  const std::string program = io::Hdf5File(one).attribute("/provenance", "program");
  std::string others = program;
  others[0] = others[0] == '0' ? '1' : '0';
  reseal(one, program, others);
  REQUIRE(io::Hdf5File(one).attribute("/provenance", "program") == others);
  CHECK(ran(folder, words).code == 0);
  CHECK(io::Hdf5File(one).attribute("/provenance", "program") == program);
  // And so is one of anybody's making.
  const std::vector<std::string> metrics = io::Hdf5File(one).texts("/metrics/name");
  io::write_file(one, made_row(one, 2));
  CHECK(ran(folder, words).code == 0);
  CHECK(io::Hdf5File(one).texts("/metrics/name") == std::vector<std::string>{"made", "up"});
  io::write_file(one, made_row(one, 1));
  CHECK(ran(folder, words).code == 0);
  CHECK(io::Hdf5File(one).texts("/metrics/name") == metrics);
  CHECK(ran(folder, words + " --fresh").code == 0);
  CHECK(rows() != before);
}

TEST_CASE("A study of which no row can be read is no case") {
  const Folder folder;
  const auto said = [&](const std::string& study) {
    folder.write("bar.toml", bar_case + study);
    const Ran validated = ran(folder, "validate bar.toml"), made = ran(folder, "run bar.toml --out out");
    CHECK(validated.code == made.code);
    return validated.err;
  };
  CHECK_THAT(
      said("[sweep]\naxes = [{ key = \"bond.bond_stifness\", values = [0.1, 0.2] }]\n"),
      ContainsSubstring("none of its rows can be read, the first because of --set bond.bond_stifness=0.1"));
  CHECK_THAT(said("[boundary]\nkey = \"bond.stiff\"\nfrom = 1.0\nto = 2.0\n"
                  "criterion = { metric = \"young_modulus\", at_most = 1.0 }\n"),
             ContainsSubstring("--set bond.stiff=1.0: unknown key 'stiff'"));
  // One that is refused is a row.
  CHECK(said("[sweep]\naxes = [{ key = \"bond.bond_stiffness\", values = [-0.1, 0.2] }]\n").empty());
}

TEST_CASE("Shards make what one machine makes") {
  const Folder folder;
  folder.write("bar.toml", bar_case);
  const std::string words = "sweep bar.toml --over bond.bond_stiffness=0.1,0.2,0.3 --json --out ";
  CHECK(ran(folder, words + "one --shard 1/2").code == 0);
  CHECK(ran(folder, words + "two --shard 2/2").code == 0);
  CHECK(ran(folder, "merge one two --out both").out == "3 rows gathered in both\n");
  CHECK(nlohmann::json::parse(ran(folder, "merge one two --out again --json").out).at("rows") == 3);
  const Ran merged = ran(folder, words + "both"), whole = ran(folder, words + "whole");
  REQUIRE(merged.code == 0);
  const auto sweep_of = [&](const Ran& r) {
    return result_of(folder, r).numbers("/records/sweep/young_modulus");
  };
  CHECK(sweep_of(merged) == sweep_of(whole));
}

TEST_CASE("Repeats are taken in rounds over all rows, and rounds are kept and merged as rows are") {
  const Folder folder;
  folder.write("bar.toml", bar_case);
  const std::string words =
      "sweep bar.toml --over bond.bond_stiffness=0.1,0.2 --timed --repeats 2 --json --out ";
  const auto seconds = [&](const std::string& out) {
    const Ran r = ran(folder, words + out);
    REQUIRE(r.code == 0);
    return result_of(folder, r).numbers("/records/sweep_cost/wall_seconds");
  };
  const std::vector<double> first = seconds("one");
  std::vector<fs::file_time_type> early, late;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder.path() / "one")) {
    if (!entry.is_regular_file() || entry.path().parent_path() == folder.path() / "one") continue;
    const bool again = entry.path().parent_path().filename() == "round-2";
    (again ? late : early).push_back(entry.last_write_time());
  }
  REQUIRE(early.size() == 2);
  REQUIRE(late.size() == 2);
  CHECK(std::max(early[0], early[1]) < std::min(late[0], late[1]));
  CHECK(seconds("one") == first);
  CHECK(ran(folder, "merge one --out both").code == 0);
  CHECK(seconds("both") == first);
}

TEST_CASE("accept keeps the table of a study, and later runs are held to it row by row") {
  const Folder folder;
  const std::string head(bar_case);
  const auto write = [&](const std::string& values) {
    folder.write("bar.toml",
                 head + "[sweep]\naxes = [{ key = \"bond.bond_stiffness\", values = [" + values + "] }]\n");
  };
  write("0.13, -1, 0.26");
  REQUIRE(ran(folder, "accept bar.toml --reason first").code == 0);
  const std::string kept = unit::contents(folder.path() / "bar-baseline.toml");
  const engine::Reference baseline = engine::read_reference(folder.path() / "bar-baseline.toml");
  REQUIRE(baseline.table);
  CHECK(baseline.table->find("outcome")->texts ==
        std::vector<std::string>{"completed", "refused", "completed"});
  CHECK(std::isnan(baseline.table->find("young_modulus")->values[1]));
  CHECK(baseline.table->find("bond_evaluations") == nullptr);
  CHECK(ran(folder, "run bar.toml").code == 0);
  CHECK(ran(folder, "accept bar.toml --reason again").code == 0);  // nothing differs

  const std::string modulus = io::toml_text(baseline.table->find("young_modulus")->values[2]);
  folder.write("bar-baseline.toml", unit::replaced(kept, modulus + "]", "0.5]"));
  const Ran departed = ran(folder, "run bar.toml");
  CHECK(departed.code == 1);
  CHECK_THAT(departed.out, ContainsSubstring("sweep.young_modulus"));
  CHECK_THAT(ran(folder, "accept bar.toml --reason again").out,
             ContainsSubstring("column young_modulus of sweep"));
  folder.write("bar-baseline.toml", unit::replaced(kept, "\"refused\"", "\"completed\""));
  CHECK(ran(folder, "run bar.toml").code == 1);
  folder.write("bar-baseline.toml", unit::replaced(kept, "\"young_modulus\"", "\"young_modulos\""));
  CHECK(ran(folder, "run bar.toml").code == 1);  // no row has it
  folder.write("bar-baseline.toml", kept);
  write("0.13, 0.26");  // a row less
  CHECK(ran(folder, "run bar.toml").code == 1);
  folder.write("bar-baseline.toml", unit::replaced(kept, "\"completed\", \"refused\"", "\"refused\""));
  CHECK_THAT(ran(folder, "run bar.toml").err, ContainsSubstring("columns of a table are equally long"));
}

TEST_CASE("A boundary is where a reader's own bound lies, and changes that come back are counted") {
  const Folder folder;
  folder.write("bar.toml", bar_case);
  const Ran ran_it = ran(
      folder,
      "boundary bar.toml --along bond.bond_stiffness=-1..1.1 --points 3 --accuracy 1e-6 --json --out out");
  REQUIRE(ran_it.code == 0);
  const io::Hdf5File file = result_of(folder, ran_it);
  CHECK(file.texts("/records/outcome_boundary/outcome_before").front() == "refused");
  CHECK(file.texts("/records/outcome_boundary/outcome_behind").front() == "completed");
  CHECK(file.numbers("/records/outcome_boundary/before").front() <= 0.0);
  CHECK(file.numbers("/records/outcome_boundary/behind").front() > 0.0);
  CHECK(file.numbers("/records/outcome_boundary/behind").front() < 1e-8);
  CHECK(file.numbers("/records/outcome_boundary/changes").front() == 1.0);
}

TEST_CASE("The boundary of a criterion is the middle of two places, where its bound lies between them") {
  const Folder folder;
  folder.write("bar.toml", bar_case);
  const Ran ran_it = ran(folder,
                         "boundary bar.toml --along bond.bond_stiffness=0.1..1.1 --points 3 --accuracy 0.01 "
                         "--criterion 'young_modulus<=0.437' --json --out out");
  REQUIRE(ran_it.code == 0);
  const io::Hdf5File file = result_of(folder, ran_it);
  const std::string record = "/records/outcome_boundary/";
  CHECK(file.texts(record + "outcome_before").front() == "completed");
  CHECK(file.texts(record + "outcome_behind").front() == "beyond");
  const double before = file.numbers(record + "before").front(),
               behind = file.numbers(record + "behind").front();
  CHECK(before <= 0.437);
  CHECK(behind > 0.437);
  CHECK(behind - before < 0.02);
  CHECK(file.numbers(record + "boundary").front() == Approx(0.5 * (before + behind)).epsilon(1e-12));
}

TEST_CASE(
    "The runs that a study plans are those that it makes, of a search those of a boundary in the middle") {
  const Folder folder;
  const std::string boundary =
      "[boundary]\nkey = \"bond.bond_stiffness\"\nfrom = 0.1\nto = 1.1\npoints = 4\naccuracy = 0.01\n"
      "criterion = { metric = \"young_modulus\", at_most = 0.599 }\n";
  const std::string sweep = "[sweep]\naxes = [{ key = \"bond.bond_stiffness\", values = [0.1, 0.2, 0.4] }]\n";
  const std::string ablate =
      "[ablate]\nvariants = [{ name = \"soft\", set = { \"bond.bond_stiffness\" = 0.1 } }]\n";
  for (const auto& [study, table] :
       {std::pair{boundary, "outcome_boundary_rows"}, {sweep, "sweep"}, {ablate, "ablate"}}) {
    INFO(study);
    folder.write("bar.toml", bar_case + study);
    const engine::Case c =
        engine::read_case(folder.path() / "bar.toml", {}, studies::readers(), repository::references());
    REQUIRE(c.study.runs);
    CHECK(c.study.runs->side_by_side);
    CHECK(c.study.runs->times == 1);
    const Ran made = ran(folder, "run bar.toml --json --out out");
    REQUIRE(made.code == 0);
    CHECK(result_of(folder, made).texts(fmt::format("/records/{}/outcome", table)).size() ==
          c.study.runs->settings.size());
  }
  folder.write("bar.toml", bar_case + unit::replaced(sweep, "[sweep]", "[sweep]\ntimed = true\nrepeats = 2"));
  const engine::Case timed =
      engine::read_case(folder.path() / "bar.toml", {}, studies::readers(), repository::references());
  CHECK_FALSE(timed.study.runs->side_by_side);
  CHECK(timed.study.runs->times == 3);
}

TEST_CASE("Along an axis of several the rows differ in that axis alone") {
  const Folder folder;
  folder.write("bar.toml", bar_case);
  const Ran ran_it = ran(folder,
                         "sweep bar.toml --over bond.bond_stiffness=0.1,0.2,0.4 --over bond.rest_length=1,2 "
                         "--json --out out");
  REQUIRE(ran_it.code == 0);
  const io::Hdf5File file = result_of(folder, ran_it);
  // The modulus is k/r0: twice as large at each further stiffness, half as large at the other length.
  const std::string record = "/records/orders_along_bond.bond_stiffness/";
  const std::vector<std::string> metric = file.texts(record + "metric");
  const std::vector<double> length = file.numbers(record + "bond.rest_length"),
                            finest = file.numbers(record + "finest");
  int seen = 0;
  for (std::size_t i = 0; i < metric.size(); ++i) {
    if (metric[i] != "young_modulus") continue;
    CHECK(finest[i] == Approx(0.4 / length[i]).epsilon(1e-9));
    ++seen;
  }
  CHECK(seen == 2);
}

TEST_CASE("An ablation shows what a part does") {
  const Folder folder;
  std::string moving = unit::replaced(bar_case, "driver = \"tensile\"", "driver = \"integrator\"");
  moving = unit::replaced(moving, "lateral = \"fixed\"\n", "");
  moving =
      moving.substr(0, moving.find("[tensile]")) +
      "[angle]\nstiffness = 0.025\n[integrator]\nnoise = 0.02\nspeed = 0.02\nduration = 20\nsteps = 80\n";
  folder.write("bar.toml", moving);
  const Ran ran_it =
      ran(folder, "ablate bar.toml --without angle --with integrator.speed=0.01 --json --out out");
  REQUIRE(ran_it.code == 0);
  const io::Hdf5File file = result_of(folder, ran_it);
  CHECK(file.texts("/records/ablate/variant") ==
        std::vector<std::string>{"as it stands", "without angle", "with integrator.speed=0.01"});
  const std::vector<double> angles = file.numbers("/records/ablate/angle_evaluations");
  const std::vector<double> bonds = file.numbers("/records/ablate/bond_evaluations");
  CHECK(angles[0] > 0.0);
  CHECK(angles[1] == 0.0);
  CHECK(bonds[1] == bonds[0]);
  const std::vector<double> built = file.numbers("/records/ablate/built_angles");
  CHECK(built[0] > 0.0);
  CHECK(built[1] == 0.0);
  const std::vector<double> moved = file.numbers("/records/ablate/moved");
  CHECK(moved[0] == 0.0);
  CHECK(moved[1] > 0.0);
}

TEST_CASE("What the plan of a scene leaves out can be put in, a row each, and changes nothing") {
  const Folder folder;
  const Ran ran_it = ran(folder,
                         "ablate scene-chain-alone --set body.0.clamped= --set body.0.load= "
                         "--set 'body.0.start={noise=1e-3}' --left-out --json --out out");
  REQUIRE(ran_it.code == 0);
  const io::Hdf5File file = result_of(folder, ran_it);
  CHECK(file.texts("/records/ablate/variant") ==
        std::vector<std::string>{"as it stands", "with angles", "with constraints", "with loads"});
  CHECK(file.numbers("/records/ablate/moved") == std::vector<double>(4, 0.0));
  for (const char* part : {"angles", "constraints", "loads"}) {
    INFO(part);
    const std::vector<double> built = file.numbers(std::string("/records/ablate/built_") + part);
    CHECK(std::count(built.begin(), built.end(), 0.0) == 3);
  }
}

TEST_CASE("A study of which no run can be read is bad input, with the reason of the first") {
  const Folder folder;
  folder.write("bar.toml", bar_case);
  for (const std::string words :
       {"sweep bar.toml --over bond.stiffnes=1,2", "boundary bar.toml --along bond.stiffnes=1..2"}) {
    const Ran ran_it = ran(folder, words);
    CHECK(ran_it.code == 2);
    CHECK_THAT(ran_it.err,
               ContainsSubstring("no run of the study can be read") && ContainsSubstring("stiffnes"));
  }
}

TEST_CASE("A rod in a flow is advised from physical numbers, each setting with where it comes from") {
  const Folder folder;
  const std::string rod =
      "advise --viscosity 1e-6 --speed 0.01 --diameter 1e-3 --rod-length 0.01 --error 0.05 --out out --json";
  const Ran nothing = ran(folder, rod);
  CHECK(nothing.code == 2);
  CHECK_THAT(nothing.err, ContainsSubstring("veriflex run cost-cylinder-markers --out out"));
  REQUIRE(
      ran(folder,
          "run cost-cylinder-markers --out out --set 'sweep.axes=[{ key = \"coupling.forcing_iterations\", "
          "values = [1, 4] }, { key = \"coupling.delta\", values = [\"cosine\"] }, { key = "
          "\"fluid.relaxation_time\", values = [0.8, 1.0] }, { keys = [\"immersed.radius\", "
          "\"immersed.first_cell\"], values = [[1.5, 24], [2.5, 40], [3.5, 56]] }]'")
          .code == 0);
  REQUIRE(folder.shell("mv out/cost-cylinder-markers+*.h5 out/cost-cylinder-markers.h5").code == 0);
  const auto setting = [](const Json& advice, const std::string& key) {
    for (const Json& one : advice["settings"]) {
      const std::string text = one["setting"];
      if (text.starts_with(key + "=")) return text.substr(key.size() + 1);
    }
    return std::string();
  };
  const Json rigid = Json::parse(ran(folder, rod).out);
  CHECK(rigid["predicted"]["error"] <= 0.05);
  CHECK(setting(rigid, "body.0.substeps").empty());
  const double radius = std::stod(setting(rigid, "body.0.shape.rod.radius"));
  const double tau = std::stod(setting(rigid, "fluid.relaxation_time"));
  // Ma^2 is a quarter of the error at most: U = 0.01 m/s and nu = (tau - 1/2)/3 dx^2/dt.
  const double spacing = 1e-3 / (2.0 * radius), step = (tau - 0.5) / 3.0 * spacing * spacing / 1e-6;
  CHECK(3.0 * std::pow(0.01 * step / spacing, 2) <= 0.25 * 0.05 * (1.0 + 1e-9));
  CHECK(setting(rigid, "run.steps") == fmt::format("{}", std::ceil(10.0 / step)));

  // E scales with (dt/dx)^2: the stiffer the rod, the more sub-steps, and in the end a step in one piece.
  const Json soft = Json::parse(ran(folder, rod + " --young 10").out);
  const Json stiff = Json::parse(ran(folder, rod + " --young 1e6").out);
  CHECK(std::stoi(setting(soft, "body.0.substeps")) >= 1);
  CHECK(setting(stiff, "body.0.integrator") == "\"implicit-midpoint\"");
  CHECK_THAT(setting(soft, "body.0.coupling"), ContainsSubstring("forcing_iterations = 1"));
  CHECK(soft["coupling_growth"] == 1.0);
  CHECK(ran(folder, "advise --error 0.1").code == 2);
  CHECK(ran(folder, rod + " --rod-length 1e-5").code == 2);

  // What is advised runs as it is written.
  for (const char* kind :
       {"", " --young 10", " --young 1e6", " --amplitude 2e-3", " --young 10 --amplitude 2e-3"}) {
    INFO("a rod" << kind);
    REQUIRE(ran(folder, rod + kind + " --write reed.toml").code == 0);
    const Ran done = ran(folder, "run reed.toml --out out --json --set run.steps=2");
    CHECK(done.err == "");
    REQUIRE(done.code == 0);
    const Json metrics = Json::parse(done.out)[0]["metrics"];
    CHECK_THAT(metrics.dump(), ContainsSubstring("forces.rod_fluid_z.last"));
  }
}
