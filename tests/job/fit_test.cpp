// The box that a default camera fits, by the options of the job. Known: the functions and the box that a finder of
// boxes is asked for, and the middle of the box that it returns, which the camera looks at.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <numeric>
#include <optional>

#include "job/frame/frame_scene.h"
#include "scene/camera/framing.h"
#include "scene/transfer/projection_range.h"

namespace kiln::test {
namespace {

// Air of 0, and an object of 1000 in an eighth of 100³ voxels.
Manifest objectInAir() {
  Manifest out;
  out.type = VoxelType::f32;
  out.range = {0, 1000};
  out.histogram = {0, 1000, std::vector<std::uint64_t>(256)};
  out.histogram.counts.front() = 875000, out.histogram.counts.back() = 125000;
  out.levels.resize(1);
  out.levels[0].geometry.dims = {100, 100, 100};
  return out;
}

const VoxelBox kObject = {{10, 20, 30}, {31, 41, 51}};

struct Fitted {
  std::optional<TransferFunction> asked;  // nothing if no box was asked for
  glm::dvec3 target;
};

// In a parallel view the middle of a box is seen in the middle of its extent.
Fitted fittedBy(RenderJob job) {
  job.picture.camera.projection = Projection::kOrthographic;
  const Manifest manifest = objectInAir();
  Fitted out;
  const ShownBoxOf shown_box = [&](std::size_t, const std::vector<TransferFunction>& functions, const Clipping&) {
    out.asked = functions.front();
    return FramedBox(partOf(manifest.geometry(), kObject));
  };
  const SceneOfJob scenes(job, {&manifest}, {.shown_box = shown_box});
  out.target = scenes.at(1).camera.target;
  return out;
}

constexpr glm::dvec3 kMiddleOfObject(20, 30, 40), kMiddleOfAll(49.5, 49.5, 49.5);

void expectAt(const glm::dvec3& found, const glm::dvec3& expected, const char* why = "") {
  EXPECT_LT(glm::distance(found, expected), 1e-9) << why;
}

TEST(Fit, IsOfTheVisiblePart) {
  RenderJob job;
  const Fitted fitted = fittedBy(job);
  ASSERT_TRUE(fitted.asked);
  expectAt(fitted.target, kMiddleOfObject);
  job.picture.fit = Fit::kRegion;
  expectAt(fittedBy(job).target, kMiddleOfAll);
}

TEST(Fit, WithAnOutline_isOfTheRegion) {
  RenderJob job;
  job.picture.annotations.box = true;
  expectAt(fittedBy(job).target, kMiddleOfAll);
  job.picture.clipping.region = VoxelBox{{0, 0, 0}, {20, 40, 60}};
  expectAt(fittedBy(job).target, glm::dvec3(9.5, 19.5, 29.5));
  job.picture.fit = Fit::kVisible;
  expectAt(fittedBy(job).target, kMiddleOfObject);
}

// The background is the colour of the least value: what is hardly brighter is not seen.
TEST(Fit, OfProjections_isOfWhatIsBrighterThanTheBackground) {
  for (const Mode mode : {Mode::kMip, Mode::kAttenuatedMip, Mode::kAverage}) {
    RenderJob job;
    job.picture.mode = mode;
    const Fitted fitted = fittedBy(job);
    ASSERT_TRUE(fitted.asked);
    expectAt(fitted.target, kMiddleOfObject);
    const ValueRange window = projectionRange(objectInAir(), mode);
    EXPECT_EQ(fitted.asked->at(window.lo).opacity, 0);
    EXPECT_EQ(fitted.asked->at(std::midpoint(window.lo, window.hi)).opacity, 1);
    job.picture.background = Background();
    expectAt(fittedBy(job).target, kMiddleOfAll, "the border of the region is seen");
  }
  RenderJob job;
  job.picture.mode = Mode::kMinip;
  expectAt(fittedBy(job).target, kMiddleOfAll);
}

// A colour map covers the window of a projection unless the user gives one.
TEST(Fit, ColorMapsOfProjections_coverTheirRange) {
  RenderJob job;
  job.picture.mode = Mode::kAverage;
  job.picture.transfer_function = std::string("viridis");
  const Manifest manifest = objectInAir();
  const ValueRange window = projectionRange(manifest, Mode::kAverage);
  const SceneOfJob scenes(job, manifest);
  EXPECT_NEAR(scenes.functionsOf(0).front().points.front().value, window.lo, 1e-9);
  EXPECT_NEAR(scenes.functionsOf(0).front().points.back().value, window.hi, 1e-9);
  job.picture.window = Window{300, 200};
  const SceneOfJob windowed(job, manifest);
  EXPECT_NEAR(windowed.functionsOf(0).front().points.front().value, 200, 1e-9);
  EXPECT_NEAR(windowed.functionsOf(0).front().points.back().value, 400, 1e-9);
}

}  // namespace
}  // namespace kiln::test
