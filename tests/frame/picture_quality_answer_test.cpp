// Pictures of a computed head against the reference renderer, with 9 rays a pixel (elsewhere 16) and steps of a quarter
// voxel. Views: far (a pixel a voxel) and near, opaque and through translucent skin. Known because the reference
// samples the picture's definition densely. Required: a PSNR over the foreground, a margin over a ray caster with voxel
// steps, and the reference's brightness. A sheet of pictures stays in the test's output: ours, the reference's and the
// difference, a row each.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <numbers>

#include "image/compare.h"
#include "image/file/image_file.h"
#include "job/job_names.h"
#include "scene/camera/camera_path.h"
#include "scene/transfer/presets.h"
#include "sequence/render_job_run.h"
#include "store/store_reader.h"
#include "support/reference/contact_sheet.h"
#include "support/reference/drawing.h"
#include "support/reference/lattices.h"
#include "support/reference/quality_scenes.h"
#include "support/reference/reference_renderer.h"
#include "support/volumes/random_scene.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

constexpr int kHeadPixels = 128;

// Required quality. At a pixel a voxel, the head's wood grain is as fine as the pixels.
struct Magnification {
  double px_per_voxel, least_db, over_voxel_steps_db, brightness;
};
constexpr Magnification kMagnifications[] = {{1, 32, 2, 0.02}, {2, 36, 7, 0.01}, {4, 43, 12, 0.01}};

Camera cameraAt(const VolumeGeometry& volume, Projection projection, double px_per_voxel) {
  Camera camera = cameraFrom(volume, {-0.55, -1, 0.25}, projection);
  if (px_per_voxel > 1) camera.target = volume.worldOf({60, 30, 78});  // an eye and a cheek
  camera.eye +=
      camera.target - volume.worldOf(glm::dvec3(volume.dims.x - 1, volume.dims.y - 1, volume.dims.z - 1) / 2.0);
  camera.height = kHeadPixels / px_per_voxel * volume.meanSpacing();
  camera.fov_deg =
      2 * std::atan(0.5 * camera.height / glm::length(camera.eye - camera.target)) * 180 / std::numbers::pi;
  return camera;
}

struct Drawn {
  std::uint64_t splats;
  double db, voxel_steps_db;
};

// Samples 2/3 of a voxel apart reduce the number of samples by a tenth or more. In opaque bodies few samples lie behind
// each other, and slabs are at most a pixel thick. The pictures are still ahead of the ray caster's, and nearer samples
// make no picture worse.
void expectFartherSamples(const std::filesystem::path& store, FrameRequest request, const Image& truth,
                          const Drawn& by_default, const Magnification& must) {
  FrameStatistics farther;
  request.sample_distance = 2.0 / 3;
  const ImageDifference far = compareImages(truth, draw(store, request, std::uint64_t{1} << 30, &farther));
  request.sample_distance = 0.25;
  const ImageDifference near = compareImages(truth, draw(store, request));
  std::printf(
      "  samples 2/3 and 1/4 of a voxel apart: %.1f and %.1f dB, brightness %+.2f and %+.2f %%; %.2f of the samples\n",
      far.foreground_psnr_db, near.foreground_psnr_db, 100 * (far.mean_brightness_ratio - 1),
      100 * (near.mean_brightness_ratio - 1),
      static_cast<double>(farther.voxels_splats) / static_cast<double>(by_default.splats));
  EXPECT_GE(far.foreground_psnr_db, must.px_per_voxel > 1 ? 34 : 28);
  EXPECT_GE(far.foreground_psnr_db, by_default.voxel_steps_db);
  EXPECT_NEAR(far.mean_brightness_ratio, 1, must.brightness);
  EXPECT_LT(farther.voxels_splats, 9 * by_default.splats / 10);
  // At a pixel a voxel, samples are already half a pixel apart by default.
  EXPECT_GE(near.foreground_psnr_db, by_default.db + (must.px_per_voxel > 1 ? 1 : -0.2));
  EXPECT_NEAR(near.mean_brightness_ratio, 1, must.brightness);
}

class PictureQuality : public ::testing::TestWithParam<Projection> {};

TEST_P(PictureQuality, IsThatOfTheReference) {
  const DenseVolume volume = readVolume("phantom:head:144x144x144");
  const std::filesystem::path store = makeStore(volume, "quality_head", 64);
  const StoreReader reader(store);
  std::vector<std::vector<Image>> sheet(6);
  std::size_t row = 0;
  for (const char* preset : {"ct-skin", "ct-bone-and-skin"}) {
    for (const Magnification& must : kMagnifications) {
      SCOPED_TRACE(fmt::format("{}, {} px/voxel", preset, must.px_per_voxel));
      FrameRequest request;
      setLattice(request, Lattice::kPixel);
      request.view = resolve(cameraAt(volume.geometry, GetParam(), must.px_per_voxel), {kHeadPixels, kHeadPixels});
      request.transfer_function = presetFor(preset, reader.manifest());
      request.opacity_threshold = 0.9999;
      const auto reference = [&](const ReferenceSettings& settings) {
        return referenceImage(volume, request.view, request.transfer_function, request.shading, {0, 0, 0, 0}, settings);
      };
      FrameStatistics statistics;
      const Image truth = reference({3, 0.25, 0.9999});
      const Image image = draw(store, request, std::uint64_t{1} << 30, &statistics);
      const ImageDifference ours = compareImages(truth, image);
      const ImageDifference voxel_steps = compareImages(truth, reference(ReferenceSettings::vtkLike()));
      std::printf("%s %s, %.0f px/voxel: %.1f dB (voxel by voxel %.1f dB), brightness %+.2f %%\n", preset,
                  nameOf(GetParam()), must.px_per_voxel, ours.foreground_psnr_db, voxel_steps.foreground_psnr_db,
                  100 * (ours.mean_brightness_ratio - 1));
      EXPECT_GE(ours.foreground_psnr_db, must.least_db);
      EXPECT_GE(ours.foreground_psnr_db, voxel_steps.foreground_psnr_db + must.over_voxel_steps_db);
      EXPECT_NEAR(ours.mean_brightness_ratio, 1, must.brightness);
      expectFartherSamples(store, request, truth,
                           {statistics.voxels_splats, ours.foreground_psnr_db, voxel_steps.foreground_psnr_db}, must);
      // The ray caster takes steps of half a voxel, at least half a pixel. Its pixels are point samples; ours are
      // filtered.
      EXPECT_GE(ours.foreground_psnr_db, compareImages(truth, reference({1, 0.5, 1})).foreground_psnr_db + 2);
      sheet[row].push_back(image);
      sheet[row + 1].push_back(truth);
      sheet[row + 2].push_back(differenceImage(image, truth));
    }
    row += 3;
  }
  writeContactSheet(sheet, kHeadPixels, fmt::format("quality_{}.png", nameOf(GetParam())));
}

// Cubic interpolation against the reference's cubics, at a magnification where most samples lie between voxels.
// Required: as near as linear interpolation is to the linear reference (42.9 to 48.3 dB). The linear picture is 9.6 dB
// or more farther from the cubic reference.
TEST_P(PictureQuality, OfCubicsIsThatOfTheReference) {
  constexpr int kSmall = 64;
  const DenseVolume volume = readVolume("phantom:head:144x144x144");
  const std::filesystem::path store = makeStore(volume, "quality_head", 64);
  FrameRequest request;
  request.view = resolve(cameraAt(volume.geometry, GetParam(), 4), {kSmall, kSmall});
  request.transfer_function = presetFor("ct-skin", StoreReader(store).manifest());
  request.opacity_threshold = 0.9999;
  const Image linear = draw(store, request);
  std::vector<std::vector<Image>> sheet;
  for (const Interpolation interpolation : {Interpolation::kCubic, Interpolation::kCatmullRom}) {
    const char* const name = nameIn(kInterpolationNames, interpolation).data();
    SCOPED_TRACE(name);
    ReferenceSettings settings{4, 0.25, 0.9999};
    settings.interpolation = request.interpolation = interpolation;
    const Image truth =
        referenceImage(volume, request.view, request.transfer_function, request.shading, {0, 0, 0, 0}, settings);
    const Image image = draw(store, request);
    const ImageDifference ours = compareImages(truth, image);
    const double linear_db = compareImages(truth, linear).foreground_psnr_db;
    std::printf("%s, %s: %.1f dB (linear %.1f dB), brightness %+.2f %%\n", nameOf(GetParam()), name,
                ours.foreground_psnr_db, linear_db, 100 * (ours.mean_brightness_ratio - 1));
    EXPECT_GE(ours.foreground_psnr_db, 42.5);
    EXPECT_GE(ours.foreground_psnr_db, linear_db + 9);
    EXPECT_NEAR(ours.mean_brightness_ratio, 1, 0.01);
    sheet.push_back({image, truth, differenceImage(image, truth)});
  }
  writeContactSheet(sheet, kSmall, fmt::format("quality_cubics_{}.png", nameOf(GetParam())));
}

// Voxels smaller than pixels, with the default number of samples a pixel: quality as for large voxels.
TEST_P(PictureQuality, OfSmallVoxelsIsThatOfTheReferenceByDefault) {
  const DenseVolume volume = readVolume("phantom:head:144x144x144");
  RenderJob job;
  job.volume = makeStore(volume, "quality_head", 64);
  job.picture.size = {kHeadPixels, kHeadPixels};
  job.picture.opacity_threshold = 0.9999;
  std::vector<std::vector<Image>> sheet;
  for (const char* preset : {"ct-skin", "ct-bone-and-skin"}) {
    for (const auto& [px_per_voxel, samples] : {std::pair{0.25, 16}, {0.5, 4}}) {
      SCOPED_TRACE(fmt::format("{}, {} px/voxel", preset, px_per_voxel));
      const Camera camera = cameraAt(volume.geometry, GetParam(), px_per_voxel);
      job.picture.camera = specOf(camera);
      job.picture.transfer_function = std::string(preset);
      job.picture.samples.reset();
      Progress silent;
      const RenderResult by_default = runRenderJob(job, 1, silent);
      const Image truth = referenceImage(volume, resolve(camera, job.picture.size), by_default.transfer_function,
                                         job.picture.shading, {0, 0, 0, 0}, {4, 0.25, 0.9999});
      const ImageDifference ours = compareImages(truth, by_default.image);
      job.picture.samples = 1;
      const double of_one_db = compareImages(truth, runRenderJob(job, 1, silent).image).foreground_psnr_db;
      std::printf("%s %s, %.2f px/voxel: %.1f dB (one sample %.1f dB), brightness %+.2f %%\n", preset,
                  nameOf(GetParam()), px_per_voxel, ours.foreground_psnr_db, of_one_db,
                  100 * (ours.mean_brightness_ratio - 1));
      EXPECT_GE(ours.foreground_psnr_db, 34);
      EXPECT_GE(ours.foreground_psnr_db, of_one_db + 5);
      EXPECT_NEAR(ours.mean_brightness_ratio, 1, 0.02);  // bound as for a pixel a voxel
      job.picture.samples = samples;
      EXPECT_TRUE(equalBits(by_default.image, runRenderJob(job, 1, silent).image));
      sheet.push_back({by_default.image, truth, differenceImage(by_default.image, truth)});
    }
  }
  writeContactSheet(sheet, kHeadPixels, fmt::format("quality_small_{}.png", nameOf(GetParam())));
}

INSTANTIATE_TEST_SUITE_P(Projections, PictureQuality,
                         ::testing::Values(Projection::kOrthographic, Projection::kPerspective));

}  // namespace
}  // namespace kiln::test
