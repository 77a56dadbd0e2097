// What programs read of a run: results.json and JUnit's XML.
#include <nlohmann/json.hpp>

#include "catch.hpp"
#include "repository.hpp"
#include "unit/command.hpp"

using namespace veriflex;
namespace fs = std::filesystem;
using unit::Folder;
using unit::good_case;
using unit::Ran;
using unit::replaced;
using Json = nlohmann::json;

namespace {

bool is_of_type(const Json& value, const std::string& type) {
  return type == "null"      ? value.is_null()
         : type == "integer" ? value.is_number_integer()
         : type == "number"  ? value.is_number()
         : type == "string"  ? value.is_string()
         : type == "array"   ? value.is_array()
                             : value.is_object();
}

/// What of the value the schema does not allow; of JSON Schema what results.schema.json uses.
std::vector<std::string> violations(const Json& value, const Json& schema, const Json& root,
                                    const std::string& at = "") {
  std::vector<std::string> all;
  const auto add = [&](const std::vector<std::string>& more) {
    all.insert(all.end(), more.begin(), more.end());
  };
  if (schema.contains("$ref")) {
    add(violations(value, root.at(Json::json_pointer(schema["$ref"].get<std::string>().substr(1))), root,
                   at));
  }
  if (schema.contains("const") && value != schema["const"]) all.push_back(at + " is another constant");
  if (schema.contains("enum")) {
    const Json& words = schema["enum"];
    if (std::find(words.begin(), words.end(), value) == words.end()) all.push_back(at + " is no such word");
  }
  if (schema.contains("type")) {
    const Json types = schema["type"].is_array() ? schema["type"] : Json::array({schema["type"]});
    const bool fits = std::any_of(types.begin(), types.end(), [&](const Json& type) {
      return is_of_type(value, type.get<std::string>());
    });
    if (!fits) all.push_back(at + " is of another type");
  }
  if (value.is_object() && schema.contains("properties")) {
    for (const Json& name : schema.value("required", Json::array())) {
      if (!value.contains(name.get<std::string>())) all.push_back(at + " lacks " + name.get<std::string>());
    }
    for (const auto& [name, part] : value.items()) {
      if (schema["properties"].contains(name)) {
        add(violations(part, schema["properties"][name], root, at + "/" + name));
      } else {
        all.push_back(at + " has " + name);
      }
    }
  }
  if (value.is_array() && schema.contains("items")) {
    for (const Json& part : value) add(violations(part, schema["items"], root, at + "[]"));
  }
  return all;
}

void write_two_cases(const Folder& folder) {
  folder.write("bad.toml", replaced(good_case, "title = \"Bar", "title = \"<Bar> & \\u0001"));
  folder.write("worse.toml", replaced(replaced(good_case, "id = \"bad\"", "id = \"worse\""), "target = 1021",
                                      "target = 1022"));
}

}  // namespace

TEST_CASE("results.json is as its schema says, with errors and files that are none") {
  const Folder folder;
  write_two_cases(folder);
  folder.write("broken.toml", replaced(good_case, "id = \"bad\"", "id = \"broken\"\nnobody = 1"));
  folder.write("out/damaged.h5", "nothing");
  CHECK(folder.run({"run", "bad.toml", "worse.toml", "broken.toml", "--out", "out"}).code == 2);
  const Json json = Json::parse(unit::contents(folder.path() / "out/results.json"));
  const Json schema = Json::parse(unit::contents(repository::root() / "verify/results.schema.json"));
  CHECK(violations(json, schema, schema) == std::vector<std::string>{});
  CHECK(json["counts"] == Json{{"pass", 1}, {"fail", 1}, {"error", 1}, {"measured", 0}, {"skipped", 0}});
  CHECK(json["unreadable"].size() == 1);
  CHECK(json["results"][0]["checks"][0]["metric"] == "young_modulus");
  CHECK(!violations(Json{{"format", "x"}}, schema, schema).empty());
}

TEST_CASE("One case alone leaves results.json to the commands that look at all") {
  const Folder folder;
  folder.write("bad.toml", good_case);
  REQUIRE(folder.run({"run", "bad.toml", "--out", "out"}).code == 0);
  CHECK(!fs::exists(folder.path() / "out/results.json"));
}

TEST_CASE("JUnit's report counts failures and errors, and is XML whatever a case says") {
  const Folder folder;
  write_two_cases(folder);
  folder.write("broken.toml", "nonsense <&\"");
  const std::string jobs = GENERATE("1", "3");
  const Ran ran = folder.run({"run", "bad.toml", "worse.toml", "broken.toml", "--out", "out", "--junit",
                              "ci/junit.xml", "--jobs", jobs});
  CHECK(ran.code == 2);
  const std::string xml = unit::contents(folder.path() / "ci/junit.xml");
  CHECK_THAT(xml, ContainsSubstring("tests=\"3\" failures=\"1\" errors=\"1\""));
  CHECK_THAT(xml, ContainsSubstring("young_modulus measured"));
  const Ran parsed = folder.shell("python3 -c 'import xml.dom.minidom as m; m.parse(\"ci/junit.xml\")'");
  CHECK(parsed.code == 0);
}

TEST_CASE("A report that cannot be written is an output error, and the results stand") {
  const Folder folder;
  folder.write("bad.toml", good_case);
  folder.write("file", "");
  const Ran ran = folder.run({"run", "bad.toml", "--out", "out", "--junit", "file/junit.xml"});
  CHECK(ran.code == 4);
  CHECK(fs::exists(folder.path() / "out/bad.h5"));
}
