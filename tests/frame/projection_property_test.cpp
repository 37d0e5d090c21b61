// `--mode mip|minip|average`. No acceleration changes a bit: skipped bricks, cells and pixels, brick size, tiles,
// threads and memory. Known from a ray caster in fine steps, or from a closed form where there is one.
#include <gtest/gtest.h>

#include <cmath>

#include "base/thread/parallel.h"
#include "store/store_reader.h"
#include "support/reference/drawing.h"
#include "support/reference/reference_renderer.h"
#include "support/volumes/procedural.h"
#include "support/volumes/random_scene.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

constexpr Mode kProjections[] = {Mode::kMip, Mode::kMinip, Mode::kAverage};
constexpr Mode kAllProjections[] = {Mode::kMip, Mode::kMinip, Mode::kAverage, Mode::kAttenuatedMip};
constexpr ImageSize kProjectedSize{80, 70};

// Projected values do not depend on the transfer function, but the renderer requires a valid function.
FrameRequest requestOf(const View& view, Mode mode) {
  FrameRequest request;
  request.view = view;
  request.mode = mode;
  request.transfer_function.points = {{0, glm::dvec3(0), 0}, {250, glm::dvec3(1), 1}};
  request.aovs.value = true;
  return request;
}

const ZeroPages<float>& valuesOf(const Image& image) { return image.planes.front().values; }

struct Expected {
  ProjectedImage image;
  std::vector<double> attenuated;
};
const std::vector<double>& expectedOf(const Expected& expected, Mode mode) {
  const ProjectedImage& image = expected.image;
  if (mode == Mode::kAttenuatedMip) return expected.attenuated;
  return mode == Mode::kMip ? image.greatest : mode == Mode::kMinip ? image.least : image.mean;
}

// Returns the volume with some isolated voxels set to NaN.
DenseVolume withHoles(DenseVolume volume) {
  const Extent3& n = volume.geometry.dims;
  for (std::int64_t k = 1; k < n.z; k += 3) {
    for (std::int64_t i = 0; i < n.x; i += 4) volume.set(i, (5 * i + 7 * k) % n.y, k, NAN);
  }
  return volume;
}

TEST(Projection, IsTheSameWhateverIsLeftOutAndHowTheVolumeIsCut) {
  const DenseVolume volumes[] = {head({{30, 41, 27}, VoxelType::u8, anisotropicAffine()}, usualRange(VoxelType::u8)),
                                 withHoles(cheese({{27, 30, 35}, VoxelType::f32, obliqueAffine()}, 2, {-50, 200}))};
  std::uint64_t seed = 500, left_out = 0;
  for (const DenseVolume& volume : volumes) {
    const auto middle = makeStore(volume, "middle", 16), large = makeStore(volume, "large", 128);
    for (int i = 0; i < 2; ++i, ++seed) {
      const RandomScene scene = randomScene(seed, volume, kProjectedSize);
      for (const Mode mode : kAllProjections) {
        FrameRequest request = requestOf(scene.view, mode);
        request.clipping = scene.clipping;
        if (seed % 3 == 0) request.level = 0;
        const std::optional<int> level = request.level;
        request.visibility.method = VisibilityMethod::kNone;
        const Image truth = draw(large, request);
        request.visibility.method = VisibilityMethod::kMask;
        EXPECT_TRUE(equalBits(truth, draw(large, request))) << "culled, seed " << seed;
        // Larger bricks leave the volume fewer levels.
        request.level = 0;
        const Image level_0 = draw(large, request);
        FrameStatistics all, culled;
        request.visibility.method = VisibilityMethod::kNone;
        EXPECT_TRUE(equalBits(level_0, draw(middle, request, 1 << 20, &all))) << "little memory, seed " << seed;
        request.visibility.method = VisibilityMethod::kMask;
        const ThreadLimit one(1);
        request.tile_px = seed % 2 == 0 ? 0 : 128;
        EXPECT_TRUE(equalBits(level_0, draw(middle, request, 1 << 20, &culled))) << "one thread, seed " << seed;
        EXPECT_LE(culled.bricks_read, all.bricks_read);
        if (mode != Mode::kAverage) left_out += all.bricks_read - culled.bricks_read;
        request.crop = PixelRect{13, 9, 77, 66};
        EXPECT_TRUE(equalBits(partOf(level_0, *request.crop), draw(middle, request))) << "crop, seed " << seed;
        request.crop.reset();
        request.level = level;
        // Mixed levels, drawn in bands of sub-pixels or not.
        request.samples = 4;
        request.tile_px = 64;
        const Image bands = draw(middle, request);
        request.band_px = 64;
        EXPECT_TRUE(equalBits(bands, draw(middle, request))) << "bands, seed " << seed;
      }
    }
  }
  EXPECT_GT(left_out, 0u);
}

// Values between voxels, from any side: a ray caster's with steps of an eightieth of a voxel, which misses a peak by at
// most a 160th of the way to the next voxel. Pixels that the volume covers in part have a ray beside their centre, and
// a test of their own.
TEST(Projection, IsWhatARayCasterSees) {
  const DenseVolume volume = cheese({{37, 30, 45}, VoxelType::i16, obliqueAffine()}, 3, {0, 1000});
  const auto store = makeStore(volume, "cast", 16);
  for (std::uint64_t seed = 700; seed < 704; ++seed) {
    RandomScene scene = randomScene(seed, volume, {60, 50});
    ReferenceSettings settings;
    settings.step_voxels = 0.0125;
    settings.clipping = scene.clipping;
    const Expected expected{projectedImage(volume, scene.view, settings),
                            attenuatedImage(volume, scene.view, kAttenuation, {0, 250}, settings)};
    for (const Mode mode : kAllProjections) {
      FrameRequest request = requestOf(scene.view, mode);
      request.clipping = scene.clipping;
      request.level = 0;
      const Image image = draw(store, request);
      double squares = 0, worst = 0;
      std::size_t both = 0, either = 0;
      for (std::size_t i = 0; i < valuesOf(image).size(); ++i) {
        const double found = valuesOf(image)[i], want = expectedOf(expected, mode)[i];
        const float alpha = image.rgba[4 * i + 3];
        EXPECT_EQ(std::isnan(found), alpha == 0);
        if (alpha > 0 && alpha < 1) continue;
        either += !std::isnan(found) || !std::isnan(want) ? 1 : 0;
        if (std::isnan(found) || std::isnan(want)) continue;
        ++both;
        squares += (found - want) * (found - want);
        worst = std::max(worst, std::abs(found - want));
        const double beyond = mode == Mode::kMip ? found - want : mode == Mode::kMinip ? want - found : 0;
        EXPECT_LE(beyond, 10) << "beyond what is there, seed " << seed;
      }
      // Rays that graze a corner of the box may have no sample.
      EXPECT_GE(static_cast<double>(both), 0.98 * static_cast<double>(either)) << "seed " << seed;
      if (both == 0) continue;
      EXPECT_LT(std::sqrt(squares / static_cast<double>(both)), 2) << "seed " << seed << " mode " << int(mode);
      EXPECT_LT(worst, 10) << "seed " << seed << " mode " << int(mode);
    }
  }
}

// A slab of 200 in empty space, seen along its normal. Along each ray the maximum is 200, the minimum 0 and the mean
// the slab's share, because trilinear interpolation keeps the sum. With a region, the figures hold for the part inside
// the region.
TEST(Projection, OfASlabIsKnown) {
  const DenseVolume volume = slab({{32, 32, 64}, VoxelType::f32}, 2, 20, 30, 200);
  const auto store = makeStore(volume, "slab", 16);
  Camera camera = cameraFrom(volume.geometry, {0, 0, -1}, Projection::kOrthographic);
  for (const Projection projection : {Projection::kOrthographic, Projection::kPerspective}) {
    camera.projection = projection;
    camera.height = 20;
    camera.fov_deg = 3;
    for (const bool cut : {false, true}) {
      FrameRequest request = requestOf(resolve(camera, {40, 40}), Mode::kMip);
      // The region starts in the middle of the slab.
      if (cut) request.clipping.region = VoxelBox{{0, 0, 25}, {32, 32, 64}};
      const double mean = cut ? 200 * 5 / 39.0 : 200 * 10 / 64.0;
      const double expected[] = {200, 0, mean};
      for (std::size_t m = 0; m < 3; ++m) {
        request.mode = kProjections[m];
        const Image image = draw(store, request);
        for (std::size_t i = 0; i < valuesOf(image).size(); ++i) {
          ASSERT_NEAR(valuesOf(image)[i], expected[m], m == 2 ? 0.005 * mean : 1e-3) << "mode " << m << " cut " << cut;
          // The colour is the value's.
          ASSERT_NEAR(image.rgba[4 * i], valuesOf(image)[i] / 250, 1e-6);
          ASSERT_EQ(image.rgba[4 * i + 3], 1);
        }
      }
    }
  }
}

// Few voxels close to the eye, where samples at a distance showed stripes: a sheet of voxels has its value on every ray
// through the sheet, and a saddle between voxels its value in closed form.
TEST(Projection, ExtremaBetweenSamplesAreExact) {
  const DenseVolume sheet = fill({{12, 12, 12}, VoxelType::u8}, [](auto, auto j, auto) { return j == 6 ? 50 : 200; });
  const auto of_sheet = makeStore(sheet, "sheet", 8);
  for (const Projection projection : {Projection::kOrthographic, Projection::kPerspective}) {
    FrameRequest request =
        requestOf(resolve(cameraFrom(sheet.geometry, {0.3, -1, 0.2}, projection), {64, 64}), Mode::kMinip);
    const Image image = draw(of_sheet, request);
    int through = 0;
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 64; ++x) {
        const Ray ray = rayThrough(request.view, {x + 0.5, y + 0.5});
        const glm::dvec3 at = ray.origin + (6 - ray.origin.y) / ray.direction.y * ray.direction;
        if (std::min(at.x, at.z) < -0.4 || std::max(at.x, at.z) > 11.4) continue;
        ++through;
        EXPECT_EQ(valuesOf(image)[static_cast<std::size_t>(64 * y + x)], 50) << x << ' ' << y;
      }
    }
    EXPECT_GT(through, 1000);
  }
  // The field 100 (x + y - 2 x y) in a cube, along rays x = x0 + t, y = y0 + t.
  const DenseVolume saddle =
      fill({{2, 2, 2}, VoxelType::f32}, [](auto i, auto j, auto) { return i == j ? 0.0 : 100.0; });
  Camera camera = cameraFrom(saddle.geometry, {1, 1, 0}, Projection::kOrthographic);
  camera.height = 0.9;
  const FrameRequest request = requestOf(resolve(camera, {30, 30}), Mode::kMip);
  const Image image = draw(makeStore(saddle, "saddle", 8), request);
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 30; ++x) {
      const Ray ray = rayThrough(request.view, {x + 0.5, y + 0.5});
      // The greatest value lies in the middle between the cube's sides.
      const double beside = ray.origin.x - ray.origin.y, expected = 50 * (1 + beside * beside);
      EXPECT_NEAR(valuesOf(image)[static_cast<std::size_t>(30 * y + x)], expected, 1e-3) << x << ' ' << y;
    }
  }
}

// The sheet close to the eye: before it, the value n rises from 0 to 1 over a voxel, which attenuates n = 1 by the
// integral of n, a half.
TEST(Projection, AttenuatedMaximumOfASheetIsKnown) {
  const DenseVolume sheet = fill({{12, 12, 12}, VoxelType::u8}, [](auto, auto j, auto) { return j == 6 ? 250 : 0; });
  FrameRequest request = requestOf(
      resolve(cameraFrom(sheet.geometry, {0.3, -1, 0.2}, Projection::kOrthographic), {240, 240}), Mode::kAttenuatedMip);
  const Image image = draw(makeStore(sheet, "attenuating_sheet", 8), request);
  double worst = 0;
  int through = 0;
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 240; ++x) {
      const Ray ray = rayThrough(request.view, {x + 0.5, y + 0.5});
      const glm::dvec3 at = ray.origin + (6 - ray.origin.y) / ray.direction.y * ray.direction;
      if (std::min(at.x, at.z) < 1 || std::max(at.x, at.z) > 10) continue;
      const double expected = 250 * std::exp(-kAttenuation * 0.5 / std::abs(ray.direction.y));
      worst = std::max(worst, std::abs(valuesOf(image)[static_cast<std::size_t>(240 * y + x)] - expected) / expected);
      ++through;
    }
  }
  EXPECT_GT(through, 5000);
  EXPECT_LT(worst, 0.003);
}

// Large voxels seen in perspective, so that rays end anywhere between samples of several zones.
TEST(Projection, WithoutAttenuationTheMaximumIsThatOfMip) {
  const DenseVolume volume = fill({{6, 5, 7}, VoxelType::u8}, [](auto i, auto j, auto k) {
    return 250 * hashUnit(9, static_cast<std::uint64_t>((k * 5 + j) * 6 + i));
  });
  const auto store = makeStore(volume, "large_voxels", 8);
  FrameRequest request = requestOf(
      resolve(cameraFrom(volume.geometry, {0.4, -1, 0.25}, Projection::kPerspective), {400, 400}), Mode::kMip);
  const Image greatest = draw(store, request);
  request.mode = Mode::kAttenuatedMip;
  request.attenuation = 0;
  const Image attenuated = draw(store, request);
  int seen = 0;
  for (std::size_t i = 0; i < valuesOf(greatest).size(); ++i) {
    const float expected = valuesOf(greatest)[i], found = valuesOf(attenuated)[i];
    ASSERT_EQ(std::isnan(expected), std::isnan(found)) << i;
    if (std::isnan(expected)) continue;
    ++seen;
    EXPECT_LE(found, expected + 1e-3) << i;
    EXPECT_GE(found, expected - 5) << i;
  }
  EXPECT_GT(seen, 50000);
}

// Far from the middle of a wide view a slab is many voxels long on its ray: no value beyond a brick's own samples
// counts.
TEST(Projection, OfAWideViewIsTheSameForAllBricks) {
  const DenseVolume volume = fill({{96, 12, 96}, VoxelType::u8}, [](auto i, auto j, auto k) {
    return hashUnit(7, static_cast<std::uint64_t>((k * 12 + j) * 96 + i)) < 0.02 ? 250 : 0;
  });
  const auto small = makeStore(volume, "wide_of_8", 8), large = makeStore(volume, "wide_of_128", 128);
  Camera camera;
  camera.eye = {1, -0.7, 1}, camera.target = {1, 16, 1}, camera.up = {0, 0, 1};
  camera.fov_deg = 174;
  FrameRequest request = requestOf(resolve(camera, {200, 200}), Mode::kAttenuatedMip);
  request.level = 0;
  for (const double attenuation : {0.0, 0.02}) {
    request.attenuation = attenuation;
    request.visibility.method = VisibilityMethod::kNone;
    const Image truth = draw(large, request);
    EXPECT_TRUE(equalBits(truth, draw(small, request))) << attenuation;
    request.visibility.method = VisibilityMethod::kMask;
    EXPECT_TRUE(equalBits(truth, draw(small, request))) << attenuation << " culled";
    EXPECT_TRUE(equalBits(truth, draw(large, request))) << attenuation << " large, culled";
  }
}

// Diagonal rays cross planes of voxels where they cross the faces of bricks: each such point belongs to one brick.
TEST(Projection, RaysThroughEdgesOfBricksAreTheSameForAllBricks) {
  const DenseVolume volume = fill({{48, 48, 8}, VoxelType::f32}, [](auto i, auto j, auto k) {
    return hashUnit(5, static_cast<std::uint64_t>((k * 48 + j) * 48 + i));
  });
  const auto small = makeStore(volume, "edges_of_8", 8), large = makeStore(volume, "edges_of_64", 64);
  for (const glm::dvec3 from : {glm::dvec3(1, 1, 0), glm::dvec3(-1, 1, 0), glm::dvec3(1, 0, 0)}) {
    for (const double turned : {0.0, 2.3e-16, 4.5e-16, 1e-15, 3e-15}) {
      Camera camera = cameraFrom(volume.geometry, from + glm::dvec3(0, turned, 0), Projection::kOrthographic);
      for (const Mode mode : {Mode::kMip, Mode::kMinip}) {
        // A voxel a pixel, along an axis and along the diagonal.
        for (const double height : {32.0, 32 * std::sqrt(0.5)}) {
          camera.height = height;
          const FrameRequest request = requestOf(resolve(camera, {96, 32}), mode);
          EXPECT_TRUE(equalBits(draw(small, request), draw(large, request)))
              << from.x << ' ' << from.y << ' ' << turned;
        }
      }
    }
  }
}

// A clip thinner than the sample distance has a value in each pixel where a thick clip has a value, for every brick
// size. Tested between oblique planes and between planes across the rays, where no sample is inside.
TEST(Projection, OfAThinClipHasNoHoles) {
  const auto value = [](std::int64_t i, std::int64_t j, std::int64_t k) {
    return 100 + 2 * hashUnit(3, static_cast<std::uint64_t>((k * 32 + j) * 32 + i));
  };
  const DenseVolume volume = fill({{32, 32, 32}, VoxelType::f32}, value);
  const auto small = makeStore(volume, "small", 8), large = makeStore(volume, "large", 32);
  for (const glm::dvec3 towards : {glm::dvec3(0, 1, 0), glm::dvec3(0.3, 1, 0)}) {
    // The planes are 10.3 voxels from the volume's front.
    Camera camera = cameraFrom(volume.geometry, towards, Projection::kOrthographic);
    camera.height = 20;
    for (const double thickness : {0.05, 0.3}) {
      for (const Mode mode : kProjections) {
        FrameRequest request = requestOf(resolve(camera, {60, 60}), mode);
        request.level = 0;
        request.clipping.planes = {{{0, 1, 0}, -10.3}, {{0, -1, 0}, 10.3 + thickness}};
        const Image image = draw(large, request);
        for (const float found : valuesOf(image)) {
          ASSERT_GE(found, 100) << "thickness " << thickness << " mode " << int(mode);
          ASSERT_LE(found, 102);
        }
        EXPECT_TRUE(equalBits(image, draw(small, request))) << "thickness " << thickness << " mode " << int(mode);
      }
    }
  }
}

// A border pixel is as opaque as the share of its square that the cut box covers: the share of 16 × 16 rays that hit
// the volume of a ray caster. Its value lies among the values of these rays, up to a step of the ramp.
TEST(Projection, BorderPixelsAreAsOpaqueAsTheVolumeCoversThem) {
  constexpr int kRays = 16;
  constexpr double kStep = 4;
  const DenseVolume volume = fill({{14, 11, 9}, VoxelType::f32, obliqueAffine()}, [](auto i, auto j, auto k) {
    return 50 + kStep * static_cast<double>(i) - static_cast<double>(j + k);
  });
  const auto store = makeStore(volume, "border", 16);
  std::size_t border = 0;
  for (std::uint64_t seed = 900; seed < 906; ++seed) {
    const RandomScene scene = randomScene(seed, volume, {28, 24});
    ReferenceSettings settings;
    settings.step_voxels = 0.5;
    settings.clipping = scene.clipping;
    const Expected hits{projectedImage(volume, enlarged(scene.view, kRays), settings), {}};
    for (const Mode mode : kProjections) {
      FrameRequest request = requestOf(scene.view, mode);
      request.clipping = scene.clipping;
      const Image image = draw(store, request);
      double sum = 0;
      for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
          int hit = 0;
          ValueRange among;
          for (int i = 0; i < kRays * kRays; ++i) {
            const int place = (kRays * y + i / kRays) * kRays * image.width + kRays * x + i % kRays;
            const double value = expectedOf(hits, mode)[static_cast<std::size_t>(place)];
            if (std::isnan(value)) continue;
            ++hit;
            among.include(value);
          }
          const double share = hit / double(kRays * kRays), alpha = image.pixel(x, y)[3];
          if (share > 0 && share < 1) ++border;
          ASSERT_NEAR(alpha, share, 0.08) << "seed " << seed << " mode " << int(mode) << " pixel " << x << "," << y;
          // A pixel that is covered entirely is opaque, without rounding.
          if (alpha > 1 - 1e-6) {
            ASSERT_EQ(alpha, 1);
          }
          sum += alpha - share;
          const double value = valuesOf(image)[static_cast<std::size_t>(y * image.width + x)];
          ASSERT_EQ(std::isnan(value), alpha == 0);
          if (hit == 0 || alpha == 0) continue;
          ASSERT_GE(value, among.lo - kStep);
          ASSERT_LE(value, among.hi + kStep);
          ASSERT_NEAR(image.pixel(x, y)[0], alpha * value / 250, 1e-6);
        }
      }
      EXPECT_NEAR(sum / double(image.width * image.height), 0, 0.002) << "seed " << seed << " mode " << int(mode);
    }
  }
  EXPECT_GT(border, 100u);
}

// A box of whole pixels, moved by a quarter of a pixel to the right and down: its border has alpha 3/4 and 1/4, its
// corners the products.
TEST(Projection, BorderOfABoxBetweenPixelsIsKnown) {
  const DenseVolume volume = fill({{8, 8, 8}, VoxelType::f32}, [](auto, auto, auto) { return 100.0; });
  const auto store = makeStore(volume, "between", 16);
  Camera camera = cameraFrom(volume.geometry, {0, 0, -1}, Projection::kOrthographic);
  camera.height = 12;  // a voxel is a pixel
  View view = resolve(camera, {12, 12});
  view.centre_px += 0.25;
  const Image image = draw(store, requestOf(view, Mode::kMip));
  const auto share = [](int i) { return i == 2 ? 0.75 : i == 10 ? 0.25 : i > 2 && i < 10 ? 1.0 : 0.0; };
  for (int y = 0; y < 12; ++y) {
    for (int x = 0; x < 12; ++x) EXPECT_NEAR(image.pixel(x, y)[3], share(x) * share(y), 1e-6) << x << "," << y;
  }
}

// Every ray meets the greatest value in the second of four layers of bricks. This layer is drawn first, and no other
// layer is read.
TEST(Projection, BricksThatHaveNothingMoreAreNotRead) {
  const auto value = [](std::int64_t i, std::int64_t j, std::int64_t k) {
    if (k >= 16 && k < 32) return 250.0;
    return 50 * hashUnit(1, static_cast<std::uint64_t>((k * 64 + j) * 64 + i));
  };
  const DenseVolume volume = fill({{64, 64, 64}, VoxelType::u8}, value);
  const auto store = makeStore(volume, "layers", 16);
  FrameRequest request =
      requestOf(resolve(cameraFrom(volume.geometry, {0, 0, 1}, Projection::kOrthographic), {100, 100}), Mode::kMip);
  request.level = 0;
  const StoreReader reader(store);
  BrickCache cache(reader, 1 << 24);
  Progress silent;
  FrameStatistics statistics;
  const Image image = renderFrame(cache, request, silent, statistics);
  EXPECT_EQ(statistics.bricks_total, 64u);
  EXPECT_EQ(statistics.bricks_read, 16u);
  EXPECT_EQ(statistics.bricks_contributing, 16u);
  EXPECT_EQ(statistics.bricks_hidden, 48u);
  for (const float found : valuesOf(image)) EXPECT_TRUE(found == 250 || std::isnan(found));
}

}  // namespace
}  // namespace kiln::test
