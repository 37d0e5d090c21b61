// render --trace: the trace file agrees with the statistics of the render and changes no bit of the picture.
#include "base/thread/trace.h"

#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>

#include "base/file/file.h"
#include "support/system/tool_test.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;
using Json = nlohmann::json;

class TraceCli : public ToolTest {
 protected:
  TraceCli() : ToolTest("trace_") {}
  void SetUp() override { done({"convert", "phantom:head:60x60x60", in("h.kiln"), "--brick-size", "16"}); }
  Json json(const std::string& name) const { return Json::parse(readTextFile(in(name))); }
};

struct TraceSums {
  std::map<std::string, int> spans;    // number of spans by name
  std::map<std::string, double> busy;  // by name, including nested spans. unit: microseconds
  std::map<std::string, std::uint64_t> tiles;
  std::map<int, std::vector<std::pair<double, double>>> tracks;
};

TraceSums sumsOf(const Json& trace) {
  TraceSums out;
  for (const Json& event : trace["traceEvents"]) {
    if (event["ph"] != "X") continue;
    const std::string name = event["name"];
    ++out.spans[name];
    out.busy[name] += event["args"]["busy_us"].get<double>();
    const double begin = event["ts"];
    out.tracks[event["tid"]].emplace_back(begin, begin + event["dur"].get<double>());
    for (const char* key : {"samples", "splats"}) {
      if (name == "tile") out.tiles[key] += event["args"][key].get<std::uint64_t>();
    }
  }
  return out;
}

// Spans of a track lie beside or inside each other; trace viewers require this.
void expectNested(std::vector<std::pair<double, double>> spans) {
  constexpr double kRounding_us = 0.002;
  std::sort(spans.begin(), spans.end(),
            [](const auto& a, const auto& b) { return a.first != b.first ? a.first < b.first : a.second > b.second; });
  std::vector<double> ends;
  for (const auto& [begin, end] : spans) {
    while (!ends.empty() && ends.back() <= begin + kRounding_us) ends.pop_back();
    if (!ends.empty()) {
      EXPECT_LE(end, ends.back() + kRounding_us);
    }
    ends.push_back(end);
  }
}

TEST_F(TraceCli, SaysWhatTheStatisticsSay) {
  for (const std::vector<std::string>& mode :
       {std::vector<std::string>{}, {"--lattice", "voxel"}, {"--mode", "mip"}, {"--samples", "4"}}) {
    for (const char* threads : {"1", "2"}) {
      // Without the brick that --fit visible reads before the frame.
      std::vector<std::string> arguments = {"render", in("h.kiln"), "-o",        in("p.exr"), "--size", "120x150",
                                            "--tf",   "ct-skin",    "--threads", threads,     "--fit",  "box"};
      arguments.insert(arguments.end(), mode.begin(), mode.end());
      done(arguments);
      const std::vector<std::byte> picture = readFile(in("p.exr"));
      arguments.insert(arguments.end(), {"--trace", in("t.json"), "--stats", in("s.json")});
      done(arguments);
      EXPECT_EQ(readFile(in("p.exr")), picture) << "a trace changes no bit";
      const Json stats = json("s.json");
      const TraceSums trace = sumsOf(json("t.json"));
      EXPECT_EQ(trace.spans.at("frame"), 1);
      EXPECT_EQ(trace.spans.at("write"), 1);
      EXPECT_EQ(trace.spans.at("read"), stats["bricks"]["read"]);
      EXPECT_EQ(trace.spans.at("decode"), stats["bricks"]["read"]);
      EXPECT_EQ(trace.tiles.at("samples"), stats["voxels"]["visited"]);
      EXPECT_EQ(trace.tiles.at("splats"), stats["voxels"]["splats"]);
      constexpr double kRounding_s = 1e-4;
      EXPECT_NEAR(1e-6 * trace.busy.at("tile"), stats["busy"]["draw_s"], kRounding_s);
      EXPECT_NEAR(1e-6 * trace.busy.at("decode"), stats["busy"]["decode_s"], kRounding_s);
      for (const auto& [track, spans] : trace.tracks) expectNested(spans);
      EXPECT_GT(stats["utilisation"], 0.0);
      if (std::string(threads) == "1") {
        EXPECT_LE(stats["utilisation"], 1.01) << "one thread, which reads nothing ahead";
        EXPECT_EQ(trace.tracks.size(), 1u);
      }
    }
  }
}

TEST_F(TraceCli, OfAJobOfManyFramesIsOneFileInItsMemory) {
  writeText(in("job.json"), R"({ "kiln": 1, "volume": "h.kiln", "output": "f_#.png", "trace": "t.json", "threads": 2,
    "image": {"width": 40, "height": 40}, "camera": {"turntable": {"frames": 5}} })");
  done({"render", in("job.json"), "--frames", "1-4", "--stats", in("s.json")});
  EXPECT_EQ(sumsOf(json("t.json")).spans.at("frame"), 4);
  EXPECT_EQ(json("s.json")["memory"]["trace_bytes"], Trace::kMemoryBytes);
  const auto smallest = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"render",    in("h.kiln"), "--size",    "40x40",
                                          "--dry-run", "--stats",    in("d.json")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    done(arguments);
    return json("d.json")["memory"]["smallest_bytes"].get<std::uint64_t>();
  };
  EXPECT_EQ(smallest({"--trace", in("u.json")}), smallest({}) + Trace::kMemoryBytes);
  EXPECT_FALSE(fs::exists(in("u.json"))) << "a dry run does nothing that could be traced";
}

TEST_F(TraceCli, OnAFullDiskIsNotLeft) {
  ToolOptions full;
  full.file_bytes = 20;  // less than a trace begins with
  const ToolResult result =
      runTool({"render", in("h.kiln"), "-o", in("p.png"), "--size", "20x20", "--trace", in("t.json")}, full);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(result.err.find("kiln: " + in("t.json") + ": "), 0u) << result.err;
  for (const auto& entry : fs::directory_iterator(directory_))
    EXPECT_EQ(entry.path().filename().string(), "h.kiln") << "left behind";
}

TEST_F(TraceCli, OfARenderThatFailsIsNotLeft) {
  for (const char* file : {"none/t.json", "t.json"}) {
    const bool nowhere = std::string(file) != "t.json";
    const ToolResult result = runTool(
        {"render", in("h.kiln"), "-o", in(nowhere ? "p.png" : "none/p.png"), "--size", "20x20", "--trace", in(file)});
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_EQ(result.errorLines().size(), 1u) << result.err;
    EXPECT_NE(result.err.find("none"), std::string::npos) << result.err;
    for (const auto& entry : fs::directory_iterator(directory_))
      EXPECT_NE(entry.path().filename().string().substr(0, 6), "t.json") << entry.path();
  }
}

}  // namespace
}  // namespace kiln::test
