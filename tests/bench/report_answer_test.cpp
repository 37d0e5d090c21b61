// A tiny suite is run by the library, and its results are parsed: lines of the CSV, keys of the JSON, elements of the
// page. Known from the methods: an exact method visits no more than octree only and draws an equal picture. All exact
// methods except the overlay visit equal voxels.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "base/error.h"
#include "bench/report/base64.h"
#include "bench/report/charts.h"
#include "bench/report/report.h"
#include "bench/report/report_csv.h"
#include "bench/report/report_html.h"
#include "bench/report/report_json.h"
#include "bench/report/report_text.h"
#include "bench/report/report_words.h"
#include "bench/run_suite.h"
#include "bench/summary.h"
#include "image/file/image_file.h"
#include "support/system/expect_error.h"
#include "support/system/faulty_file_system.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;
using Json = nlohmann::json;

const Measurements& measurements() {
  static const Measurements m = [] {
    const DenseVolume volume = head({{48, 40, 44}, VoxelType::u16}, {0, 3000});
    const std::string store = makeStore(volume, "bench_head").string();
    const Suite suite = parseSuite(
        R"({"kiln_suite": 1, "title": "A <small> \"suite\" & more", "views": 2, "repeat": 1, "epsilon_px": [0, 2, 64],
            "cost": {"sizes": [64, 128], "areas": [4, 8]},
            "scaling": {"volumes": ["phantom:head:16x16x16", "phantom:head:32x32x32"], "size": [24, 16], "repeat": 1},
            "cases": [{"name": "HEAD", "classification": "bone, and \"skin\"", "paper": "HEAD", "volume": ")" +
            store + R"(", "sizes": [[96, 96], [256, 256]], "node_slice": {}, "artifacts": true},
                      {"name": "<other>", "volume": ")" +
            store + R"(", "sizes": [[64, 48]]}]})",
        "/suite.json");
    Progress silent;
    return runSuite(suite, {freshDirectory("stores"), "kiln bench", "2000-01-01T00:00:00Z"}, silent,
                    [](const Measurements&, const MeasuredRun&) {});
  }();
  return m;
}

TEST(BenchReport, CountsAreThoseOfTheMethods) {
  const Measurements& m = measurements();
  ASSERT_EQ(m.runs.size(), 6u);
  for (const MeasuredRun& run : m.runs) {
    ASSERT_EQ(run.frames.size(), 10u);
    const auto none = summaryOf(run, VisibilityMethod::kNone), tree = summaryOf(run, VisibilityMethod::kRangeTree);
    EXPECT_GT(none->visited, 0);
    EXPECT_EQ(none->ratio_percent, 100);
    EXPECT_LT(tree->visited, none->visited);
    for (const VisibilityMethod method : m.suite.methods) {
      const auto own = summaryOf(run, method);
      ASSERT_TRUE(own);
      EXPECT_LE(own->visited, none->visited);
      EXPECT_GT(own->render_s, 0);
      if (!isExact(method)) continue;
      EXPECT_TRUE(own->identical) << wordOf(method);
      EXPECT_EQ(own->distance.largest, 0);
      EXPECT_GE(own->visited, tree->visited) << wordOf(method);
    }
    EXPECT_EQ(summaryOf(run, VisibilityMethod::kMask)->visited, tree->visited);
  }
}

TEST(BenchReport, EveryEpsilonIsStudied) {
  const Measurements& m = measurements();
  ASSERT_EQ(m.artifacts.size(), 2u);
  for (const ArtifactStudy& study : m.artifacts) {
    ASSERT_EQ(study.steps.size(), 3u);
    std::uint64_t pixels = 0;
    for (const std::uint64_t count : study.steps[0].distance.pixels) pixels += count;
    EXPECT_EQ(pixels, 2u * 96 * 96);
    // 64 pixels cover the largest miss of a small node's approximate area.
    EXPECT_EQ(study.steps[2].distance.largest, 0);
    ASSERT_TRUE(study.enough);
    EXPECT_LE(study.steps[*study.enough].distance.largest, 1);
    for (const EpsilonStep& step : study.steps) EXPECT_LE(step.visited, study.baseline_visited);
  }
}

TEST(BenchReport, StandingsAreSorted) {
  const std::vector<Standing> standings = standingsOf(measurements());
  ASSERT_EQ(standings.size(), 5u);
  std::size_t wins = 0;
  for (std::size_t i = 0; i < standings.size(); ++i) {
    wins += standings[i].wins;
    EXPECT_GE(standings[i > 0 ? i - 1 : 0].speed_up, standings[i].speed_up);
    EXPECT_LE(standings[i].least_speed_up, standings[i].speed_up);
    EXPECT_GE(standings[i].greatest_speed_up, standings[i].speed_up);
  }
  EXPECT_LE(wins, measurements().runs.size());
}

// Returns the fields of a line, unquoted.
std::vector<std::string> fieldsOf(const std::string& line) {
  std::vector<std::string> out(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"')
      out.back() += line[++i];
    else if (line[i] == '"')
      quoted = !quoted;
    else if (line[i] == ',' && !quoted)
      out.emplace_back();
    else
      out.back() += line[i];
  }
  return out;
}

TEST(BenchReport, CsvHasALineAFrame) {
  std::istringstream text(measurementsCsv(measurements()));
  std::string line;
  ASSERT_TRUE(std::getline(text, line));
  const std::vector<std::string> names = fieldsOf(line);
  std::size_t lines = 0;
  while (std::getline(text, line)) {
    const std::vector<std::string> fields = fieldsOf(line);
    ASSERT_EQ(fields.size(), names.size()) << line;
    EXPECT_EQ(fields[1], fields[0] == "HEAD" ? "bone, and \"skin\"" : "");
    ++lines;
    EXPECT_GT(std::stod(fields[8]), 0) << line;
  }
  EXPECT_EQ(names[8], "render_s");
  EXPECT_EQ(lines, 6u * 2 * 5);
}

TEST(BenchReport, JsonHasEverythingMeasured) {
  const Json json = Json::parse(measurementsJson(measurements()));
  EXPECT_EQ(json["kiln_report"], 1);
  EXPECT_EQ(json["suite"]["cases"].size(), 2u);
  EXPECT_EQ(json["volumes"][0]["dims"], Json::array({48, 40, 44}));
  ASSERT_EQ(json["runs"].size(), 6u);
  for (const Json& run : json["runs"]) {
    EXPECT_EQ(run["frames"].size(), 10u);
    EXPECT_EQ(run["summary"].size(), 5u);
    const bool paper = run["paper"] == "HEAD" && run["image"]["width"] == 256;
    EXPECT_EQ(run["summary"][1]["published"].is_object(), paper);
  }
  EXPECT_EQ(json["artifacts"].size(), 2u);
  EXPECT_EQ(json["costs"]["updates"].size(), 2u * 4);
  EXPECT_EQ(json["costs"]["tests"].size(), 2u * 2 * 4);
  EXPECT_EQ(json["standings"].size(), 5u);
  ASSERT_EQ(json["scaling"].size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    const Json& point = json["scaling"][i];
    EXPECT_EQ(point["volume"]["dims"][0], 16 << i);
    EXPECT_GT(point["render_s"], 0);
    EXPECT_GT(point["memory_bytes"], 24 * 16 * 16);
    EXPECT_GT(point["contributing_bytes"], 0);
    EXPECT_GE(point["read_bytes"], point["contributing_bytes"]);
  }
  EXPECT_FALSE(json["machine"]["processor"].get<std::string>().empty());
}

// Returns the first element that is not closed, or closed by another; browsers would display a different structure.
std::string unbalancedElement(const std::string& html) {
  std::vector<std::string> open;
  for (std::size_t at = html.find('<'); at != std::string::npos; at = html.find('<', at + 1)) {
    if (html.compare(at, 2, "<!") == 0) continue;
    const std::size_t end = html.find('>', at);
    if (end == std::string::npos) return "no end of " + html.substr(at, 40);
    const std::string tag = html.substr(at + 1, end - at - 1);
    if (tag.back() == '/') continue;
    const std::string name = tag.substr(tag[0] == '/' ? 1 : 0, tag.find_first_of(" \n") - (tag[0] == '/' ? 1 : 0));
    if (tag[0] != '/') {
      open.push_back(name);
    } else if (open.empty() || open.back() != name) {
      return "</" + name + "> closes " + (open.empty() ? "nothing" : open.back());
    } else {
      open.pop_back();
    }
  }
  return open.empty() ? "" : "<" + open.back() + "> stays open";
}

std::size_t countOf(const std::string& text, const std::string& word) {
  std::size_t count = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + word.size())) ++count;
  return count;
}

TEST(BenchReport, ThePageIsWholeAndNeedsNothingBesideIt) {
  const std::string html = measurementsHtml(measurements());
  EXPECT_EQ(unbalancedElement(html), "");
  for (const char* part : {"Table 1.", "Table 2(a).", "Table 2(b).", "Table 2(c).", "Table 3(a).", "Table 3(b).",
                           "Table 3(c).", "Table 4.", "Table 5(a).", "Table 5(b).", "Figure 7.", "Figure 8.",
                           "Figure 9.", "Figure 10.", "Figure 11.", "Histogram.", "Standings.", "Scaling.", "Growth."})
    EXPECT_EQ(countOf(html, part), 1u) << part;
  for (const char* foreign : {"http://", "https://", "url(", "@import", "<script", "<link"})
    EXPECT_EQ(html.find(foreign), std::string::npos) << foreign;
  EXPECT_EQ(countOf(html, "src="), countOf(html, "src=\"data:image/png;base64,"));
  // Two pictures a case, and four or three of each study.
  EXPECT_GE(countOf(html, "<img "), 2u * 2 + 2 * 3);
  EXPECT_GE(countOf(html, "<svg "), 2u + 3 + 5);
  EXPECT_NE(html.find("A &lt;small&gt; &quot;suite&quot; &amp; more"), std::string::npos);
  EXPECT_EQ(html.find("<other>"), std::string::npos);
  // The paper's HEAD at 256², Table 2(a).
  EXPECT_NE(html.find(counted(404140)), std::string::npos);
}

TEST(BenchReport, FilesAreWrittenAndReplaced) {
  const fs::path directory = freshDirectory("report") / "out";
  requireReportDirectory(directory);
  for (int again = 0; again < 2; ++again) {
    writeReport(measurements(), directory);
    requireReportDirectory(directory);
    for (const char* name : {"report.html", "report.json", "measurements.csv", "suite.json"})
      EXPECT_GT(fs::file_size(directory / name), 0u) << name;
    std::size_t pictures = 0;
    for (const auto& entry : fs::directory_iterator(directory / "pictures")) {
      ++pictures;
      if (entry.path().extension() != ".png") continue;
      EXPECT_GT(readImage(entry.path()).width, 0) << entry.path();
    }
    EXPECT_GE(pictures, 4u + 2 * 3 + 5);
  }
  std::ofstream(directory / "thesis.tex") << "mine";
  expectError([&] { requireReportDirectory(directory); }, ErrorCode::kExists, "thesis.tex");
}

// RFC 4648 §10.
TEST(BenchReport, Base64HasTheVectorsOfItsStandard) {
  const std::pair<const char*, const char*> vectors[] = {{"", ""},
                                                         {"f", "Zg=="},
                                                         {"fo", "Zm8="},
                                                         {"foo", "Zm9v"},
                                                         {"foob", "Zm9vYg=="},
                                                         {"fooba", "Zm9vYmE="},
                                                         {"foobar", "Zm9vYmFy"}};
  for (const auto& [plain, coded] : vectors)
    EXPECT_EQ(base64Of(std::as_bytes(std::span(plain, std::string_view(plain).size()))), coded);
}

TEST(BenchReport, NumbersAreWrittenForPeople) {
  EXPECT_EQ(counted(7), "7");
  EXPECT_EQ(counted(1041109), "1\u202f041\u202f109");
  EXPECT_EQ(measured(0.41234), "0.412");
  EXPECT_EQ(measured(9.994), "9.99");
  EXPECT_EQ(measured(21.34), "21.3");
  EXPECT_EQ(measured(1234), "1\u202f234");
  EXPECT_EQ(measured(0), "0.000");
}

// An empty input, or values without a logarithm, give an empty drawing and no error.
TEST(BenchReport, ChartsOfNothing) {
  EXPECT_EQ(unbalancedElement(drawLines({}).inlined()), "");
  LineChart chart;
  chart.lines = {{"zero", "m-mask", {{0, 0}, {1, 0}}}};
  EXPECT_EQ(unbalancedElement(drawLines(chart).inlined()), "");
  EXPECT_EQ(unbalancedElement(drawBars({}).file()), "");
}

}  // namespace
}  // namespace kiln::test
