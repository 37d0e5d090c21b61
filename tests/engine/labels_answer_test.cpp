// Pictures of label volumes with the default number of samples. Known from a slab's closed form, and from the reference
// renderer, which interpolates each label separately in double precision.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "image/compare.h"
#include "image/file/image_file.h"
#include "job/frame/auto_samples.h"
#include "store/store_reader.h"
#include "support/reference/contact_sheet.h"
#include "support/reference/drawing.h"
#include "support/reference/lattices.h"
#include "support/reference/quality_scenes.h"
#include "support/reference/reference_renderer.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

// Twelve voxels of a label between two hidden labels. At each face, interpolation adds as much inside as outside.
TEST(LabelPictures, ASlabHasItsClosedForm) {
  const DenseVolume volume = fill({{40, 40, 40}, VoxelType::u8}, [](auto, auto, auto z) {
    return z < 14 ? 200 : z < 26 ? 3 : 7;
  });
  const auto store = makeStore(volume, "slab", 16, true);
  for (const Lattice lattice : kLattices) {
    for (const double opacity : {0.01, 0.05, 0.2}) {
      FrameRequest request;
      setLattice(request, lattice);
      request.level = 0;
      Camera camera;
      camera.projection = Projection::kOrthographic;
      camera.eye = {19.5, 19.5, -100}, camera.target = {19.5, 19.5, 19.5}, camera.up = {0, 1, 0};
      camera.height = 10;
      request.view = resolve(camera, {32, 32});
      request.opacity_threshold = 1;
      request.shading.phong = false;
      request.transfer_function.labels = {{3, "", {1, 0.5, 0}, opacity}, {9, "", {0, 0, 1}, 1}};
      const Image image = draw(store, request);
      double mean[4] = {};
      for (std::size_t i = 0; i < image.rgba.size(); ++i) mean[i % 4] += image.rgba[i] / (32.0 * 32.0);
      const double alpha = 1 - std::pow(1 - opacity, 12), expected[4] = {alpha, 0.5 * alpha, 0, alpha};
      for (int c = 0; c < 4; ++c)
        EXPECT_NEAR(mean[c], expected[c], 0.005 * alpha) << nameOf(lattice) << ", channel " << c << ", " << opacity;
    }
  }
}

constexpr int kLabelPixels = 64;

// Two boxes that share a sloped face, a ball through both, and a translucent body around them.
DenseVolume fewBodies() {
  return fill({{36, 36, 36}, VoxelType::u16}, [](auto x, auto y, auto z) {
    const glm::dvec3 p(x - 18, y - 18, z - 18);
    if (glm::length(p - glm::dvec3(2, -5, 4)) < 7) return 1000;
    if (std::abs(p.x) < 9 && std::abs(p.y) < 6 && p.z > -10 && p.z < 0.3 * p.x) return 20;
    if (std::abs(p.x) < 9 && std::abs(p.y) < 6 && p.z >= 0.3 * p.x && p.z < 9) return 3;
    return glm::length(p) < 15 ? 7 : 0;
  });
}

class LabelPicture : public ::testing::TestWithParam<Interpolation> {};

TEST_P(LabelPicture, IsThatOfTheReference) {
  const DenseVolume volume = fewBodies();
  const auto store = makeStore(volume, "bodies", 32, true);
  const StoreReader reader(store);
  std::vector<std::vector<Image>> sheet(3);
  for (const bool solid : {true, false}) {
    TransferFunction function;
    function.labels = {
        {3, "", {0.8, 0.3, 0.2}, 0.95}, {20, "", {0.2, 0.6, 0.3}, 0.95}, {1000, "", {0.3, 0.4, 0.9}, 0.9}};
    if (!solid) function.labels.insert(function.labels.begin() + 1, {7, "", {0.9, 0.8, 0.6}, 0.03});
    for (const auto& [px_per_voxel, least_db] : {std::pair{1.0, 38.0}, {2.0, 34.0}}) {
      // The reference takes 64 voxels for each sample of the B-spline.
      if (GetParam() == Interpolation::kCubic && (!solid || px_per_voxel == 1)) continue;
      const Projection projection = solid ? Projection::kPerspective : Projection::kOrthographic;
      Camera camera = cameraFrom(volume.geometry, {-0.55, -1, 0.35}, projection);
      const double height = kLabelPixels / px_per_voxel;
      camera.fov_deg = 360 / 3.14159265358979 *
                       std::atan(std::tan(camera.fov_deg * 3.14159265358979 / 360) * height / camera.height);
      camera.height = height;
      FrameRequest request;
      request.view = resolve(camera, {kLabelPixels, kLabelPixels});
      request.opacity_threshold = 0.9999;
      request.transfer_function = function;
      request.interpolation = GetParam();
      RenderJob job;
      job.picture.size = request.view.size;
      request.samples = automaticSamples(job, camera, centreOf(volume.geometry), {&reader.manifest()});
      ReferenceSettings settings{3, 0.2, 0.9999};
      settings.interpolation = GetParam();
      settings.label_smoothing = 2;  // the largest smoothing that a brick's apron allows at these sizes
      const Image truth = referenceImage(volume, request.view, function, {}, {}, settings),
                  image = draw(store, request);
      const ImageDifference ours = compareImages(truth, image);
      std::printf("%s, %s, %.0f px/voxel: %.1f dB, brightness %+.2f %%\n", solid ? "solid" : "translucent",
                  nameIn(kInterpolationNames, GetParam()).data(), px_per_voxel, ours.foreground_psnr_db,
                  100 * (ours.mean_brightness_ratio - 1));
      EXPECT_GE(ours.foreground_psnr_db, least_db);
      EXPECT_NEAR(ours.mean_brightness_ratio, 1, 0.03);
      sheet[0].push_back(image);
      sheet[1].push_back(truth);
      sheet[2].push_back(differenceImage(image, truth));
    }
  }
  writeContactSheet(sheet, kLabelPixels, fmt::format("labels_{}.png", nameIn(kInterpolationNames, GetParam())));
}

INSTANTIATE_TEST_SUITE_P(Interpolations, LabelPicture,
                         ::testing::Values(Interpolation::kLinear, Interpolation::kCubic));

}  // namespace
}  // namespace kiln::test
