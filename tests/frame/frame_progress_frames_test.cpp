// Progress of a frame, for every way of drawing, is a single step. Its count only grows; its total is constant and
// reached once, at the end.
#include <gtest/gtest.h>

#include <map>
#include <utility>

#include "base/byte_record.h"
#include "base/file/record_file.h"
#include "base/thread/parallel.h"
#include "base/thread/profile_scope.h"
#include "frame/frame_memory.h"
#include "frame/pass/frame_progress.h"
#include "sequence/frame_checkpoint.h"
#include "sequence/opened_job.h"
#include "support/reference/drawing.h"
#include "support/reference/function_bytes.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

struct Told {
  std::string step, unit;
  std::uint64_t done, total;
};

class Listening : public Progress {
 public:
  void advance(const char* step, const char* unit, std::uint64_t done, std::uint64_t total) override {
    told.push_back({step, unit, done, total});
  }
  std::vector<Told> told;
};

// The count runs from zero to the total and reaches both exactly once.
void expectOneCount(const std::vector<Told>& told, const std::string& step, const std::string& unit) {
  ASSERT_GE(told.size(), 2u);
  EXPECT_EQ(told.front().done, 0u);
  EXPECT_EQ(told.back().done, told.back().total);
  for (std::size_t i = 0; i < told.size(); ++i) {
    EXPECT_EQ(told[i].step, step);
    EXPECT_EQ(told[i].unit, unit);
    EXPECT_EQ(told[i].total, told.front().total);
    if (i > 0) {
      EXPECT_GE(told[i].done, told[i - 1].done) << i;
    }
    if (i + 1 < told.size()) {
      EXPECT_LT(told[i].done, told[i].total) << i;
    }
  }
}

class FrameProgressOf : public ::testing::Test {
 protected:
  void SetUp() override {
    const DenseVolume volume = head({{70, 60, 50}, VoxelType::u8}, {0, 255});
    folder_ = makeStore(volume, "a", 16).parent_path();
  }

  // Draws the seventh frame of a job with these keys and returns the progress reports.
  std::vector<Told> drawn(const std::string& keys, unsigned threads) const {
    RenderJob job =
        parseJob(R"({"kiln": 2, "image": {"width": 80, "height": 40}, )" + keys + "}", folder_ / "job.json");
    job.speed.threads = threads;
    const ThreadLimit limit(threads);
    Listening listening;
    const DrawnFrame frame = OpenedJob(job, listening).draw(7, listening);
    EXPECT_TRUE(showsSomething(frame.views.front().image));
    return listening.told;
  }
  void check(const std::string& keys, const std::string& unit = "bricks") const {
    for (const unsigned threads : {1u, 3u}) {
      SCOPED_TRACE(keys + ", " + std::to_string(threads) + " threads");
      expectOneCount(drawn(keys, threads), "frame 7", unit);
    }
  }

  std::filesystem::path folder_;
};

TEST_F(FrameProgressOf, APictureCountsTheBricksInView) {
  check(R"("volume": "volume.kiln")");
  check(R"("volume": "volume.kiln", "lattice": "voxel")");
  check(R"("volume": "volume.kiln", "tile": 0, "visibility": {"method": "range-tree"})");
  check(R"("volume": "volume.kiln", "mode": "mip")");
  // Known because the whole volume is in view; bricks that show nothing are not counted.
  const std::vector<Told> told = drawn(R"("volume": "volume.kiln", "mode": "mip", "level": 0)", 1);
  EXPECT_EQ(told.front().total, 5u * 4 * 4);
}

TEST_F(FrameProgressOf, PartsAreOneCount) {
  RenderJob job = parseJob(R"({"kiln": 2, "image": {"width": 12, "height": 300}, "volume": "volume.kiln", "samples": 16,
                               "camera": {"zoom": 20}})",
                           folder_ / "job.json");
  job.speed.memory_bytes = frameMemory(StoreReader(job.volume), job).smallest() + functionBytesOf(job);
  Listening listening;
  OpenedJob(job, listening).draw(7, listening);
  expectOneCount(listening.told, "frame 7", "bricks");
  const std::uint64_t of_bands = listening.told.front().total;
  job.speed.memory_bytes = 1ull << 30;
  Listening whole;
  OpenedJob(job, whole).draw(7, whole);
  EXPECT_GT(of_bands, whole.told.front().total) << "a brick in two bands is drawn twice";
  check(R"("volume": "volume.kiln", "stereo": {"eye": "both", "interocular": 5})");
  check(R"("volume": "volume.kiln", "camera": {"projection": "equirectangular", "eye": [-40, 30, 20]})");
  check(R"("volume": "volume.kiln", "mode": "mip", "stereo": {"eye": "both", "interocular": 5})");
}

// Known: steps precede the frame in the order of drawing, and the frame's count is the same as without them.
TEST_F(FrameProgressOf, LightsAreStepsBeforeTheFrame) {
  const std::string light = R"({"type": "directional", "direction": [1, 0, 1]})";
  const std::vector<Told> told =
      drawn(R"("volume": "volume.kiln", "shading": {"ambientOcclusion": 0.5, "shadows": true}, )"
            R"("lights": [{"type": "headlight"}, )" +
                light + ", " + light + "]",
            3);
  std::map<std::string, std::vector<Told>> steps;
  std::vector<std::string> order;
  for (const Told& report : told) {
    if (steps[report.step].empty()) order.push_back(report.step);
    steps[report.step].push_back(report);
  }
  EXPECT_EQ(order,
            (std::vector<std::string>{"ambient occlusion", "shadows of light 2", "shadows of light 3", "frame 7"}));
  for (const std::string& step : order) {
    SCOPED_TRACE(step);
    expectOneCount(steps[step], step, step == "frame 7" ? "bricks" : "rows");
  }
  EXPECT_EQ(steps["frame 7"].front().total, drawn(R"("volume": "volume.kiln")", 3).front().total);
}

TEST_F(FrameProgressOf, SeveralVolumesCountTiles) {
  const std::string volumes =
      R"("volumes": [{"volume": "volume.kiln"}, {"volume": "volume.kiln", "transferFunction": "ct-bone"}])";
  check(volumes, "tiles");
  check(volumes + R"(, "stereo": {"eye": "both", "interocular": 5})", "tiles");
  check(volumes + R"(, "samples": 4)", "tiles");
}

// Only a checkpoint counts finished tiles, in pixels.
TEST_F(FrameProgressOf, ACheckpointCountsPixels) {
  RenderJob job =
      parseJob(R"({"kiln": 2, "image": {"width": 600, "height": 550}, "volume": "volume.kiln", "output": "f.exr"})",
               folder_ / "job.json");
  Listening listening;
  OpenedJob opened(job, listening, checkpointMemory(job));
  drawInTiles(opened, 7, false, listening);
  expectOneCount(listening.told, "frame 7", "pixels");
  EXPECT_EQ(listening.told.size(), 5u);
  EXPECT_EQ(listening.told.back().total, 600u * 550);
}

struct TileTimes {
  double wall_s = 0;
  BusyTimes busy;
};

// Returns the sum of the times in a file of tiles, whose records begin with a rectangle, the time and the busy times.
TileTimes timesIn(const std::filesystem::path& tiles) {
  TileTimes out;
  bool is_identity = true;
  readRecords(tiles, {'K', 'I', 'L', 'N', 'T', 'I', 'L', '3'}, [&](std::span<const std::byte> payload) {
    if (std::exchange(is_identity, false)) return true;
    ByteTaker taker{payload};
    taker.take<PixelRect>();
    out.wall_s += taker.take<double>();
    out.busy.add(taker.take<BusyTimes>());
    return taker.ok;
  });
  return out;
}

// The second run finds all tiles finished and draws none: its times are those in the file and those of its plan.
TEST_F(FrameProgressOf, ACheckpointHasTheTimesOfAllRuns) {
  RenderJob job =
      parseJob(R"({"kiln": 2, "image": {"width": 600, "height": 550}, "volume": "volume.kiln", "output": "t.exr"})",
               folder_ / "job.json");
  Progress silent;
  const auto run = [&](bool resume) {
    OpenedJob opened(job, silent, checkpointMemory(job));
    return drawInTiles(opened, 7, resume, silent);
  };
  const DrawnFrame first = run(false), second = run(true);
  EXPECT_FALSE(first.continued);
  EXPECT_TRUE(second.continued);
  EXPECT_GT(first.statistics.voxels_splats, 0u);
  EXPECT_EQ(second.statistics.voxels_splats, 0u);
  const TileTimes kept = timesIn(checkpointOf(job, 7));
  EXPECT_GT(kept.wall_s, 0);
  EXPECT_GT(kept.busy.total(), 0);
  EXPECT_GE(second.statistics.wall_s, kept.wall_s);
  EXPECT_GE(second.statistics.busy.total(), kept.busy.total());
}

// Known because the test makes the calls itself.
TEST(PartProgress, TellsOfThoseThatAreDrawnTogether) {
  Listening listening;
  PartProgress part(listening, "bricks", 10);
  part.reached(3);
  part.within(4, 1, 8);
  part.within(4, 2, 8);
  part.within(4, 8, 8);
  part.reached(7);
  part.reached(10);
  part.finish();
  std::vector<std::uint64_t> done;
  for (const Told& told : listening.told) done.push_back(told.done);
  EXPECT_EQ(done, (std::vector<std::uint64_t>{0, 3, 4, 7, 10}));
  Listening nobody;
  PartProgress(nobody, "bricks", 0).finish();
  EXPECT_TRUE(nobody.told.empty()) << "of nothing there is no share";
}

}  // namespace
}  // namespace kiln::test
