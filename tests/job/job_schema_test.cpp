// The schema is generated from the parser's own tables. Still tested: its references resolve, and a place in a job maps
// to its line.
#include "job/command/job_schema.h"

#include <gtest/gtest.h>

#include <functional>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "job/json/json_place.h"
#include "job/render_job.h"

namespace kiln {
namespace {

using Json = nlohmann::json;

// Every reference names a definition, every definition is named, and every "enum" is a list.
TEST(JobSchema, ReferencesLeadSomewhere) {
  const Json schema = Json::parse(jobSchemaText());
  std::set<std::string> named;
  const std::function<void(const Json&)> walk = [&](const Json& part) {
    if (part.is_object() && part.contains("$ref") && part["$ref"].is_string()) named.insert(part["$ref"]);
    if (part.is_object() && part.contains("enum")) {
      EXPECT_TRUE(part["enum"].is_array()) << part;
    }
    if (!part.is_structured()) return;
    for (const Json& inner : part) walk(inner);
  };
  walk(schema);
  std::set<std::string> defined;
  for (const auto& [name, definition] : schema["$defs"].items()) defined.insert("#/$defs/" + name);
  EXPECT_EQ(named, defined);
}

// The parser accepts each key of the schema's root: for a wrong value the error names the value, not the key.
TEST(JobSchema, TheParserTakesWhatTheSchemaHas) {
  const Json schema = Json::parse(jobSchemaText());
  for (const auto& [name, definition] : schema["$defs"]["job"]["properties"].items()) {
    Json job = Json::object();
    job["kiln"] = 2;
    if (name != "volumes") job["volume"] = "a.kiln";
    job[name] = {{"no such key", 1}};
    try {
      parseJob(job.dump(), "job.json");
      ADD_FAILURE() << name;
    } catch (const Error& error) {
      EXPECT_EQ(std::string(error.what()).find(name + ": unknown key"), std::string::npos) << error.what();
    }
  }
}

// An editor finds the schema by this key.
TEST(JobSchema, ItsAddressInAJobHasNoEffect) {
  const RenderJob job = parseJob(R"({"$schema": "kiln.json", "kiln": 2, "volume": "a.kiln"})", "job.json");
  EXPECT_EQ(job.volume, "a.kiln");
}

TEST(JobSchema, LinesOfPlaces) {
  const std::string text = R"({ // {"a": 1}
  "a": 1, "volume": "x\"}, \"b\": [",
  /* "b": 3,
  */ "list": [ 1, [2,
     {"c": true, "deep": {"er": -1.5e3}}],
     {"a": null,
      "z": {}}],
  "last" : {
     "a": [], "key": 3 } })";
  EXPECT_EQ(lineOfPlace(text, ""), 1u);
  EXPECT_EQ(lineOfPlace(text, "a"), 2u);
  EXPECT_EQ(lineOfPlace(text, "b"), 1u);  // is not there
  EXPECT_EQ(lineOfPlace(text, "list"), 4u);
  EXPECT_EQ(lineOfPlace(text, "list[1][1].deep.er"), 5u);
  EXPECT_EQ(lineOfPlace(text, "list[2].a"), 6u);
  EXPECT_EQ(lineOfPlace(text, "list[2].z"), 7u);
  EXPECT_EQ(lineOfPlace(text, "list[2].z.missing"), 7u);
  EXPECT_EQ(lineOfPlace(text, "last.key"), 9u);
  EXPECT_EQ(lineOfPlace(text, "last.missing"), 8u);
}

TEST(JobSchema, MistakesNameTheirLine) {
  try {
    parseJob("{\"kiln\": 2, \"volume\": \"a.kiln\", // the head\n\n  \"camera\": {\n    \"fvo\": 3}}", "job.json");
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "job.json: line 4, camera.fvo: unknown key; did you mean 'fov'?");
  }
  EXPECT_THROW(parseJob("{\"kiln\": 2, \"volume\": " + std::string(200, '[') + std::string(200, ']') + "}", "job.json"),
               Error);
}

}  // namespace
}  // namespace kiln
