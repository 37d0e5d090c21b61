// Panoramas. Known:
// 1. From the middle of a ball all directions are equal, so any step in the picture is a seam.
// 2. A mark appears at the pixel of its direction: left to right, at both ends behind the eye, at the top above the
// eye.
// 3. A depth is a distance.
// 4. A volume around the eye equals the reference renderer's picture along equal rays.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>

#include "image/compare.h"
#include "image/file/image_file.h"
#include "support/reference/drawing.h"
#include "support/reference/reference_renderer.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

TransferFunction solidFrom(double begin, double end, double opacity) {
  TransferFunction out;
  out.unit = 1;
  out.points = {{begin, {0.9, 0.7, 0.5}, 0.0}, {end, {0.9, 0.7, 0.5}, opacity}};
  return out;
}

FrameRequest panoramaOf(const glm::dvec3& eye, const glm::dvec3& ahead, const glm::dvec3& up, int height) {
  Camera camera;
  camera.projection = Projection::kEquirectangular;
  camera.eye = eye;
  camera.target = eye + ahead;
  camera.up = up;
  FrameRequest request;
  request.view = resolve(camera, {2 * height, height});
  request.opacity_threshold = 0.9999;
  return request;
}

TEST(Panorama, OfABallRoundTheEyeIsOneColour) {
  const DenseVolume volume = ball({{70, 70, 70}, VoxelType::f32}, {34.5, 34.5, 34.5}, 30, 100);
  const fs::path store = makeStore(volume, "panorama_ball", 32);
  FrameRequest request = panoramaOf({34.5, 34.5, 34.5}, {1, 0.3, 0.2}, {0.1, 0.2, 1}, 64);
  request.transfer_function = solidFrom(0, 100, 0.03);
  request.shading.phong = false;
  const Image image = draw(store, request);
  // The first half voxel of depth before the eye is not drawn: up to 0.63 of a voxel at a face's corner.
  const double expected = 1 - std::pow(0.97, 30 - 0.56);
  double sum = 0, worst = 0, step = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const double alpha = image.pixel(x, y)[3];
      sum += alpha;
      worst = std::max(worst, std::abs(alpha - expected));
      step = std::max(step, std::abs(alpha - image.pixel((x + 1) % image.width, y)[3]));
      if (y > 0) step = std::max(step, std::abs(alpha - image.pixel(x, y - 1)[3]));
    }
  }
  const double mean = sum / (image.width * image.height);
  std::printf("a ball of alpha %.4f: mean %.4f, off by %.4f at most; neighbours differ by %.4f at most\n", expected,
              mean, worst, step);
  EXPECT_NEAR(mean, expected, 0.01 * expected);
  EXPECT_LT(worst, 0.015);
  EXPECT_LT(step, 0.006);
}

TEST(Panorama, DepthsAreDistancesAndNormalsPointToTheEye) {
  // A hollow ball: solid beyond 24 voxels.
  const glm::dvec3 eye(34.5, 34.5, 34.5);
  const DenseVolume volume = fill({{70, 70, 70}, VoxelType::f32},
                                  [&](auto i, auto j, auto k) { return glm::distance(glm::dvec3(i, j, k), eye); });
  FrameRequest request = panoramaOf(eye, {0, 1, 0}, {0, 0, 1}, 48);
  request.transfer_function = solidFrom(23.9, 24.1, 1);
  request.aovs.depth = request.aovs.normal = true;
  FrameStatistics statistics;
  const Image image = draw(makeStore(volume, "panorama_hollow", 32), request, 512u << 20, &statistics);
  EXPECT_LE(statistics.bricks_interesting, statistics.bricks_total) << "counted once for all directions";
  const auto at = [&](const char* name) {
    return std::find_if(image.planes.begin(), image.planes.end(), [&](const Plane& p) { return p.name == name; })
        ->values;
  };
  const ZeroPages<float> first = at("Z"), mean = at("depth.mean");
  const ZeroPages<float> normal[3] = {at("N.X"), at("N.Y"), at("N.Z")};
  double worst = 0, worst_mean = 0, least_cosine = 1;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const auto i = static_cast<std::size_t>(y * image.width + x);
      EXPECT_NEAR(image.pixel(x, y)[3], 1, 1e-6);
      worst = std::max(worst, std::abs(first[i] - 24.0));
      worst_mean = std::max(worst_mean, std::abs(mean[i] - 24.0));
      const glm::dvec3 out = glm::transpose(glm::dmat3(request.view.view_from_world)) *
                             panoramaDirection(request.view, {x + 0.5, y + 0.5});
      least_cosine = std::min(least_cosine, -glm::dot(out, glm::dvec3(normal[0][i], normal[1][i], normal[2][i])));
    }
  }
  std::printf("distance 24: off by %.3f at most, the mean by %.3f; normals' least cosine %.4f\n", worst, worst_mean,
              least_cosine);
  EXPECT_LT(worst, 0.8);
  EXPECT_LT(worst_mean, 0.8);
  EXPECT_GT(least_cosine, 0.99);
}

// The brightest pixel. A mark behind the eye is at both ends.
glm::ivec2 brightest(const Image& image) {
  glm::ivec2 out(0);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      if (image.pixel(x, y)[3] > image.pixel(out.x, out.y)[3]) out = {x, y};
    }
  }
  return out;
}

TEST(Panorama, MarksAreWhereTheirDirectionsAre) {
  const glm::dvec3 eye(20, 20, 20), ahead(0, 1, 0), up(0, 0, 1), right(1, 0, 0);
  const int height = 64;
  struct Mark {
    glm::dvec3 direction;
    double x, y;  // as shares of the picture's width and height; at a pole only y is compared
  };
  const Mark marks[] = {
      {ahead, 0.5, 0.5}, {right, 0.75, 0.5}, {-right, 0.25, 0.5},         {-ahead, 1, 0.5},
      {up, -1, 0},       {-up, -1, 1},       {ahead + right, 0.625, 0.5}, {glm::normalize(ahead) + up, 0.5, 0.25}};
  int i = 0;
  for (const Mark& mark : marks) {
    const glm::dvec3 place = eye + 14.0 * glm::normalize(mark.direction);
    const DenseVolume volume = ball({{41, 41, 41}, VoxelType::f32}, place, 1.5, 100);
    FrameRequest request = panoramaOf(eye, ahead, up, height);
    request.transfer_function = solidFrom(10, 100, 0.3);
    const Image image = draw(makeStore(volume, "panorama_mark_" + std::to_string(i++), 32), request);
    const glm::ivec2 seen = brightest(image);
    EXPECT_NEAR(seen.y + 0.5, mark.y * height, 2.1) << i;
    if (mark.x < 0) continue;
    const double off = std::abs(seen.x + 0.5 - mark.x * 2 * height);
    EXPECT_LT(std::min(off, 2 * height - off), 2.1) << i;
  }
}

TEST(Panorama, FromInsideIsTheReferenceRenderers) {
  const DenseVolume volume = head({{96, 96, 96}, VoxelType::u8}, usualRange(VoxelType::u8));
  const fs::path store = makeStore(volume, "panorama_head", 32);
  FrameRequest request = panoramaOf({46, 49, 47}, {0.2, 1, 0.1}, {0.3, 0, 1}, 128);
  // Bone, seen from within the brain.
  request.transfer_function = solidFrom(185, 215, 0.9);
  const Image image = draw(store, request);
  const Image reference =
      referenceImage(volume, request.view, request.transfer_function, request.shading, {0, 0, 0, 0}, {3, 0.2, 0.9999});
  const ImageDifference d = compareImages(reference, image);
  writeImage(image, {}, {}, fs::path(KILN_TEST_OUTPUT_DIR) / "panorama.png");
  writeImage(reference, {}, {}, fs::path(KILN_TEST_OUTPUT_DIR) / "panorama_reference.png");
  std::printf("panorama of a head from inside: PSNR %.2f dB, foreground %.2f dB over %llu pixels, brightness %.4f\n",
              d.psnr_db, d.foreground_psnr_db, static_cast<unsigned long long>(d.foreground), d.mean_brightness_ratio);
  EXPECT_GT(d.foreground, 10000u);
  EXPECT_GT(d.foreground_psnr_db, 28);
  EXPECT_NEAR(d.mean_brightness_ratio, 1, 0.02);
}

TEST(Panorama, PartsOfItAreTheSameBits) {
  const DenseVolume volume = head({{40, 51, 37}, VoxelType::u8, obliqueAffine()}, usualRange(VoxelType::u8));
  const fs::path store = makeStore(volume, "panorama_small", 16);
  FrameRequest request = panoramaOf(volume.geometry.worldOf({19, 25, 17}), {1, 0.3, 0.2}, {0.1, 0.2, 1}, 40);
  request.transfer_function = solidFrom(185, 215, 0.9);
  request.background = {{0.1, 0.2, 0.3, 1}, {0.3, 0.2, 0.1, 1}};
  request.aovs.depth = request.aovs.normal = true;
  const Image whole = draw(store, request);
  for (const PixelRect& crop : {PixelRect{0, 0, 9, 5}, {31, 12, 60, 33}, {70, 0, 80, 40}, {40, 20, 41, 21}}) {
    request.crop = crop;
    EXPECT_TRUE(equalBits(draw(store, request, 3u << 20), partOf(whole, crop)));
  }
  request.crop.reset();
  request.aovs = {};
  request.visibility.method = VisibilityMethod::kNone;
  EXPECT_TRUE(equalBits(draw(store, request), colorsOf(whole)));
  request.mode = Mode::kMip;
  EXPECT_EQ(draw(store, request).pixel(3, 20)[3], 1);
}

}  // namespace
}  // namespace kiln::test
