// Another program's numbers as the measured side: what they become, which checks judge them, what is refused.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "analytic/exact_solid.hpp"
#include "base/progress.hpp"
#include "bond/laws.hpp"
#include "catch.hpp"
#include "engine/case.hpp"
#include "engine/result.hpp"
#include "io/document.hpp"
#include "io/file.hpp"
#include "studies/studies.hpp"
#include "unit/command.hpp"

using namespace veriflex;
using unit::Folder;
using unit::replaced;

namespace {

const std::string head =
    unit::case_head("theirs", "external") + "[external]\ncode = \"Solver 1.2\"\nobtained = \"by hand\"\n";

const std::string table =
    "[[external.table]]\nrecord = \"pull\"\nfile = \"pull.csv\"\n"
    "columns = { strain = \"1\", stress = \"M L^-1 T^-2\" }\n";

const std::string number = "[external.number.tip]\nvalue = 0.25\ndimension = \"L\"\n";

// strain 0.1 and 0.2, the second stress off by 1 %
const std::string csv = "# by hand\nstrain,stress\n0.1,10\n0.2,20.2\n";

const std::string curve_check =
    "[[check]]\nkind = \"verification\"\nstatement = \"stress\"\n"
    "curve = { record = \"pull\", x = \"strain\", y = \"stress\" }\nreference = \"wanted\"\n"
    "tolerance = { relative = 0.02, floor = 1.0, reason = \"-\" }\n";

void write_reference(const Folder& folder) {
  const std::string wanted = "strain,stress\n0.1,10\n0.2,20\n";
  folder.write("wanted.csv", wanted);
  folder.write(
      "wanted.toml",
      fmt::format("schema = 1\nid = \"wanted\"\nkind = \"analytic\"\nsource = \"-\"\nobtained = \"-\"\n"
                  "[data]\nfile = \"wanted.csv\"\nsha256 = \"{}\"\n"
                  "[values.tip]\nvalue = 0.26\ndimension = \"L\"\nmeaning = \"-\"\n",
                  io::sha256(wanted)));
}

engine::Case read(const Folder& folder, const std::string& text) {
  folder.write("theirs.toml", text);
  return engine::read_case(folder.path() / "theirs.toml", {}, studies::readers(), folder.path());
}

engine::Result ran(const Folder& folder, const std::string& text) {
  return engine::run_case(read(folder, text), 1);
}

void refuses(const Folder& folder, const std::string& text, const std::string& message) {
  INFO(text);
  CHECK_THROWS_WITH(read(folder, text), ContainsSubstring(message));
}

double error_of(const Folder& folder, const std::string& text) {
  const engine::Result result = ran(folder, text);
  INFO(result.error_message);
  REQUIRE(result.seen.metric("pull_error") != nullptr);
  return result.seen.metric("pull_error")->value;
}

// A table of x and y with an exact law.
std::string with_law(const std::string& x, const std::string& y, const std::string& law) {
  return head + fmt::format(
                    "[[external.table]]\nrecord = \"pull\"\nfile = \"xy.csv\"\n"
                    "columns = {{ x = \"{}\", y = \"{}\" }}\nexact = {{ {}, x = \"x\", y = \"y\" }}\n",
                    x, y, law);
}

}  // namespace

TEST_CASE(
    "Tables of another program are records, its numbers metrics, in the dimensions that the case says") {
  const Folder folder;
  folder.write("pull.csv", "time,strain,stress\n0,0.1,10\n1,0.2,20.2\n");
  const engine::Result result =
      ran(folder, head + replaced(table, "{ strain = \"1\",", "{ time = \"T\", strain = \"1\",") + number);
  CHECK(result.verdict == engine::Verdict::measured);
  const observe::Record* pull = result.seen.record("pull");
  REQUIRE(pull != nullptr);
  REQUIRE(pull->columns.size() == 3);  // in the order of the file
  CHECK(pull->columns.front().name == "time");
  CHECK(pull->find("stress")->values == std::vector{10.0, 20.2});
  CHECK(pull->find("stress")->dimension == "M L^-1 T^-2");
  REQUIRE(result.seen.metric("tip") != nullptr);
  CHECK(result.seen.metric("tip")->value == 0.25);
  CHECK(result.seen.metric("tip")->dimension == "L");
}

TEST_CASE("Any check judges them: a curve against a reference, a number against a value") {
  const Folder folder;
  folder.write("pull.csv", csv);
  write_reference(folder);
  const std::string number_check =
      "[[check]]\nkind = \"verification\"\nstatement = \"tip\"\nmetric = \"tip\"\nreference = \"wanted\"\n"
      "tolerance = { absolute = 0.005, reason = \"-\" }\n";
  const engine::Result result = ran(folder, head + table + number + curve_check + number_check);
  REQUIRE(result.outcomes.size() == 2);
  CHECK(result.outcomes[0].measured == Approx(0.01));
  CHECK(result.outcomes[0].verdict == engine::Verdict::pass);
  CHECK(result.outcomes[1].error == Approx(0.01));
  CHECK(result.outcomes[1].verdict == engine::Verdict::fail);
  CHECK(result.verdict == engine::Verdict::fail);
}

TEST_CASE("A result says whose numbers it holds, from which files, and which case asks the same") {
  const Folder folder;
  folder.write("pull.csv", csv);
  const engine::Case c =
      read(folder, replaced(head, "[external]\n", "[external]\ncase = \"ours\"\n") + table);
  REQUIRE(c.study.other_code.has_value());
  CHECK(c.study.other_code->name == "Solver 1.2");
  CHECK(c.study.other_code->of_case == "ours");
  REQUIRE(c.study.plan.built.size() == 1);
  CHECK_THAT(c.study.plan.built.front().what, ContainsSubstring(io::sha256(csv)));
  engine::write_result(engine::run_case(c, 1), folder.path());
  const io::Hdf5File file(folder.path() / "theirs.h5");
  CHECK(file.attribute("/provenance", "other_code") == "Solver 1.2");
  CHECK(file.attribute("/provenance", "other_code_obtained") == "by hand");
  CHECK(file.attribute("/provenance", "other_code_case") == "ours");
}

TEST_CASE("A number may stand in a table of one row") {
  const Folder folder;
  folder.write("numbers.csv", "tip,drag\n0.25,3\n");
  const std::string text =
      head + "[external.number.drag]\nfile = \"numbers.csv\"\ndimension = \"M L T^-2\"\n";
  CHECK(ran(folder, text).seen.metric("drag")->value == 3.0);
  folder.write("numbers.csv", "tip,drag\n0.25,3\n0.26,3\n");
  refuses(folder, text, "'numbers.csv' has 2 rows (a number needs one)");
  folder.write("numbers.csv", "tip\n0.25\n");
  refuses(folder, text, "'numbers.csv' has no column 'drag' (it has: tip)");
}

TEST_CASE("An exact law is evaluated at their points, and its distance is over its largest magnitude") {
  const Folder folder;
  const std::string length = "L", time = "T", speed = "L T^-1", none = "1";

  folder.write("xy.csv", "x,y\n1,0.3\n2,0.5\n");  // the parabola is 0.3 and 0.4 there
  CHECK(
      error_of(folder, with_law(length, speed,
                                "law = \"plane-poiseuille\", height = 4.0, force = 0.4, viscosity = 2.0")) ==
      Approx(0.25));

  const double rate = 0.5 * 0.04;
  folder.write("xy.csv", fmt::format("x,y\n0,3\n10,{}\n", 3.0 * std::exp(-10.0 * rate)));
  CHECK(
      error_of(folder, with_law(time, speed,
                                "law = \"shear-wave\", amplitude = 3.0, wavenumber = 0.2, viscosity = 0.5")) <
      1e-15);

  folder.write("xy.csv", fmt::format("x,y\n0,0\n2,{}\n", analytic::elastica_tip(2.0).deflection));
  CHECK(error_of(folder, with_law(none, none, "law = \"elastica\"")) == 0.0);

  folder.write("xy.csv", "x,y\n1,0\n1.5,5.1\n");  // a spring of 10 pulls with 5
  CHECK(error_of(folder, with_law(length, "M L T^-2", "law = \"bond-tension\"") +
                             "[bond]\nlaw = \"harmonic\"\nbond_stiffness = 10.0\nrest_length = 1.0\n") ==
        Approx(0.02));
}

TEST_CASE("A law is not evaluated outside of where it holds, nor at a column of another dimension") {
  const Folder folder;
  const std::string law = "law = \"plane-poiseuille\", height = 4.0, force = 0.4, viscosity = 2.0";
  folder.write("xy.csv", "x,y\n0,0\n4.5,0\n");
  refuses(folder, with_law("L", "L T^-1", law), "row 2 of 'pull' has x = 4.5");
  refuses(folder, with_law("T", "L T^-1", law), "'x' has dimension T (L is x of the law 'plane-poiseuille')");
  refuses(folder, with_law("L", "1", law), "'y' has dimension 1");
  refuses(folder, replaced(with_law("L", "L T^-1", law), "y = \"y\" }", "y = \"u\" }"),
          "record 'pull' has no column 'u'");
  refuses(folder, with_law("L", "L T^-1", replaced(law, "2.0", "0.0")), "'viscosity' is 0");
  refuses(folder, with_law("L", "M L T^-2", "law = \"bond-tension\""), "bond");
}

TEST_CASE("What is wrong with another program's numbers is said with its place and a remedy") {
  const Folder folder;
  folder.write("pull.csv", csv);
  write_reference(folder);
  refuses(folder, head, "the case has no numbers");
  refuses(folder, head + replaced(table, "pull.csv", "push.csv"), "data file 'push.csv' not found");
  refuses(folder, head + replaced(table, "stress =", "force ="),
          "'pull.csv' has no column 'force' (it has: strain, stress). Correct the name here or in the file");
  refuses(folder, head + replaced(table, "M L^-1 T^-2", "MPa"), "'MPa' is no dimension");
  refuses(folder, head + replaced(table, "M L^-1 T^-2", "T^-2 M"), "'T^-2 M' is no dimension");
  refuses(folder, head + replaced(table, "{ strain = \"1\", stress = \"M L^-1 T^-2\" }", "{}"),
          "'columns' is empty");
  refuses(folder, head + replaced(table, "\"pull\"", "\"a/b\""), "'a/b' is no name");
  refuses(folder, head + table + table, "'pull' is the record of two tables");
  refuses(folder, head + number + "file = \"pull.csv\"\n", "'tip' has both value and file");
  refuses(folder, head + replaced(number, "value = 0.25\n", ""), "'tip' has neither value nor file");
  folder.write("pull.csv", "strain,stress\n0.1,ten\n");
  refuses(folder, head + table, "pull.csv:2:5: 'ten' is not a finite number");
  folder.write("pull.csv", "strain,stress\n");
  refuses(folder, head + table, "holds no table");
}

TEST_CASE("A number is not held against a reference of another dimension") {
  const Folder folder;
  write_reference(folder);
  refuses(folder,
          head + replaced(number, "\"L\"", "\"1\"") +
              "[[check]]\nkind = \"verification\"\nstatement = \"tip\"\nmetric = \"tip\"\nreference = "
              "\"wanted\"\n"
              "tolerance = { absolute = 0.005, reason = \"-\" }\n",
          "'tip' has dimension 1 (the reference's value has L)");
}

TEST_CASE("A point of a reference that they did not compute is an error, not a pass") {
  const Folder folder;
  folder.write("pull.csv", "strain,stress\n0.1,10\n");
  write_reference(folder);
  const engine::Result result = ran(folder, head + table + curve_check);
  CHECK(result.verdict == engine::Verdict::error);
  CHECK_THAT(result.error_message, ContainsSubstring("did not measure pull.stress at strain = 0.2"));
}

TEST_CASE("A sweep over their files gives the order of their solver, anew when a file has changed") {
  const Folder folder;
  folder.write("coarse.csv", "x,y\n1,0.3\n2,0.44\n");  // 0.4 is exact
  folder.write("fine.csv", "x,y\n1,0.3\n2,0.41\n");
  folder.write("xy.csv", "x,y\n1,0.3\n2,0.4\n");
  folder.write(
      "theirs.toml",
      with_law("L", "L T^-1", "law = \"plane-poiseuille\", height = 4.0, force = 0.4, viscosity = 2.0") +
          "[external.number.nodes]\nvalue = 8.0\ndimension = \"1\"\n"
          "[sweep]\naxes = [{ keys = [\"external.number.nodes.value\", \"external.table.0.file\"], "
          "values = [[8.0, \"coarse.csv\"], [16.0, \"fine.csv\"]] }]\n"
          "[[check]]\nkind = \"verification\"\nstatement = \"second order\"\nmetric = \"pull_error\"\n"
          "of = \"order\"\nalong = \"external.number.nodes.value\"\ntarget = 2.0\n"
          "target_kind = \"analytic\"\nsource = \"-\"\ntolerance = { absolute = 1e-9, reason = \"-\" }\n");
  const unit::Ran second_order = folder.run({"run", "theirs.toml", "--out", "results"});
  CHECK(second_order.code == 0);
  folder.write("fine.csv", "x,y\n1,0.3\n2,0.42\n");
  const unit::Ran first_order = folder.run({"run", "theirs.toml", "--out", "results"});
  CHECK(first_order.code == 1);
}
