// A scanned head against the reference renderer in double precision, with equal volume, camera, transfer function and
// shading. The quick test uses a ray a pixel, which is less exact at edges than the tested picture. The PSNR is
// therefore only reported, and the bounds catch gross errors (a flip, a seam, a wrong light). A picture shifted by two
// pixels fails the bounds. Pictures stay in the test's output: reference, splatted, difference.
#include <gtest/gtest.h>

#include <cstdio>

#include "convert/convert.h"
#include "image/compare.h"
#include "image/file/image_file.h"
#include "ingest/open_source.h"
#include "support/reference/drawing.h"
#include "support/reference/reference_renderer.h"
#include "support/volumes/procedural.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

namespace fs = std::filesystem;

TransferFunction skin(double threshold, double opaque) {
  TransferFunction out;
  out.points = {{threshold, {0.93, 0.74, 0.6}, 0.0}, {opaque, {0.93, 0.74, 0.6}, 0.95}};
  return out;
}

Image sideBySide(const std::vector<Image>& images) {
  Image out(images.front().width * static_cast<int>(images.size()), images.front().height);
  for (std::size_t i = 0; i < images.size(); ++i) {
    for (int y = 0; y < out.height; ++y)
      std::copy_n(images[i].pixel(0, y), 4 * images[i].width, out.pixel(images[i].width * static_cast<int>(i), y));
  }
  return out;
}

void compareWithReference(const DenseVolume& volume, const fs::path& store, const Camera& camera,
                          const TransferFunction& tf, int pixels, const ReferenceSettings& settings,
                          const std::string& name) {
  FrameRequest request;
  request.view = resolve(camera, {pixels, pixels});
  request.transfer_function = tf;
  request.opacity_threshold = 0.9999;
  request.level = 0;
  const Image splatted = draw(store, request);
  const Image reference = referenceImage(volume, request.view, tf, request.shading, {0, 0, 0, 0}, settings);
  const ImageDifference d = compareImages(reference, splatted);
  const fs::path picture = fs::path(KILN_TEST_OUTPUT_DIR) / ("reference_" + name + ".png");
  writeImage(sideBySide({reference, splatted, differenceImage(reference, splatted)}), {}, {}, picture);
  std::printf("%s: PSNR %.2f dB, foreground %.2f dB, mean brightness ratio %.4f; %s\n", name.c_str(), d.psnr_db,
              d.foreground_psnr_db, d.mean_brightness_ratio, picture.c_str());
  // The reference shifted by two pixels: a geometric error in this scene has this size.
  Image shifted(pixels, pixels);
  for (int y = 0; y < pixels; ++y) std::copy_n(reference.pixel(0, y), 4 * (pixels - 2), shifted.pixel(2, y));
  EXPECT_GT(d.foreground_psnr_db, compareImages(reference, shifted).foreground_psnr_db);
  EXPECT_GT(d.foreground_psnr_db, 25);
  EXPECT_NEAR(d.mean_brightness_ratio, 1, 0.02);
}

class ReferenceComparison : public ::testing::TestWithParam<Projection> {};

void realHead(Projection projection, const ReferenceSettings& settings, const std::string& name) {
  const fs::path input = fs::path(KILN_TEST_DATA_DIR) / "cthead_256x256x113_u16le.nrrd";
  if (!fs::exists(input)) GTEST_SKIP() << input << " is not here; no comparison on a real head";
  const auto source = openSource(input);
  DenseVolume volume{source->info().geometry, source->info().type, {}};
  volume.voxels.resize(static_cast<std::size_t>(volume.geometry.dims.count()) * sizeOf(volume.type));
  source->read(boxOf(volume.geometry.dims), volume.voxels);
  const fs::path store = makeStore(volume, "reference_cthead_" + name, 128);
  Camera camera = cameraFrom(volume.geometry, {-0.5, -1, -0.3}, projection);
  camera.up = {0, 0, -1};  // the scan begins at the top of the head
  // A pixel a voxel: the box's diagonal is 427 voxels of spacing 1.
  compareWithReference(volume, store, camera, skin(400, 600), 436, settings, "cthead_" + name);
}

TEST_P(ReferenceComparison, SkinOfARealHead) {
  realHead(GetParam(), {1, 0.5, 1}, GetParam() == Projection::kPerspective ? "perspective" : "orthographic");
}
TEST_P(ReferenceComparison, NightlySkinOfARealHeadFinely) {
  realHead(GetParam(), {4, 0.1, 1}, GetParam() == Projection::kPerspective ? "perspective_fine" : "orthographic_fine");
}

INSTANTIATE_TEST_SUITE_P(Projections, ReferenceComparison,
                         ::testing::Values(Projection::kOrthographic, Projection::kPerspective));

}  // namespace
}  // namespace kiln::test
