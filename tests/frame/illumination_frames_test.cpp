// Shadow maps and ambient occlusion from frame to frame, and their memory. Known: a map stays exactly if its light
// stays, and maps of two frames of a moving light are never in memory together.
#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <memory>
#include <utility>

#include "base/thread/parallel.h"
#include "frame/frame_memory.h"
#include "frame/light/illuminate.h"
#include "frame/light/light_plan.h"
#include "store/store_reader.h"
#include "support/reference/drawing.h"
#include "support/system/expect_error.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

constexpr int kMapEdge = 48;

Light lightAt(LightKind kind, const glm::dvec3& place, double softness = 0) {
  Light out;
  out.kind = kind;
  out.place = place;
  out.shadow.resolution = kMapEdge;
  out.shadow.softness = softness;
  return out;
}

// Calls a function at each question whether the frame is cancelled, which is its answer.
struct Watch : Progress {
  explicit Watch(std::function<bool()> the_question) : question(std::move(the_question)) {}
  bool cancelled() const override { return question(); }
  std::function<bool()> question;
};

class IlluminationFrames : public ::testing::Test {
 protected:
  IlluminationFrames()
      : store_(makeStore(ball({{32, 32, 32}, VoxelType::u8}, {15, 15, 15}, 10, 200), "illumination", 16)),
        cache_({&store_}, 1ull << 28, 0) {
    request_.view = resolve({.eye = {15.5, -60, 15.5}, .target = {15.5, 15.5, 15.5}, .up = {0, 0, 1}}, {64, 64});
    request_.transfer_function.unit = 1;
    request_.transfer_function.points = {{100, {1, 1, 1}, 0.0}, {180, {1, 1, 1}, 0.9}};
    request_.shading.shadows = true;
    request_.shading.occlusion.strength = 0.5;
    request_.shading.lights = {lightAt(LightKind::kDirectional, {-1, -1, 1}),
                               lightAt(LightKind::kDirectional, {1, -1, 1})};
    request_.last_illumination = &last_;
  }
  void light(FrameRequest request, Progress& progress) {
    FrameStatistics ignored;
    illuminate(cache_, progress, request, ignored);
  }
  std::shared_ptr<const DeepShadowMap> mapOf(std::size_t light) const {
    return last_->lights[light].points.front().front();
  }
  std::uint64_t bytesOf(const Light& light, bool lights_move = false) const {
    Shading shading;
    shading.shadows = true;
    shading.lights = {light};
    return illuminationBytes({&store_}, {Clipping()}, shading, lights_move, {64, 64});
  }

  const StoreReader store_;
  BrickCache cache_;
  FrameRequest request_;
  std::shared_ptr<const Illumination> last_;
  Progress silent_;
};

TEST_F(IlluminationFrames, MovedLight_losesItsMapBeforeAnotherIsDrawn) {
  light(request_, silent_);
  const std::weak_ptr<const DeepShadowMap> moved = mapOf(0);
  const auto standing = mapOf(1);
  const auto ambient = last_->ambient;
  request_.shading.lights[0].place = {0, -1, 1};
  std::atomic<bool> drawn = false, both = false;
  Watch maps([&] {
    drawn = true;
    if (!moved.expired()) both = true;
    return false;
  });
  light(request_, maps);
  EXPECT_TRUE(drawn);
  EXPECT_FALSE(both);
  EXPECT_EQ(mapOf(1), standing);
  EXPECT_EQ(last_->ambient, ambient);
}

// Known because a picture of the same view without shadows draws the same bricks.
TEST_F(IlluminationFrames, Statistics_countTheBricksOfThePictureAlone) {
  const ThreadLimit one(1);  // the number of hidden bricks repeats
  request_.last_illumination = nullptr;
  FrameRequest plain = request_;
  plain.shading.shadows = false;
  plain.shading.occlusion.strength = 0;
  FrameStatistics lit, unlit;
  renderFrame(cache_, request_, silent_, lit);
  renderFrame(cache_, plain, silent_, unlit);
  ASSERT_EQ(lit.levels.size(), unlit.levels.size());
  for (std::size_t level = 0; level < lit.levels.size(); ++level) {
    EXPECT_EQ(lit.levels[level].bricks, unlit.levels[level].bricks) << level;
    EXPECT_EQ(lit.levels[level].voxels_splats, unlit.levels[level].voxels_splats) << level;
  }
  EXPECT_EQ(lit.bricks_total, unlit.bricks_total);
  EXPECT_EQ(lit.bricks_interesting, unlit.bricks_interesting);
  EXPECT_EQ(lit.bricks_hidden, unlit.bricks_hidden);
  EXPECT_GT(lit.voxels_visited, unlit.voxels_visited);
}

TEST_F(IlluminationFrames, CancelledFrame_leavesItsFinishedParts) {
  Watch first_light([&] { return last_ != nullptr && !last_->lights[0].points.empty(); });
  expectError([&] { light(request_, first_light); }, ErrorCode::kCancelled, "");
  ASSERT_TRUE(last_->ambient);
  ASSERT_TRUE(last_->lights[1].points.empty());
  const auto ambient = last_->ambient;
  const auto map = mapOf(0);
  light(request_, silent_);
  EXPECT_EQ(last_->ambient, ambient);
  EXPECT_EQ(mapOf(0), map);
  EXPECT_FALSE(last_->lights[1].points.empty());
}

// A soft light has a map for each of its points, or six for each point that the volume surrounds. A point light that
// moves may be surrounded in some frame.
TEST_F(IlluminationFrames, Memory_isForTheMapsOfALight) {
  const std::uint64_t map = DeepShadowMap::bytesFor(kMapEdge, kMapEdge, false);
  const glm::dvec3 distant(15, -200, 15), within(15, 15, 14);
  const std::uint64_t one = bytesOf(lightAt(LightKind::kPoint, distant));
  EXPECT_EQ(bytesOf(lightAt(LightKind::kDirectional, {-1, -1, 1})), one);
  EXPECT_EQ(bytesOf(lightAt(LightKind::kDirectional, {-1, -1, 1}, 10), true), one + 15 * map);
  EXPECT_EQ(bytesOf(lightAt(LightKind::kCamera, {-1, 1, 1}, 10)), one + 15 * map);
  EXPECT_EQ(bytesOf(lightAt(LightKind::kPoint, distant, 10)), one + 15 * map);
  EXPECT_EQ(bytesOf(lightAt(LightKind::kPoint, within)), one + 5 * map);
  EXPECT_EQ(bytesOf(lightAt(LightKind::kPoint, within, 10)), one + 95 * map);
  EXPECT_EQ(bytesOf(lightAt(LightKind::kPoint, distant, 10), true), one + 95 * map);
}

// Shadow maps are drawn by the pixel engine, whatever engine draws the picture.
TEST_F(IlluminationFrames, Memory_isForTheEngineOfTheMaps) {
  RenderJob job;
  job.volume = store_.path();
  job.picture.size = {64, 64};
  job.picture.lattice = Lattice::kPixel;
  const std::uint64_t of_pixels = frameMemory(store_, job).least_slabs;
  job.picture.lattice = Lattice::kVoxel;
  EXPECT_LT(frameMemory(store_, job).least_slabs, of_pixels);
  job.picture.shading = request_.shading;
  job.picture.shading.occlusion = {};
  EXPECT_GE(frameMemory(store_, job).least_slabs, of_pixels);
}

}  // namespace
}  // namespace kiln::test
