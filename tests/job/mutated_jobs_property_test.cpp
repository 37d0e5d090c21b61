// A mutated job is drawn, or refused in one line that names place and reason: never a crash, never a foreign exception.
// The volume and the pictures are tiny, so that many jobs fit into the test's time.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>

#include "base/error.h"
#include "job/job_facts.h"
#include "sequence/render_job_run.h"
#include "support/volumes/procedural.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

constexpr const char* kJobs[] = {
    R"({ "kiln": 1, "volume": "v.kiln", "output": "f_####.exr", "frames": "1-9x4,3",
  "image": {"width": 9, "height": 8, "background": {"top": [0.1, 0, 0, 1], "bottom": [0, 0, 0, 0]}, "aov": ["depth"],
            "crop": [1, 2, 6, 5]},
  "camera": {"view": "left", "azimuth": 10, "elevation": -5, "zoom": 2, "projection": "orthographic", "height": 30,
             "turntable": {"frames": 9, "degrees": 180, "axis": [0, 1, 1]}},
  "transferFunction": {"keyframes": [{"frame": 1, "function": "auto"}, {"frame": 9, "function": "solid:100", "ease": "stop"}]},
  "outputs": [{"path": "z_##.exr", "content": "depth"}], "video": {"rate": 25},
  "visibility": {"method": "quadtree", "threshold": 0.9, "area": "sphere", "epsilon": 3, "samples": "tested"},
  "lattice": "voxel", "level": 0, "samples": 4, "memory": "64M", "threads": 1, "tile": 64, "exr": {"type": "float"} })",
    R"({"kiln": 2, "volume": "v.kiln", "image": {"width": 8, "height": 9}, // keys of all that moves
  "camera": {"fov": 50, "pivot": "target", "keyframes": [
     {"frame": 0, "eye": [-20, 5, 9], "target": [8, 8, 8], "up": [0, 0, 1]},
     {"frame": 2.5, "eye": [8, -30, 20], "target": [8, 8, 9], "ease": "linear", "fov": 20}]},
  "transferFunction": {"unit": 2, "colorSpace": "srgb", "points": [
     {"value": 20, "color": [1, 0.5, 0], "opacity": 0}, {"value": 90, "color": [1, 1, 1], "opacity": 0.8}],
     "gradientOpacity": [{"gradient": 1, "factor": 0.1}, {"gradient": 30, "factor": 1}]},
  "lights": {"keyframes": [{"frame": 0, "lights": [{"type": "directional", "direction": [1, 0, 0]}]},
                           {"frame": 2, "lights": [{"type": "directional", "direction": [0, 1, 0], "intensity": 2}]}]},
  "clip": {"keyframes": [{"frame": 0, "planes": [{"normal": [0, 0, 1], "offset": 0}]},
                         {"frame": 2, "planes": [{"normal": [0, 1, 1], "offset": -9}]}]},
  "shading": {"model": "phong", "ambient": 0.1, "diffuse": 0.7, "specular": 0.3, "power": 8},
  "region": [1, 1, 1, 15, 15, 14], "worldRegion": [0, 0, 0, 15, 15, 15], "window": [60, 80],
  "interpolation": "catmull-rom", "png": {"bits": 16}, "skipDamaged": false })",
    R"({"kiln": 2, "volume": "v.kiln", "image": {"width": 8, "height": 8, "background": {"top": "navy", "bottom": "transparent"}}, "level": "auto",
  "camera": {"fov": 40, "matrices": [[[1, 0, 0, 8], [0, 0, -1, -30], [0, 1, 0, 8], [0, 0, 0, 1]]]},
  "lights": [{"type": "point", "position": [3, 4, 5], "color": "#fed", "intensity": 0.5}],
  "clip": [{"normal": [0, 0, -1], "offset": 10}], "transferFunction": "20:0,90:0.8:orange"})",
    R"({"kiln": 2, "volume": "v.kiln", "image": {"width": 8, "height": 8, "aov": ["value"]}, "mode": "average", "window": [60, 80],
  "camera": {"fov": 40, "view": "top"}, "region": [1, 2, 1, 15, 15, 9], "clip": [{"normal": [0, 0, -1], "offset": 10}]})",
    R"({"kiln": 2, "volumes": [{"volume": "v.kiln", "transferFunction": "solid:50", "region": [1, 1, 1, 15, 15, 14], "window": [60, 80]},
   {"volume": "v.kiln", "clip": [{"normal": [0, 1, 1], "offset": -9}], "shading": {"model": "none"},
    "transferFunction": {"keyframes": [{"frame": 1, "function": "auto"}, {"frame": 3, "function": {"kiln": 1, "points": [
      {"value": 20, "color": "teal", "opacity": 0.1}, {"value": 60, "color": [0.5, 1, 0], "opacity": 0.4}]}}]}}],
  "image": {"width": 8, "height": 8}, "camera": {"view": "left"}, "level": "auto"})",
    R"({"kiln": 2, "volume": "v.kiln", "image": {"width": 8, "height": 8}, "camera": {"view": "right"}, "stereo": {"eye": "both",
   "keyframes": [{"frame": 1, "interocular": 3, "convergence": 40}, {"frame": 4, "interocular": 1, "convergence": 9}]}})",
    R"({"kiln": 2, "volume": "v.kiln", "image": {"width": 8, "height": 8}, "part": "1/2", "interpolation": "cubic",
  "exr": {"compression": "piz", "owner": "us", "comments": "none", "statistics": true}})"};

class Mutator {
 public:
  explicit Mutator(unsigned seed) : random_(seed) {}

  std::string job() {
    std::string text = kJobs[below(std::size(kJobs))];
    for (std::size_t i = 1 + below(3); i > 0; --i) change(text);
    return text;
  }

 private:
  std::size_t below(std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random_); }

  // Returns the position and length of the next number, word or string after a random position.
  std::pair<std::size_t, std::size_t> value(const std::string& text) {
    const std::size_t begin = text.find_first_of("0123456789\"-", below(text.size()));
    if (begin == std::string::npos) return {0, 1};
    const std::size_t end =
        text[begin] == '"' ? text.find('"', begin + 1) + 1 : text.find_first_not_of("0123456789.-e", begin);
    return {begin, std::min(end, text.size()) - begin};
  }

  void change(std::string& text) {
    static constexpr const char* kNumbers[] = {"0",          "-1",    "1e300", "-1e-300", "1e30",  "0.5",
                                               "3",          "65536", "179.9", "1e9",     "2",     "0.99",
                                               "2147483648", "-40",   "7",     "16",      "1e-30", "90"};
    static constexpr const char* kOthers[] = {"null",    "true", "[]",    "{}",      "\"\"",     "\"x\"",  "\"auto\"",
                                              "[1,2,3]", "[[]]", "[0,0]", "\"1-3\"", "\"none\"", "[0,0,0]"};
    const std::size_t at = below(text.size());
    switch (below(12)) {
      case 0:
        text.erase(at, 1 + below(3));
        break;
      case 1:
        text.insert(at, 1, "{}[]\",:0a/\\"[below(11)]);
        break;
      case 2: {  // copies a piece of the text to another position
        const std::string piece = text.substr(below(text.size()), 1 + below(30));
        text.insert(at, piece);
        break;
      }
      case 3: {
        const auto [begin, length] = value(text);
        text.replace(begin, length, kOthers[below(std::size(kOthers))]);
        break;
      }
      default: {
        const auto [begin, length] = value(text);
        if (text[begin] != '"') text.replace(begin, length, kNumbers[below(std::size(kNumbers))]);
      }
    }
    if (text.empty()) text = "{";
  }

  std::mt19937 random_;
};

struct Tally {
  int drawn = 0, refused = 0;
};

void ask(const std::string& text, const std::filesystem::path& folder, Tally& tally) {
  try {
    RenderJob job = parseJob(text, folder / "job.json");
    job.output = OutputOptions{};
    job.picture.size.width = std::min(job.picture.size.width, 16);
    job.picture.size.height = std::min(job.picture.size.height, 16);
    job.frames = {framesOf(job).front(), framesOf(job).back()};
    job.speed.threads = 1;
    job.speed.memory_bytes = std::min<std::uint64_t>(job.speed.memory_bytes, 256u << 20);
    Progress silent;
    const RenderResult result = runRenderJob(job, 1, silent);
    for (const float v : result.image.rgba) ASSERT_TRUE(std::isfinite(v)) << text;
    ++tally.drawn;
  } catch (const Error& error) {
    ++tally.refused;
    const std::string said = error.what();
    EXPECT_GE(said.size(), 20u) << said << "\n" << text;
    EXPECT_EQ(said.find('\n'), std::string::npos) << said << "\n" << text;
    EXPECT_EQ(said.find("json.exception"), std::string::npos) << said << "\n" << text;
  } catch (const std::exception& other) {
    ADD_FAILURE() << "not an error of ours: " << other.what() << "\n" << text;
  }
}

Tally askMany(unsigned first, unsigned count) {
  const std::filesystem::path folder =
      makeStore(ramp({{16, 16, 16}, VoxelType::u8}, 1, 6), "mutated_jobs", 16).parent_path();
  std::filesystem::rename(folder / "volume.kiln", folder / "v.kiln");
  Tally tally;
  for (unsigned seed = first; seed < first + count; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    ask(Mutator(seed).job(), folder, tally);
  }
  return tally;
}

// Both outcomes must occur; otherwise the mutations are too mild or too wild to test anything.
TEST(MutatedJobs, AreDrawnOrRefused) {
  const Tally tally = askMany(1, 120);
  EXPECT_GE(tally.drawn, 20);
  EXPECT_GE(tally.refused, 20);
}

TEST(MutatedJobs, NightlyAThousandAreDrawnOrRefused) {
  const Tally tally = askMany(1000, 1000);
  EXPECT_GE(tally.drawn, 200);
  EXPECT_GE(tally.refused, 200);
}

}  // namespace
}  // namespace kiln::test
