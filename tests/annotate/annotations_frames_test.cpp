// The camera that leaves room for a legend is one in all programs. Known: frames, views and dry runs of a job draw the
// same camera; in a film the camera does not follow the legend.
#include <gtest/gtest.h>

#include <filesystem>

#include "frame/render_frame.h"
#include "sequence/dry_run.h"
#include "sequence/frame_requests.h"
#include "sequence/opened_job.h"
#include "support/volumes/procedural.h"
#include "support/volumes/test_store.h"
#include "view/view_painter.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

DenseVolume ballFor(int edge, bool labels) {
  return fill({.dims = {edge, edge, edge}, .type = VoxelType::u8}, [&](auto x, auto y, auto z) {
    const glm::dvec3 p = (glm::dvec3(x, y, z) + 0.5) / static_cast<double>(edge) * 2.0 - 1.0;
    if (glm::dot(p, p) > 0.7) return 0.0;
    return labels ? 1 + (p.x > 0 ? 1.0 : 0.0) + (p.y > 0 ? 2.0 : 0.0) : 200.0;
  });
}

TransferFunction orangeSurface() { return {.points = {{100, glm::dvec3(1), 0}, {150, {1, 0.5, 0}, 0.9}}}; }

TransferFunction regionsNamed(const std::string& name) {
  TransferFunction out;
  for (int label = 1; label <= 4; ++label) out.labels.push_back({double(label), name, glm::dvec3(0.5), 1});
  return out;
}

// A job of 160 × 120 pixels with a legend, zoomed so that bricks are outside of the picture.
RenderJob jobWithLegend(const fs::path& volume) {
  RenderJob out;
  out.volume = volume;
  out.picture.size = {160, 120};
  out.picture.transfer_function = orangeSurface();
  out.picture.annotations.legend = true;
  out.picture.camera.side = Side::kFront;
  out.picture.camera.zoom = 2.5;
  return out;
}

Camera cameraOfJob(const RenderJob& job, int frame = 1) {
  Progress silent;
  return OpenedJob(job, silent).sceneAt(frame).camera;
}

void expectEqualCameras(const Camera& a, const Camera& b, const char* why) {
  EXPECT_EQ(a.eye, b.eye) << why;
  EXPECT_EQ(a.target, b.target) << why;
  EXPECT_EQ(a.fov_deg, b.fov_deg) << why;
  EXPECT_EQ(a.height, b.height) << why;
}

TEST(AnnotatedCameras, AreEqualInAllPrograms) {
  const fs::path store = makeStore(ballFor(48, false), "volume", 8),
                 labels = makeStore(ballFor(48, true), "labels", 8, true);
  RenderJob plain = jobWithLegend(store), coloured = plain, of_labels = jobWithLegend(labels);
  coloured.companions.color_by = ColorByChoice{labels, regionsNamed("a name of some length")};
  of_labels.picture.transfer_function = regionsNamed("region");
  for (const RenderJob& job : {plain, coloured, of_labels}) {
    Progress silent;
    OpenedJob opened(job, silent);
    const FrameScene scene = opened.sceneAt(1);
    ViewPainter painter(job, silent);
    expectEqualCameras(painter.prepare(job, silent)->scene.camera, scene.camera, "view");
    BrickWalkCounts counts;
    const OpenedVolumes volumes(job);
    const auto seenBy = [&](const FrameScene& of) {
      return bricksInView(volumes.all(), requestOf(of, job.speed), counts).size();
    };
    EXPECT_EQ(dryRun(job, 0).bricks_in_view, seenBy(scene));
    RenderJob without = job;
    without.picture.annotations = {};
    EXPECT_NE(seenBy(OpenedJob(without, silent).sceneAt(1)), seenBy(scene)) << "the test sees a difference of cameras";
  }
  EXPECT_NE(cameraOfJob(coloured).target, cameraOfJob(plain).target) << "the legend is that of the colours";
}

TEST(AnnotatedCameras, DoNotFollowTheLegend) {
  const fs::path store = makeStore(ballFor(24, true), "labels", 8, true);
  RenderJob job = jobWithLegend(store);
  const std::string wide = "a long name of a region", narrow = "a";
  const auto key = [](double frame, const std::string& name) {
    return Key<TransferFunctionChoice>{frame, {}, regionsNamed(name)};
  };
  job.animation.functions = {key(1, narrow), key(5, wide)};
  job.picture.annotations.text = "{frame}";
  const Camera first = cameraOfJob(job, 1);
  for (const int frame : {2, 3, 5, 9}) expectEqualCameras(cameraOfJob(job, frame), first, "frame");
  job.animation.functions = {};
  job.picture.transfer_function = regionsNamed(wide);
  expectEqualCameras(cameraOfJob(job), first, "the widest legend decides");
  job.picture.transfer_function = regionsNamed(narrow);
  EXPECT_NE(cameraOfJob(job).target, first.target);
}

// An explicit camera is that of the user.
TEST(AnnotatedCameras, OfTheUser_areUnchanged) {
  const fs::path store = makeStore(ballFor(24, false), "volume", 8);
  RenderJob job = jobWithLegend(store);
  const auto withoutLegend = [](RenderJob from) {
    from.picture.annotations = {};
    return from;
  };
  EXPECT_NE(cameraOfJob(job).target, cameraOfJob(withoutLegend(job)).target);
  job.picture.fit = Fit::kBox;
  EXPECT_NE(cameraOfJob(job).target, cameraOfJob(withoutLegend(job)).target);
  RenderJob targeted = job;
  targeted.picture.camera.target = glm::dvec3(5, 5, 5);
  expectEqualCameras(cameraOfJob(targeted), cameraOfJob(withoutLegend(targeted)), "target");
  job.picture.camera = {};
  job.picture.camera.eye = glm::dvec3(10, -100, 5);
  job.picture.camera.projection = Projection::kOrthographic;
  expectEqualCameras(cameraOfJob(job), cameraOfJob(withoutLegend(job)), "eye");
  job.picture.camera = {};
  job.picture.camera.projection = Projection::kEquirectangular;
  job.picture.size = {160, 80};
  expectEqualCameras(cameraOfJob(job), cameraOfJob(withoutLegend(job)), "panorama");
}

}  // namespace
}  // namespace kiln::test
