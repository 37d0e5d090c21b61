// Levels of detail against two truths. In a uniform medium, the closed form, which no level may change. Elsewhere, the
// picture of level 0, from which a coarser voxel differs through averaging. The difference depends on the scene; it is
// printed, and bounded slightly above the measured figure. Pictures stay in the test's output.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>

#include "image/compare.h"
#include "image/file/image_file.h"
#include "sequence/render_job_run.h"
#include "store/store_reader.h"
#include "support/reference/drawing.h"
#include "support/reference/lattices.h"
#include "support/reference/reference_renderer.h"
#include "support/volumes/procedural.h"
#include "support/volumes/random_scene.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

namespace fs = std::filesystem;

int levelsDrawn(const FrameStatistics& statistics) {
  int out = 0;
  for (const LevelStatistics& level : statistics.levels) out += level.bricks > 0 ? 1 : 0;
  return out;
}

// A store and its cache, for drawing many frames.
class Frames {
 public:
  explicit Frames(const fs::path& store) : reader_(store), cache_(reader_, 1ull << 30) {}
  Image draw(FrameRequest request, std::optional<int> level) {
    request.level = level;
    Progress silent;
    return renderFrame(cache_, request, silent, statistics);
  }
  FrameStatistics statistics;

 private:
  StoreReader reader_;
  BrickCache cache_;
};

TransferFunction extinctionUpTo(double value, double tau) {
  TransferFunction out;
  out.unit = 1;
  out.points = {{0, {1, 1, 1}, 0}, {value, {1, 1, 1}, -std::expm1(-tau)}};
  return out;
}

TransferFunction skin(const ValueRange& range) {
  const double span = range.hi - range.lo;
  TransferFunction out;
  out.points = {{range.lo + 0.15 * span, {0.93, 0.74, 0.6}, 0.0}, {range.lo + 0.3 * span, {0.93, 0.74, 0.6}, 0.95}};
  return out;
}

void keep(const Image& a, const Image& b, const std::string& name) {
  Image out(3 * a.width, a.height);
  const Image difference = differenceImage(a, b);
  const Image* const images[] = {&a, &b, &difference};
  for (int i = 0; i < 3; ++i) {
    for (int y = 0; y < a.height; ++y) std::copy_n(images[i]->pixel(0, y), 4 * a.width, out.pixel(i * a.width, y));
  }
  const fs::path file = fs::path(KILN_TEST_OUTPUT_DIR) / ("levels_" + name + ".png");
  writeImage(out, {}, {}, file);
  std::printf("  %s\n", file.c_str());
}

// Returns the length of a ray inside the volume's box. requires: spacing 1, so that index space is world space.
double chord(const Ray& ray, const Extent3& dims) {
  double begin = 0, end = 1e30;
  for (int axis = 0; axis < 3; ++axis) {
    const double a = (-0.5 - ray.origin[axis]) / ray.direction[axis];
    const double b = (static_cast<double>(dims[axis]) - 0.5 - ray.origin[axis]) / ray.direction[axis];
    begin = std::max(begin, std::min(a, b));
    end = std::min(end, std::max(a, b));
  }
  return std::max(0.0, end - begin);
}

// Errors of a picture of fog in a box. `mean` and `rms` compare optical depths with chord times extinction, relative to
// the mean. `largest_difference` compares with another picture. Left out: pixels within 3 of the silhouette, and pixels
// whose rays cross little more than the ends of footprints.
struct FogError {
  double mean = 0, rms = 0, largest_difference = 0;
  int pixels = 0;
};
FogError fogError(const Image& image, const Image& other, const View& view, const Extent3& dims, double tau) {
  constexpr int kMargin = 3;
  constexpr double kLeast = 10;
  const auto inside = [&](int x, int y) { return chord(rayThrough(view, {x + 0.5, y + 0.5}), dims) > kLeast; };
  FogError out;
  double sum = 0, expected = 0, squares = 0;
  for (int y = kMargin; y < image.height - kMargin; ++y) {
    for (int x = kMargin; x < image.width - kMargin; ++x) {
      bool all = true;
      for (int corner = 0; corner < 4; ++corner)
        all = all && inside(x + ((corner & 1) != 0 ? kMargin : -kMargin), y + ((corner & 2) != 0 ? kMargin : -kMargin));
      if (!all) continue;
      const double want = tau * chord(rayThrough(view, {x + 0.5, y + 0.5}), dims);
      const double found = -std::log1p(-static_cast<double>(image.pixel(x, y)[3]));
      sum += found;
      expected += want;
      squares += (found - want) * (found - want);
      const double difference = std::abs(image.pixel(x, y)[3] - other.pixel(x, y)[3]);
      out.largest_difference = std::max(out.largest_difference, difference);
      ++out.pixels;
    }
  }
  out.mean = sum / expected - 1;
  out.rms = std::sqrt(squares / out.pixels) / (expected / out.pixels);
  return out;
}

// A long box of fog whose extents are no multiples of a coarse voxel, seen along its length and from the side. The eye
// also lies in planes between bricks, so coarse bricks are behind and beside fine bricks. Only footprints at the rims
// of the box may cause errors against the closed form. Where levels meet, a pixel differs from level 0 by at most
// 3/255.
TEST(LevelOfDetail, UniformMediumHasNoSeams) {
  const Extent3 dims{93, 61, 297};
  constexpr double kTau = 0.004;
  Frames frames(makeStore(fill({dims, VoxelType::u8}, [](auto...) { return 100.0; }), "fog", 16));
  FrameRequest request;
  request.lattice = Lattice::kVoxel;
  request.shading.phong = false;
  request.opacity_threshold = 1;
  request.transfer_function = extinctionUpTo(100, kTau);
  int most_levels = 0;
  const glm::dvec3 eyes[] = {{47.5, 31.5, -90}, {47.5, 90, -40}, {-120, 31.5, 20}, {160, 100, -40}, {15.5, 15.5, -60}};
  for (std::size_t i = 0; i < std::size(eyes); ++i) {
    Camera camera;
    camera.fov_deg = 90;
    camera.eye = eyes[i];
    camera.target = {60, 20, 170};
    camera.up = {0, 1, 0};
    request.view = resolve(camera, {160, 160});
    const Image image = frames.draw(request, std::nullopt);
    const int levels = levelsDrawn(frames.statistics);
    most_levels = std::max(most_levels, levels);
    EXPECT_GE(levels, 2) << "eye " << i;
    const Image fine = frames.draw(request, 0);
    const FogError error = fogError(image, fine, request.view, dims, kTau);
    const FogError fine_error = fogError(fine, image, request.view, dims, kTau);
    std::printf(
        "fog, eye %zu, %d levels: mean %+.3f %%, rms %.2f %%; level 0 %+.3f %%, %.2f %%; largest difference %.4f\n", i,
        levels, 100 * error.mean, 100 * error.rms, 100 * fine_error.mean, 100 * fine_error.rms,
        error.largest_difference);
    EXPECT_GT(error.pixels, 500) << "eye " << i;
    EXPECT_LT(std::abs(error.mean), 0.003) << "eye " << i;
    EXPECT_LT(error.rms, 0.015) << "eye " << i;
    EXPECT_LT(error.largest_difference, 3.0 / 255) << "eye " << i;
    keep(fine, image, "fog_" + std::to_string(i));
  }
  EXPECT_GE(most_levels, 3);
}

// Known because a ray along a ramp crosses every value for an equal length. A thin layer's optical depth is the
// integral of extinction over values, divided by the ramp's slope. Coarse voxels are up to nine layer widths apart, so
// most contain values from both sides of the layer.
TEST(LevelOfDetail, AThinLayerKeepsItsOpacity) {
  constexpr double kSlope = 6, kMiddle = 400, kHalfWidth = 8;
  const VolumeShape shape{{128, 128, 128}, VoxelType::i16};
  const DenseVolume volume = ramp(shape, 0, kSlope);
  Frames frames(makeStore(volume, "layer", 32));
  FrameRequest request;
  request.shading.phong = false;
  request.opacity_threshold = 1;
  request.transfer_function.unit = 1;
  request.transfer_function.points = {
      {kMiddle - kHalfWidth, {1, 1, 1}, 0}, {kMiddle, {1, 1, 1}, 0.1}, {kMiddle + kHalfWidth, {1, 1, 1}, 0}};
  // View from the side, so that slabs cut the layer everywhere. Integral of tau = -ln(1 - a) for a from 0 to 0.1 and
  // back.
  const glm::dvec3 from(-1, 0.4, 0.23);
  const double expected = 2 * kHalfWidth / kSlope * (1 + 0.9 / 0.1 * std::log(0.9)) * glm::length(from);
  const Camera camera = cameraFrom(volume.geometry, from, Projection::kOrthographic);
  for (const int pixels : {80, 40, 20}) {
    request.view = resolve(camera, {pixels, pixels});
    const Image image = frames.draw(request, std::nullopt);
    double sum = 0;
    int count = 0;
    for (int y = 3 * pixels / 8; y < 5 * pixels / 8; ++y) {
      for (int x = 3 * pixels / 8; x < 5 * pixels / 8; ++x, ++count)
        sum -= std::log1p(-static_cast<double>(image.pixel(x, y)[3]));
    }
    std::size_t level = 0;
    while (frames.statistics.levels[level].bricks == 0) ++level;
    std::printf("layer, %d pixels, level %zu: optical depth %.4f of %.4f\n", pixels, level, sum / count, expected);
    EXPECT_GT(level, 0u) << pixels << " pixels";
    EXPECT_NEAR(sum / count / expected, 1, 0.05) << pixels << " pixels";
  }
}

// Known because values rise over a voxel, stay constant for a voxel and fall over the next. Optical depth across the
// sheet is therefore an integral over values. Coarse voxels have at most half of the sheet's value, where almost
// nothing is visible.
TEST(LevelOfDetail, AThumbnailKeepsTheOpticalDepthOfAThinSheet) {
  constexpr double kValue = 100, kShownFrom = 40, kOpacity = 0.3;
  const DenseVolume volume =
      fill({{128, 128, 128}, VoxelType::u8}, [](auto, auto, auto z) { return z == 63 || z == 64 ? kValue : 0; });
  RenderJob job;
  job.volume = makeStore(volume, "sheet", 32);
  job.picture.size = {16, 16};
  job.picture.shading.phong = false;
  TransferFunction function;
  function.unit = 1;
  function.points = {{kShownFrom, {1, 1, 1}, 0}, {kValue, {1, 1, 1}, kOpacity}};
  job.picture.transfer_function = function;
  const glm::dvec3 from(0.3, 0.2, -1);
  const double slope = 1 + (1 - kOpacity) / kOpacity * std::log1p(-kOpacity);  // the mean of tau = -ln(1 - a)
  const double across = -std::log1p(-kOpacity) + 2 * (1 - kShownFrom / kValue) * slope;
  const double expected = across * glm::length(from) / std::abs(from.z);
  for (const Projection projection : {Projection::kOrthographic, Projection::kPerspective}) {
    for (const double px_per_voxel : {0.125, 0.1, 0.07}) {
      Camera camera = cameraFrom(volume.geometry, from, projection);
      camera.height = job.picture.size.height / px_per_voxel;
      // The distance makes rays almost parallel.
      camera.fov_deg = 2;
      const double distance = camera.height / 2 / std::tan(glm::radians(camera.fov_deg / 2));
      camera.eye = camera.target + distance * glm::normalize(from);
      job.picture.camera = specOf(camera);
      Progress silent;
      const Image image = runRenderJob(job, 1, silent).image;
      double sum = 0;
      for (const int y : {7, 8}) {
        for (const int x : {7, 8}) sum -= std::log1p(-static_cast<double>(image.pixel(x, y)[3])) / 4;
      }
      std::printf("sheet, %g pixels a voxel: optical depth %.4f of %.4f\n", px_per_voxel, sum, expected);
      EXPECT_NEAR(sum / expected, 1, 0.04) << px_per_voxel << " pixels a voxel";
    }
  }
}

// Known because the scene is a ball of soft tissue in air with a bone: away from the bone, no voxel of any level has a
// visible value. A coarse voxel at the ball's surface has values between air and tissue, none above the tissue's.
TEST(LevelOfDetail, ASurfaceHoldsNoValueBeyondItsSides) {
  constexpr int kPixels = 48;
  constexpr double kBone_px = 12;
  const VolumeShape shape{{96, 96, 96}, VoxelType::i16};
  const DenseVolume volume = fill(shape, [](auto x, auto y, auto z) {
    const double r = glm::length(glm::dvec3(x, y, z) - 47.5);
    return r < 6 ? 1000.0 : r < 40 ? 40.0 : -1000.0;
  });
  Frames frames(makeStore(volume, "surface", 32));
  FrameRequest request;
  request.transfer_function.points = {{60, {1, 1, 1}, 0}, {200, {1, 1, 1}, 0.9}};
  for (const Projection projection : {Projection::kOrthographic, Projection::kPerspective}) {
    request.view = resolve(cameraFrom(volume.geometry, {-1, 0.4, 0.23}, projection), {kPixels, kPixels});
    for (const Interpolation interpolation : {Interpolation::kLinear, Interpolation::kCatmullRom}) {
      request.interpolation = interpolation;
      for (int level = 0; level < 2; ++level) {
        const Image image = frames.draw(request, level);
        float centre = 0, elsewhere = 0;
        for (int y = 0; y < kPixels; ++y) {
          for (int x = 0; x < kPixels; ++x) {
            float& most = std::hypot(x + 0.5 - kPixels / 2, y + 0.5 - kPixels / 2) < kBone_px ? centre : elsewhere;
            most = std::max(most, image.pixel(x, y)[3]);
          }
        }
        EXPECT_GT(centre, 0.9f) << "level " << level;
        EXPECT_EQ(elsewhere, 0.0f) << "level " << level;
      }
    }
  }
}

// Curved walls from near to far: a frame of three or more levels against the picture of level 0.
TEST(LevelOfDetail, PerspectiveMixesLevels) {
  const VolumeShape shape{{64, 64, 320}, VoxelType::i16};
  const DenseVolume volume = cheese(shape, 4, usualRange(VoxelType::i16));
  Frames frames(makeStore(volume, "cheese", 16));
  FrameRequest request;
  request.lattice = Lattice::kVoxel;
  request.transfer_function = skin(volume.range());
  Camera camera;
  camera.fov_deg = 100;
  camera.eye = {80, 70, -70};
  camera.target = {32, 32, 110};
  camera.up = {0, 1, 0};
  request.view = resolve(camera, {160, 160});
  const Image image = frames.draw(request, std::nullopt);
  EXPECT_GE(levelsDrawn(frames.statistics), 3);
  for (std::size_t level = 0; level < frames.statistics.levels.size(); ++level)
    std::printf("cheese, level %zu: %ju bricks, %ju splats\n", level,
                static_cast<std::uintmax_t>(frames.statistics.levels[level].bricks),
                static_cast<std::uintmax_t>(frames.statistics.levels[level].voxels_splats));
  const Image fine = frames.draw(request, 0);
  const ImageDifference d = compareImages(fine, image);
  std::printf("cheese: PSNR %.2f dB, foreground %.2f dB, brightness %.4f of level 0's\n", d.psnr_db,
              d.foreground_psnr_db, d.mean_brightness_ratio);
  keep(fine, image, "cheese");
  EXPECT_GT(d.foreground_psnr_db, 30);
  EXPECT_NEAR(d.mean_brightness_ratio, 1, 0.02);
}

// Returns the mean change of an object's pixel between two frames, over pixels and channels.
double meanChange(const Image& a, const Image& b) {
  double sum = 0;
  int pixels = 0;
  for (std::size_t i = 0; i < a.rgba.size(); i += 4) {
    if (a.rgba[i + 3] == 0 && b.rgba[i + 3] == 0) continue;
    for (std::size_t channel = 0; channel < 4; ++channel) sum += std::abs(a.rgba[i + channel] - b.rgba[i + channel]);
    ++pixels;
  }
  return sum / (4.0 * pixels);
}

class Zoom : public ::testing::TestWithParam<std::tuple<Lattice, Projection>> {};

// Zooms in by a factor of four in 60 frames, through all levels. In perspective, levels change brick by brick;
// otherwise all bricks change at once.
TEST_P(Zoom, DoesNotPop) {
  const DenseVolume volume = head({{96, 96, 72}, VoxelType::i16}, usualRange(VoxelType::i16));
  Frames frames(makeStore(volume, "head", 16));
  const auto [lattice, projection] = GetParam();
  const Camera base = cameraFrom(volume.geometry, {-0.6, -1, 0.3}, projection);
  FrameRequest request;
  request.lattice = lattice;
  request.transfer_function = skin(volume.range());
  constexpr int kFrames = 60;
  Image last, last_fine;
  double most = 0, most_fine = 0, sum = 0, sum_fine = 0, most_above = 0;
  for (int i = 0; i < kFrames; ++i) {
    const double away = 4 * std::pow(0.25, i / (kFrames - 1.0));
    Camera camera = base;
    camera.height *= away;
    camera.eye = camera.target + away * (base.eye - base.target);
    request.view = resolve(camera, {100, 100});
    const Image image = frames.draw(request, std::nullopt);
    const Image fine = frames.draw(request, 0);
    if (i > 0) {
      const double change = meanChange(image, last), change_fine = meanChange(fine, last_fine);
      most = std::max(most, change);
      most_fine = std::max(most_fine, change_fine);
      sum += change;
      sum_fine += change_fine;
      most_above = std::max(most_above, change - change_fine);
    }
    last = image;
    last_fine = fine;
  }
  std::printf(
      "%s lattice, %s zoom, mean change from frame to frame: auto %.5f on average, %.5f at most; level 0 %.5f and "
      "%.5f; at most "
      "%.5f above level 0's\n",
      nameOf(lattice), projection == Projection::kPerspective ? "perspective" : "orthographic", sum / (kFrames - 1),
      most, sum_fine / (kFrames - 1), most_fine, most_above);
  // Zooming changes a pixel by a thirtieth from frame to frame; a change of level adds at most 4/255.
  EXPECT_LT(sum, 1.05 * sum_fine);
  EXPECT_LT(most, 1.15 * most_fine);
  EXPECT_LT(most_above, 4.0 / 255);
}

INSTANTIATE_TEST_SUITE_P(Lattices, Zoom,
                         ::testing::Combine(::testing::ValuesIn(kLattices),
                                            ::testing::Values(Projection::kOrthographic, Projection::kPerspective)));

}  // namespace
}  // namespace kiln::test
