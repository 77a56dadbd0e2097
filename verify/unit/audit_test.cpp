// How much checks are worth.
#include "engine/audit.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "catch.hpp"
#include "unit/command.hpp"

using namespace veriflex;
using engine::StoredCheck;
using engine::StoredResult;
using unit::Folder;
using unit::good_case;
using Json = nlohmann::json;

namespace {

StoredCheck check(double error, double tolerance) {
  StoredCheck made{};
  made.metric = "length";
  made.statement = "is right";
  made.verdict = error <= tolerance ? "pass" : "fail";
  made.holds = "within";
  made.measured = 1.0 + error;
  made.target = 1.0;
  made.tolerance = tolerance;
  made.error = error;
  made.margin = error / tolerance;
  return made;
}

StoredResult result(const StoredCheck& one) {
  StoredResult made{};
  made.id = "a";
  made.checks = {one};
  return made;
}

}  // namespace

TEST_CASE("A tolerance is loose beyond a hundred times the error, and close within three") {
  const auto found = [](double error) { return engine::audit({result(check(error, 1.0))}, {}); };
  CHECK(found(0.009).loose.size() == 1);
  CHECK(found(0.02).loose.empty());
  CHECK(found(0.02).close.empty());
  CHECK(found(0.4).close.size() == 1);
  CHECK(found(0.0).loose.empty());
  CHECK(found(0.0).exact == 1);
}

TEST_CASE("A tolerance that covers what other runs measure is not loose, and may be close to it") {
  const StoredResult here = result(check(0.001, 1.0));
  CHECK(engine::audit({here}, {here}).loose.size() == 1);
  const engine::AuditOfResults apart = engine::audit({here}, {result(check(0.5, 1.0))});
  CHECK(apart.loose.empty());
  REQUIRE(apart.noisy.size() == 1);
  CHECK(*apart.noisy[0].spread == Approx(0.499));
}

TEST_CASE("A finding has its own measure, and a statement of beyond is never loose") {
  StoredCheck finding = check(5.0, 1.0);
  finding.verdict = "finding";
  CHECK(engine::audit({result(finding)}, {}).close.empty());
  StoredCheck outside = check(500.0, 1.0);
  outside.holds = "outside";
  outside.margin = 1.0 / 500.0;
  const engine::AuditOfResults found = engine::audit({result(outside)}, {});
  CHECK(found.loose.empty());
  CHECK(found.close.empty());
}

TEST_CASE("Cases say which targets are the program's own, and what is not judged at all") {
  engine::Case c{};
  c.id = "mine";
  engine::Check own{};
  own.measure = "length";
  own.tolerance.reason = "as above";
  own.target_kind = "baseline";
  c.checks = {own};
  engine::Ledger ledger;
  engine::Entry sketch;
  sketch.id = "a-sketch";
  sketch.kind = engine::not_decidable;
  sketch.notes = "it is a sketch";
  ledger.entries.push_back(sketch);
  const engine::AuditOfCases found = engine::audit({c}, {"reference/unused.toml"}, ledger);
  CHECK(found.without_reason.size() == 1);
  CHECK(found.own_targets.size() == 1);
  CHECK(found.without_question.size() == 1);
  CHECK(found.unused[0].what == "unused");
  CHECK(found.undecided[0].what == "a-sketch");
}

TEST_CASE("audit lists the margins of a folder beside those of another") {
  const Folder folder;
  folder.write("bad.toml", good_case);
  REQUIRE(folder.run({"run", "bad.toml", "--out", "one"}).code == 0);
  const unit::Ran ran = folder.run({"audit", "one", "--against", "one", "--json"});
  CHECK(ran.code == 0);
  const Json json = Json::parse(ran.out);
  REQUIRE(json["checks"].size() == 1);
  CHECK(json["checks"][0]["spread"] == 0.0);
  CHECK(json["without_reason"].empty());
  CHECK(json["without_question"].empty());
  CHECK(json["unused_references"].empty());
  CHECK_THAT(folder.run({"audit", "one"}).out, ContainsSubstring("young_modulus"));
  CHECK(folder.run({"audit", "nowhere"}).code == 2);
}
