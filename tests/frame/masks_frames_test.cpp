// Masks. A voxel is shown if the label nearest to its position is listed, whatever the bricks, budgets, tiles and
// threads. Pictures are compared with pictures of volumes that were masked before their conversion.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "base/thread/parallel.h"
#include "engine/shown_box.h"
#include "store/store_reader.h"
#include "support/reference/companions.h"
#include "support/reference/drawing.h"
#include "support/system/expect_error.h"
#include "support/system/sanitized.h"
#include "support/volumes/random_scene.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

using Path = std::filesystem::path;
constexpr ImageSize kMaskSize{90, 77};

Image drawMasked(const Path& store, const Path& mask, const std::vector<std::int64_t>& labels,
                 const FrameRequest& request, std::uint64_t budget_bytes = 1ull << 30,
                 FrameStatistics* statistics = nullptr) {
  return draw(*masked(store, mask, labels), request, budget_bytes, statistics);
}

// Bodies of the labels 0 to 5.
DenseVolume bodies(const VolumeShape& shape) { return cheese(shape, 9, {0, 5}); }

bool isListed(double label, const std::vector<std::int64_t>& labels) {
  return std::find(labels.begin(), labels.end(), static_cast<std::int64_t>(label)) != labels.end();
}

FrameRequest requestAt(std::uint64_t seed, const DenseVolume& volume) {
  const RandomScene scene = randomScene(seed, volume, kMaskSize);
  FrameRequest out = requestOf(scene, Lattice::kPixel, randomThreshold(seed));
  out.level = 0;  // smaller bricks have more levels
  out.visibility.method = VisibilityMethod::kNone;
  if (seed % 3 == 0) out.aovs = {true, true};
  return out;
}

// A mask of another resolution, turned against the volume.
DenseVolume turnedMask() {
  const glm::dmat4 turned = turnedAffine(0.4, {1.3, 2.2, 1.7}, {10, -10, 15});
  return bodies({{50, 31, 42}, VoxelType::u8, turned});
}

// Known because none of the varied options is part of the picture's definition.
TEST(Masks, AreDrawnAlikeByBricksThreadsTilesMemoryAndCrops) {
  const DenseVolume volume = cheese({{75, 61, 70}, VoxelType::i16}, 1, usualRange(VoxelType::i16));
  const DenseVolume mask = turnedMask();
  const Path large = makeStore(volume, "large", 128), small = makeStore(volume, "small", 16);
  const Path large_mask = makeStore(mask, "large_mask", 64, true), small_mask = makeStore(mask, "small_mask", 16, true);
  const std::vector<std::int64_t> labels = {1, 2, 4};
  int shown = 0, differ = 0;
  for (std::uint64_t seed = 700; seed < casesOf(706u, 701u); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    FrameRequest request = requestAt(seed, volume);
    if (seed % 2 == 1) request.samples = 2;
    const Image truth = drawMasked(large, large_mask, labels, request);
    shown += showsSomething(truth) ? 1 : 0;
    differ += equalBits(truth, draw(large, request)) ? 0 : 1;
    EXPECT_TRUE(equalBits(truth, drawMasked(small, large_mask, labels, request))) << "bricks of 16";
    EXPECT_TRUE(equalBits(truth, drawMasked(small, small_mask, labels, request))) << "bricks of 16 of both";
    request.visibility.method = VisibilityMethod::kMask;
    EXPECT_TRUE(equalBits(truth, drawMasked(small, small_mask, labels, request))) << "tested for visibility";
    const ThreadLimit one(1);
    const std::uint64_t least = masked(small, small_mask, labels)->largestReadBytes();
    EXPECT_TRUE(equalBits(truth, drawMasked(small, small_mask, labels, request, least))) << "least memory";
    request.tile_px = 128;
    EXPECT_TRUE(equalBits(truth, drawMasked(small, large_mask, labels, request))) << "tiles of 128";
    request.crop = PixelRect{21, 13, 70, 57};
    EXPECT_TRUE(equalBits(partOf(truth, *request.crop), drawMasked(small, small_mask, labels, request))) << "cropped";
  }
  EXPECT_GT(shown, casesOf(2, 0));
  EXPECT_GE(differ, shown);
}

// A hidden voxel of a label volume has no label that is shown: the picture is equal to the bit.
TEST(Masks, OfLabelsEqualLabelsThatWereMaskedBefore) {
  const DenseVolume volume = cheese({{44, 39, 37}, VoxelType::u8, anisotropicAffine()}, 3, {0, 5});
  const DenseVolume mask = bodies({{44, 39, 37}, VoxelType::u16, anisotropicAffine()});
  const std::vector<std::int64_t> labels = {2, 3};
  const DenseVolume before = fill({{44, 39, 37}, VoxelType::u8, anisotropicAffine()}, [&](auto x, auto y, auto z) {
    return isListed(mask.valueAt(x, y, z), labels) ? volume.valueAt(x, y, z) : 0.0;
  });
  const Path store = makeStore(volume, "volume", 16, true), of_mask = makeStore(mask, "mask", 32, true);
  const Path truth = makeStore(before, "before", 16, true);
  for (std::uint64_t seed = 80; seed < casesOf(86u, 81u); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    FrameRequest request = requestAt(seed, volume);
    Random random(seed);
    request.transfer_function = {};
    for (int label = 1; label <= 5; ++label)
      request.transfer_function.labels.push_back(
          {static_cast<double>(label), "", glm::dvec3(random.uniform(0, 1), 0.5, random.uniform(0, 1)), 0.4});
    const Image image = draw(truth, request);
    EXPECT_TRUE(equalBits(image, drawMasked(store, of_mask, labels, request)));
  }
}

// Amounts that were masked before: hidden voxels are NaN, and a sample beside a NaN is absent. So a volume that was
// masked before shows at most what its mask shows; with a mask that is one voxel larger in all directions, at least
// that.
TEST(Masks, OfAmountsLieBetweenVolumesThatWereMaskedBefore) {
  const VolumeShape shape{{46, 41, 39}, VoxelType::f32, anisotropicAffine()};
  const DenseVolume volume = cheese(shape, 4, {0, 1});
  const DenseVolume mask = bodies({shape.dims, VoxelType::u8, anisotropicAffine()});
  const std::vector<std::int64_t> labels = {1, 2, 5};
  const auto masked_before = [&](int larger) {
    return fill(shape, [&](auto x, auto y, auto z) {
      const auto at = [](std::int64_t v, int step, std::int64_t size) {
        return std::clamp<std::int64_t>(v + step, 0, size - 1);
      };
      bool shown = false;
      for (int i = -larger; i <= larger; ++i)
        for (int j = -larger; j <= larger; ++j)
          for (int k = -larger; k <= larger; ++k)
            shown |=
                isListed(mask.valueAt(at(x, i, shape.dims.x), at(y, j, shape.dims.y), at(z, k, shape.dims.z)), labels);
      return shown ? volume.valueAt(x, y, z) : std::nan("");
    });
  };
  const Path store = makeStore(volume, "volume", 16), of_mask = makeStore(mask, "mask", 32, true);
  const Path least_store = makeStore(masked_before(0), "least", 16),
             most_store = makeStore(masked_before(1), "most", 16);
  int between = 0;
  for (std::uint64_t seed = 60; seed < casesOf(66u, 61u); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    FrameRequest request = requestAt(seed, volume);
    request.shading.phong = false;
    request.clipping = {};
    request.interpolation = Interpolation::kLinear;
    request.opacity_threshold = 1;
    request.transfer_function = {1, {{0.2, glm::dvec3(0), 0}, {1, glm::dvec3(1), 0.2}}};
    const Image least = draw(least_store, request), most = draw(most_store, request);
    const Image image = drawMasked(store, of_mask, labels, request);
    for (int y = 0; y < kMaskSize.height; ++y) {
      for (int x = 0; x < kMaskSize.width; ++x) {
        const float alpha = image.pixel(x, y)[3];
        // Rounding of a few hundred samples.
        ASSERT_GE(alpha, least.pixel(x, y)[3] - 1e-5f) << x << ", " << y;
        ASSERT_LE(alpha, most.pixel(x, y)[3] + 1e-5f) << x << ", " << y;
        between += least.pixel(x, y)[3] < most.pixel(x, y)[3] ? 1 : 0;
      }
    }
  }
  EXPECT_GT(between, 1000);
}

// Every voxel has a listed label.
TEST(Masks, ThatShowAllChangeNoBit) {
  const DenseVolume volume = cheese({{45, 51, 40}, VoxelType::f32}, 1, {0, 1});
  const DenseVolume mask = fill({{60, 70, 60}, VoxelType::u8, spacingAffine(glm::dvec3(1.1), glm::dvec3(-5))},
                                [](auto x, auto, auto) { return 1 + x % 2; });
  const Path store = makeStore(volume, "volume", 16), of_mask = makeStore(mask, "mask", 32, true);
  const FrameRequest request = requestAt(91, volume);
  const Image image = draw(store, request);
  EXPECT_TRUE(showsSomething(image));
  EXPECT_TRUE(equalBits(image, drawMasked(store, of_mask, {1, 2}, request)));
}

// A uniform medium of 40 voxels along the view, of which the mask shows 20: the border lies between two voxels.
TEST(Masks, ShowTheirLengthOfAUniformMedium) {
  const DenseVolume volume = fill({{40, 40, 40}, VoxelType::u8}, [](auto...) { return 9; });
  for (const double spacing : {1.0, 2.0}) {
    const auto edge = static_cast<std::int64_t>(40 / spacing);
    const DenseVolume mask =
        fill({{edge, edge, edge}, VoxelType::u8, spacingAffine(glm::dvec3(spacing), glm::dvec3((spacing - 1) / 2))},
             [&](auto, auto, auto z) {
               return static_cast<double>(z) * spacing >= 10 && static_cast<double>(z) * spacing < 30 ? 7 : 1;
             });
    const Path store = makeStore(volume, "volume", 16), of_mask = makeStore(mask, "mask", 16, true);
    FrameRequest request;
    Camera camera;
    camera.projection = Projection::kOrthographic;
    camera.eye = {19.5, 19.5, -100}, camera.target = {19.5, 19.5, 19.5}, camera.up = {0, 1, 0};
    camera.height = 10;
    request.view = resolve(camera, {32, 32});
    request.transfer_function = {1, {{0, glm::dvec3(1), 0.05}}};
    request.shading.phong = false;
    request.opacity_threshold = 1;
    const Image image = drawMasked(store, of_mask, {7}, request);
    const double expected = 1 - std::exp(-20 * extinctionOf(0.05, 1));
    EXPECT_NEAR(image.pixel(16, 16)[3], expected, 0.01 * expected) << "mask voxels of " << spacing;
  }
}

// Labels of a segmentation by a threshold, and the labels of the rest, end exactly at the iso-surface of the threshold.
// The whole surface is shown, and the camera that fits the picture is that of the surface without a mask.
TEST(Masks, ByTheThresholdOfASurfaceChangeNoBit) {
  const DenseVolume volume = cheese({{45, 51, 40}, VoxelType::u8}, 1, {0, 255});
  const DenseVolume labels = fill({volume.geometry.dims, VoxelType::u8},
                                  [&](auto x, auto y, auto z) { return volume.valueAt(x, y, z) >= 120 ? 2 : 1; });
  const Path store = makeStore(volume, "volume", 16), mask = makeStore(labels, "labels", 16, true);
  FrameRequest request = requestAt(710, volume);
  request.interpolation = Interpolation::kLinear;
  request.transfer_function = TransferFunction();
  request.transfer_function.surfaces = {{120, glm::dvec3(1), 0.4}};
  request.clipping = {};
  const Image whole = draw(store, request);
  EXPECT_TRUE(showsSomething(whole));
  for (const std::int64_t label : {1, 2}) {
    SCOPED_TRACE("label " + std::to_string(label));
    EXPECT_TRUE(equalBits(whole, drawMasked(store, mask, {label}, request)));
    const ShownBox box = shownBox(*masked(store, mask, {label}), std::vector{request.transfer_function}, {});
    EXPECT_EQ(box.box, shownBox(StoreReader(store), std::vector{request.transfer_function}, {}).box);
  }
}

TEST(Masks, OfSurfacesAreDrawnAlikeByBricksThreadsTilesAndCrops) {
  const DenseVolume volume = cheese({{75, 61, 70}, VoxelType::i16}, 1, usualRange(VoxelType::i16));
  const DenseVolume mask = turnedMask();
  const Path large = makeStore(volume, "large", 128), small = makeStore(volume, "small", 16);
  const Path large_mask = makeStore(mask, "large_mask", 64, true), small_mask = makeStore(mask, "small_mask", 16, true);
  const ValueRange range = volume.range();
  for (const Interpolation interpolation : {Interpolation::kLinear, Interpolation::kCubic}) {
    FrameRequest request = requestAt(700, volume);
    request.interpolation = interpolation;
    request.transfer_function = TransferFunction();
    for (const double at : {0.3, 0.5, 0.6})
      request.transfer_function.surfaces.push_back({std::lerp(range.lo, range.hi, at), glm::dvec3(at, 1, 0.5), 0.5});
    const Image truth = drawMasked(large, large_mask, {1, 2, 4}, request);
    EXPECT_TRUE(showsSomething(truth));
    EXPECT_FALSE(equalBits(truth, draw(large, request)));
    EXPECT_TRUE(equalBits(truth, drawMasked(small, large_mask, {1, 2, 4}, request))) << "bricks of 16";
    request.visibility.method = VisibilityMethod::kMask;
    EXPECT_TRUE(equalBits(truth, drawMasked(small, small_mask, {1, 2, 4}, request))) << "tested for visibility";
    const ThreadLimit one(1);
    request.tile_px = 128;
    request.crop = PixelRect{21, 13, 70, 57};
    EXPECT_TRUE(equalBits(partOf(truth, *request.crop), drawMasked(small, small_mask, {1, 2, 4}, request)))
        << "cropped";
  }
}

// The lower front quarter of a ball is seen from the front, with nothing behind its soft border. An iso-surface has no
// thickness: each of its points has the light and the normal that it has without the mask.
TEST(Masks, OfASurfaceLeaveTheLightOfWhatTheyShow) {
  const VolumeShape shape{{40, 40, 40}, VoxelType::u8};
  const DenseVolume volume = fill(shape, [](auto x, auto y, auto z) {
    return std::clamp(100 + 20 * (13.4 - glm::distance(glm::dvec3(x, y, z), glm::dvec3(19.3, 19.6, 19.8))), 0.0, 200.0);
  });
  const DenseVolume lower = fill(shape, [](auto, auto y, auto z) { return y < 20 && z < 20 ? 1 : 0; });
  const Path store = makeStore(volume, "volume", 16), mask = makeStore(lower, "lower", 16, true);
  FrameRequest request;
  request.view = resolve(cameraFrom(volume.geometry, {0, -1, 0}, Projection::kOrthographic), kMaskSize);
  request.transfer_function.surfaces = {{100, glm::dvec3(1), 1}};
  request.filters_rays = false;  // the filter mixes neighbouring pixels
  for (const bool with_normals : {false, true}) {
    request.aovs = {with_normals, with_normals};
    const Image whole = draw(store, request), part = drawMasked(store, mask, {1}, request);
    int opaque = 0;
    for (int y = 0; y < part.height; ++y) {
      for (int x = 0; x < part.width; ++x) {
        if (part.pixel(x, y)[3] < 1) continue;
        ++opaque;
        for (int c = 0; c < 4; ++c) EXPECT_NEAR(part.pixel(x, y)[c], whole.pixel(x, y)[c], 1e-5) << x << " " << y;
        if (with_normals) {
          EXPECT_LT(glm::distance(normalAt(part, x, y), normalAt(whole, x, y)), 1e-5) << x << " " << y;
        }
      }
    }
    EXPECT_GT(opaque, 200);
  }
}

// A mask of a corner: only the brick at the corner is read. The index has ranges of labels: a range from 1 to 5 may
// hold label 3. Bricks of such a range are looked up in the mask, and not read either.
TEST(Masks, BricksThatTheyHideAreNotRead) {
  const DenseVolume volume =
      fill({{64, 64, 64}, VoxelType::u8}, [](auto x, auto y, auto z) { return 50 + (x + y + z) % 7; });
  const Path store = makeStore(volume, "volume", 16);
  FrameRequest request;
  request.view = resolve(cameraFrom(volume.geometry, {1, 2, 3}, Projection::kPerspective), kMaskSize);
  request.level = 0;
  request.transfer_function = {1, {{0, glm::dvec3(1), 0.01}}};
  const ThreadLimit one(1);
  FrameStatistics statistics;
  draw(store, request, 1ull << 30, &statistics);
  EXPECT_EQ(statistics.bricks_read, 64u);
  for (const bool ambiguous : {false, true}) {
    const DenseVolume mask = fill({{64, 64, 64}, VoxelType::u8}, [&](auto x, auto y, auto z) {
      return x < 14 && y < 14 && z < 14 ? 3 : ambiguous && x > 40 ? 5 : 1;
    });
    const Path of_mask = makeStore(mask, ambiguous ? "ambiguous" : "mask", 16, true);
    EXPECT_TRUE(showsSomething(drawMasked(store, of_mask, {3}, request, 1ull << 30, &statistics)));
    EXPECT_EQ(statistics.bricks_read, 1u);
    EXPECT_EQ(statistics.bricks_masked + statistics.bricks_emptied + statistics.bricks_read, 64u);
    EXPECT_EQ(statistics.bricks_masked, ambiguous ? 12u : 56u);
    // The brick at the corner, and the slices in which labels 1 and 5 meet.
    EXPECT_EQ(statistics.companion_reads, ambiguous ? 17u : 1u);
    EXPECT_FALSE(showsSomething(drawMasked(store, of_mask, {99}, request, 1ull << 30, &statistics)));
    EXPECT_EQ(statistics.bricks_read + statistics.companion_reads, 0u);
    EXPECT_EQ(statistics.bricks_masked, 64u);
  }
}

// Known because none of the varied options is part of the picture's definition.
TEST(Masks, OfOneOfSeveralVolumesAreDrawnAlike) {
  const DenseVolume volume = cheese({{45, 61, 50}, VoxelType::i16}, 1, usualRange(VoxelType::i16));
  const DenseVolume mask = turnedMask();
  const Path large = makeStore(volume, "large", 64), small = makeStore(volume, "small", 16);
  const Path of_mask = makeStore(mask, "mask", 16, true);
  FrameStatistics statistics;
  const auto drawn = [&](const Path& store, const FrameRequest& request) {
    const std::unique_ptr<BrickedVolume> first = masked(store, of_mask, {1, 2}), second = masked(store, of_mask, {4});
    return draw(std::vector<const BrickedVolume*>{first.get(), second.get()}, request, 1ull << 30, &statistics);
  };
  FrameRequest request = requestAt(704, volume);
  const RandomScene other = randomScene(705, volume, kMaskSize);
  request.volumes.push_back({request.transfer_function, request.shading, {}});
  request.volumes.push_back({other.transfer_function, other.shading, {}});
  request.clipping = {};
  const Image truth = drawn(large, request);
  EXPECT_TRUE(showsSomething(truth));
  EXPECT_TRUE(equalBits(truth, drawn(small, request))) << "bricks of 16";
  EXPECT_GT(statistics.bricks_masked, 0u) << "bricks beside the mask";
  const ThreadLimit one(1);
  request.visibility.method = VisibilityMethod::kMask;
  request.tile_px = 128;
  EXPECT_TRUE(equalBits(truth, drawn(small, request))) << "one thread, other tiles";
}

// A layer that the mask hides casts no shadow on the floor. The eye looks below the layer.
TEST(Masks, HiddenVoxelsCastNoShadow) {
  const DenseVolume volume = fill({{48, 48, 48}, VoxelType::u8}, [](auto, auto, auto z) {
    return z < 8 ? 200 : z >= 30 && z < 34 ? 100 : 0;
  });
  const DenseVolume mask = fill({{48, 48, 48}, VoxelType::u8}, [](auto, auto, auto z) { return z < 20 ? 1 : 2; });
  const Path store = makeStore(volume, "volume", 16), of_mask = makeStore(mask, "mask", 16, true);
  FrameRequest request;
  Camera camera;
  camera.projection = Projection::kOrthographic;
  camera.target = {23.5, 12, 8}, camera.eye = {23.5, -60, 60}, camera.up = {0, 0, 1};
  camera.height = 8;
  request.view = resolve(camera, {16, 16});
  request.transfer_function = {1, {{50, glm::dvec3(1), 0}, {100, glm::dvec3(1), 0.5}, {200, glm::dvec3(1), 0.99}}};
  request.shading.ambient = 0.1;
  request.shading.lights = {{LightKind::kDirectional, {0, 0, 1}, glm::dvec3(1)}};
  request.shading.shadows = true;
  const Image shadowed = draw(store, request), lit = drawMasked(store, of_mask, {1}, request);
  request.shading.shadows = false;
  const Image plain = drawMasked(store, of_mask, {1}, request);
  EXPECT_LT(shadowed.pixel(8, 8)[0], 0.9 * plain.pixel(8, 8)[0]);
  EXPECT_NEAR(lit.pixel(8, 8)[0], plain.pixel(8, 8)[0], 0.02 * plain.pixel(8, 8)[0]);
}

TEST(Masks, OfAmountsAreRefused) {
  const DenseVolume volume = fill({{20, 20, 20}, VoxelType::u8}, [](auto x, auto, auto) { return x; });
  const Path store = makeStore(volume, "volume", 16);
  expectError([&] { masked(store, store, {3}); }, ErrorCode::kUsage, "holds amounts, and a mask needs labels");
}

// A damaged brick of the mask is an error that names the mask.
TEST(Masks, WithADamagedBrickAreErrors) {
  const DenseVolume volume = cheese({{40, 40, 40}, VoxelType::u8}, 1, {0, 200});
  const DenseVolume mask = bodies({{40, 40, 40}, VoxelType::u8});
  const Path store = makeStore(volume, "volume", 16), of_mask = makeStore(mask, "mask", 32, true);
  std::filesystem::remove(of_mask / "bricks/0/0_0_0.vdb");
  FrameRequest request = requestAt(701, volume);
  request.transfer_function = {1, {{0, glm::dvec3(1), 0.01}}};
  request.view = resolve(cameraFrom(volume.geometry, {1, 2, 3}, Projection::kPerspective), kMaskSize);
  expectError([&] { drawMasked(store, of_mask, {2}, request); }, ErrorCode::kNotFound,
              "mask/volume.kiln/bricks/0/0_0_0.vdb");
}

}  // namespace
}  // namespace kiln::test
