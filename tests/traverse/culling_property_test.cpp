// Culling is conservative: a node's rectangle holds every footprint of its voxels, and a range that is not interesting
// holds no value with opacity. Both are tested against every voxel and every value.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "engine/shared/classifier.h"
#include "engine/shared/projector.h"
#include "grid/pyramid.h"
#include "store/store_reader.h"
#include "support/reference/drawing.h"
#include "support/volumes/procedural.h"
#include "support/volumes/random_scene.h"
#include "support/volumes/test_store.h"
#include "traverse/prefetcher.h"

namespace kiln::test {
namespace {

class NodeBounds : public ::testing::TestWithParam<ProjectedArea> {
 protected:
  static VolumeGeometry volumeOf(std::uint64_t seed) {
    VolumeGeometry volume;
    volume.dims = {64, 64, 64};
    volume.world_from_index = seed % 3 == 0 ? glm::dmat4(1.0) : seed % 3 == 1 ? anisotropicAffine() : obliqueAffine();
    return volume;
  }

  void expectInside(const PixelRect& bounds, const Projector& projector, const VoxelBox& box, std::uint64_t seed) {
    for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
      for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
        for (std::int64_t x = box.lo.x; x < box.hi.x; ++x) {
          const glm::dvec3 p = projector.viewOf({x, y, z});
          if (projector.perspective() && p.z < projector.nearDepth()) continue;
          const glm::dvec2 at = projector.pixelOf(p);
          const Ellipse e = projector.ellipseAt(p);
          // Pixel column c is covered if its centre c + 1/2 is within half_x of the footprint's centre.
          const double left = std::ceil(at.x - e.half_x - 0.5), right = std::floor(at.x + e.half_x - 0.5);
          const double top = std::ceil(at.y - e.half_y - 0.5), bottom = std::floor(at.y + e.half_y - 0.5);
          if (std::abs(at.x) > 1e7 || std::abs(at.y) > 1e7) continue;
          ASSERT_LE(bounds.x0, left) << "seed " << seed;
          ASSERT_LE(bounds.y0, top) << "seed " << seed;
          ASSERT_GT(bounds.x1, right) << "seed " << seed;
          ASSERT_GT(bounds.y1, bottom) << "seed " << seed;
          ++drawn_;
        }
      }
    }
  }
  int drawn_ = 0;
};

TEST_P(NodeBounds, HoldEveryFootprint) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Random random(seed);
    const VolumeGeometry volume = volumeOf(seed);
    const View view = resolve(randomCamera(random, volume), {200, 150});
    const Projector projector(volume, view, GetParam());
    const int edge = 1 << random.between(0, 4);
    const VoxelCoord lo = {random.between(0, 64 - edge), random.between(0, 64 - edge), random.between(0, 64 - edge)};
    const VoxelBox box{lo, {lo.x + edge, lo.y + edge, lo.z + edge}};
    expectInside(projector.bounds(box), projector, box, seed);
  }
  EXPECT_GT(drawn_, 10000);
}

TEST_P(NodeBounds, OfEightBoxesAreThoseOfEach) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Random random(seed);
    const VolumeGeometry volume = volumeOf(seed);
    const Projector projector(volume, resolve(randomCamera(random, volume), {200, 150}), GetParam());
    Projector::Boxes boxes;
    for (VoxelBox& box : boxes) {
      for (int axis = 0; axis < 3; ++axis) {
        box.lo[axis] = random.between(0, 60);
        box.hi[axis] = box.lo[axis] + random.between(1, 4);
      }
    }
    const Projector::Rects rects = projector.bounds(boxes);
    for (std::size_t i = 0; i < boxes.size(); ++i) EXPECT_EQ(rects[i], projector.bounds(boxes[i])) << "seed " << seed;
  }
}

// A node of a coarser level, enlarged by a voxel on every side, holds the footprints of all finer voxels below the
// node.
TEST_P(NodeBounds, HoldEveryFinerFootprint) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Random random(seed);
    const std::vector<VolumeGeometry> levels = pyramidOf(volumeOf(seed), 8, 4);
    const View view = resolve(randomCamera(random, levels[0]), {random.between(2, 200), random.between(2, 150)});
    const int coarse = random.between(1, static_cast<int>(levels.size()) - 1);
    const Projector projector(levels[static_cast<std::size_t>(coarse)], view, GetParam(),
                              Projector(levels[0], view).nearDepth());
    const Extent3& n = levels[static_cast<std::size_t>(coarse)].dims;
    VoxelBox box;
    for (int axis = 0; axis < 3; ++axis) {
      box.lo[axis] = random.between(0, static_cast<int>(n[axis]) - 1);
      box.hi[axis] = std::min<std::int64_t>(box.lo[axis] + 2, n[axis]);
    }
    const PixelRect bounds = projector.bounds(dilated(box, 1));
    for (int level = coarse - 1; level >= 0; --level) {
      const VolumeGeometry& finer = levels[static_cast<std::size_t>(level)];
      const Extent3 by = halvingOf(finer);
      for (int axis = 0; axis < 3; ++axis) {
        box.lo[axis] *= by[axis];
        box.hi[axis] = std::min(box.hi[axis] * by[axis], finer.dims[axis]);
      }
      expectInside(bounds, Projector(finer, view, GetParam()), box, seed);
    }
  }
  EXPECT_GT(drawn_, 10000);
}

INSTANTIATE_TEST_SUITE_P(Areas, NodeBounds, ::testing::Values(ProjectedArea::kBox, ProjectedArea::kSphere));

// A wall of voxels fills the picture. The wall's last layer of bricks lies in the octree's far half and is visited
// after all layers before it are drawn. The files of this layer may even be missing.
TEST(HiddenBricks, AreNotRead) {
  constexpr std::int64_t kBrick = 16;
  const auto store = makeStore(noise({{80, 80, 80}, VoxelType::u8}, 3, {150, 250}), "wall", kBrick);
  Camera camera;
  camera.projection = Projection::kOrthographic;
  camera.eye = {-100, 40, 40};
  camera.target = {40, 40, 40};
  camera.up = {0, 0, 1};
  camera.height = 50;
  FrameRequest request;
  request.lattice = Lattice::kVoxel;
  request.view = resolve(camera, {200, 200});
  request.transfer_function.points = {{100, {1, 1, 1}, 0}, {140, {1, 0.8, 0.6}, 1}};
  request.visibility.method = VisibilityMethod::kNone;
  const Image truth = draw(store, request);
  for (const auto& file : std::filesystem::recursive_directory_iterator(store / "bricks")) {
    if (file.is_regular_file() && file.path().filename().string()[0] == '4') std::filesystem::remove(file);
  }
  EXPECT_ANY_THROW(draw(store, request));
  for (const VisibilityMethod method : {VisibilityMethod::kMask, VisibilityMethod::kRangeTree,
                                        VisibilityMethod::kQuadtree, VisibilityMethod::kOverlay}) {
    request.visibility.method = method;
    FrameStatistics statistics;
    EXPECT_EQ(truth.rgba, draw(store, request, 1ull << 30, &statistics).rgba) << static_cast<int>(method);
    EXPECT_GE(statistics.bricks_hidden, 16u);
  }
}

// The prefetcher names the next bricks in visiting order, without bricks that are hidden by then.
TEST(Prefetcher, NamesTheNextBricksThatAreNotHidden) {
  const auto mask = makeMaskVisibility(64, 64);
  std::vector<BrickInView> in_view;
  for (std::int32_t i = 0; i < 8; ++i) in_view.push_back({{0, {i, 0, 0}}, {8 * i, 0, 8 * i + 8, 8}});
  Prefetcher lookahead(in_view, [&](const BrickInView& brick, auto) { return mask->hidden(brick.rect); });
  const auto names = [&](std::int32_t drawn) {
    std::vector<std::int32_t> out;
    lookahead.turnOf({0, {drawn, 0, 0}});
    for (const auto& [brick, read] : lookahead.next(3)) {
      if (read) out.push_back(brick.key.brick.x);
    }
    return out;
  };
  EXPECT_EQ(names(0), (std::vector<std::int32_t>{1, 2, 3}));
  for (int y = 0; y < 8; ++y) {
    for (int x = 24; x < 40; ++x) mask->close(x, y);
  }
  EXPECT_EQ(names(1), (std::vector<std::int32_t>{2, 5, 6}));
  EXPECT_EQ(names(5), (std::vector<std::int32_t>{6, 7}));
  EXPECT_EQ(names(7), (std::vector<std::int32_t>{}));
}

// Bricks behind each other, and some beside them. Bricks behind are named until two have contributed nothing, and again
// after so many drawn bricks that two are few.
TEST(Prefetcher, GuessesAsLongAsGuessesProveRight) {
  const PixelRect front{0, 0, 8, 8}, beside{8, 0, 16, 8};
  std::vector<BrickInView> in_view;
  for (std::int32_t i = 0; i < 50; ++i) in_view.push_back({{0, {i, 0, 0}}, i == 5 || i > 12 ? beside : front});
  Prefetcher lookahead(in_view, [](const BrickInView& brick, std::span<const PixelRect> covered) {
    return std::any_of(covered.begin(), covered.end(), [&](const PixelRect& r) { return r.contains(brick.rect); });
  });
  const auto names = [&](std::int32_t drawn, bool changed) {
    std::vector<std::int32_t> out;
    lookahead.turnOf({0, {drawn, 0, 0}});
    for (const auto& [brick, read] : lookahead.next(3)) {
      if (read) out.push_back(brick.key.brick.x);
    }
    lookahead.drew({0, {drawn, 0, 0}}, changed);
    return out;
  };
  using Names = std::vector<std::int32_t>;
  EXPECT_EQ(names(0, true), (Names{1, 2, 3}));
  EXPECT_EQ(names(1, false), (Names{2, 3, 4}));
  EXPECT_EQ(names(2, false), (Names{3, 4, 5}));
  EXPECT_EQ(names(3, true), (Names{5}));
  EXPECT_EQ(names(4, true), (Names{5}));
  EXPECT_EQ(names(5, true), (Names{6}));
  for (std::int32_t i = 6; i < 34; ++i) EXPECT_EQ(names(i, true), i <= 12 ? Names{13} : Names{}) << i;
  EXPECT_EQ(names(34, true), (Names{35, 36, 37}));
}

// Bricks behind each other: all but the due brick are guesses. Two guesses are never drawn, so no more are named.
TEST(Prefetcher, GuessesThatAreNeverDrawn_areWrong) {
  const PixelRect front{0, 0, 8, 8};
  std::vector<BrickInView> in_view;
  for (std::int32_t i = 0; i < 40; ++i) in_view.push_back({{0, {i, 0, 0}}, front});
  std::set<std::int32_t> hidden;
  const auto isHidden = [&](const BrickInView& brick, std::span<const PixelRect> covered) {
    return hidden.contains(brick.key.brick.x) || !covered.empty();
  };
  const auto names = [](Prefetcher& lookahead) {
    std::vector<std::int32_t> out;
    for (const auto& [brick, read] : lookahead.next(3)) {
      if (read) out.push_back(brick.key.brick.x);
    }
    return out;
  };
  using Names = std::vector<std::int32_t>;
  // The walk passes over hidden bricks before the prefetcher examines them again.
  Prefetcher passed(in_view, isHidden);
  passed.turnOf({0, {0, 0, 0}});
  EXPECT_EQ(names(passed), (Names{1, 2, 3}));
  passed.turnOf({0, {3, 0, 0}});
  EXPECT_EQ(names(passed), (Names{}));
  // The prefetcher finds them hidden. A guess counts once, although the walk passes over the brick later: after 32
  // drawn bricks two wrong guesses are few.
  Prefetcher examined(in_view, isHidden);
  examined.turnOf({0, {0, 0, 0}});
  EXPECT_EQ(names(examined), (Names{1, 2, 3}));
  examined.drew({0, {0, 0, 0}}, true);
  hidden = {1, 2};
  EXPECT_EQ(names(examined), (Names{3}));
  for (std::int32_t i = 3; i < 35; ++i) {
    examined.turnOf({0, {i, 0, 0}});
    EXPECT_EQ(names(examined), i < 34 ? Names{} : (Names{35, 36, 37})) << i;
    examined.drew({0, {i, 0, 0}}, true);
  }
}

// Known because a brick is examined only by the test of hidden bricks.
TEST(Prefetcher, ExaminesNoBrickWhereAllAreInMemory) {
  const StoreReader store(makeStore(noise({{48, 16, 16}, VoxelType::u8}, 5, {0, 250}), "three", 16));
  BrickCache cache(store, 1u << 30, 1);
  std::vector<BrickInView> in_view;
  for (std::int32_t i = 0; i < 3; ++i) in_view.push_back({{0, {i, 0, 0}}, {8 * i, 0, 8 * i + 8, 8}});
  const auto examined = [&] {
    int out = 0;
    Prefetcher lookahead(in_view, [&](const BrickInView&, auto) {
      ++out;
      return false;
    });
    lookahead.announce(cache);
    lookahead.turnOf(in_view[0].key);
    lookahead.announce(cache);
    cache.settle();
    return out;
  };
  EXPECT_EQ(examined(), 5);
  for (const BrickInView& brick : in_view) cache.get(brick.key);
  EXPECT_EQ(examined(), 0);
}

TEST(Footprint, CarriesTheVolumeOfItsVoxel) {
  // `Ellipse::area` is the integral of exp(-q/2) over the ellipse, cut off at q = 9. The sum runs over a grid of 400
  // steps along the half width.
  VolumeGeometry volume;
  volume.dims = {16, 16, 16};
  volume.world_from_index = obliqueAffine();
  Random random(5);
  const View view = resolve(randomCamera(random, volume), {64, 64});
  const Ellipse e = Projector(volume, view).ellipseAt({0, 0, 30});
  double sum = 0;
  const double step = e.half_x / 400;
  for (double y = -e.half_y; y <= e.half_y; y += step) {
    for (double x = -e.half_x; x <= e.half_x; x += step) {
      const double q = e.a * x * x + 2 * e.b * x * y + e.c * y * y;
      if (q <= 9) sum += std::exp(-q / 2) * step * step;
    }
  }
  EXPECT_NEAR(sum / e.area, 1, 2e-3);
}

TEST(Classifier, RangesAreInterestingWhereAValueIs) {
  int boring = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    Random random(seed);
    const ValueRange all{0, 255};
    const TransferFunction tf = randomTransferFunction(random, all, 1);
    const Classifier classifier(tf, 1, VoxelType::u8, all);
    for (int i = 0; i < 30; ++i) {
      const int lo = random.between(0, 255), hi = random.between(lo, 255);
      bool some = false;
      for (int value = lo; value <= hi; ++value) some = some || classifier.at(static_cast<std::uint8_t>(value)).tau > 0;
      const bool interesting = classifier.interesting({static_cast<double>(lo), static_cast<double>(hi)});
      if (some) {
        ASSERT_TRUE(interesting) << "seed " << seed << " values " << lo << " to " << hi;
      }
      boring += interesting ? 0 : 1;
    }
    EXPECT_FALSE(classifier.interesting({}));
  }
  EXPECT_GT(boring, 100);
}

TEST(Classifier, TableAndSegmentsAgree) {
  // 8-bit values are looked up, floats are evaluated: both results agree to a float's rounding.
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Random random(seed);
    const ValueRange all{0, 255};
    const TransferFunction tf = randomTransferFunction(random, all, 1);
    const Classifier table(tf, 0.7, VoxelType::u8, all);
    const Classifier segments(tf, 0.7, VoxelType::f32, all);
    for (int value = 0; value <= 255; ++value) {
      const Material a = table.at(static_cast<std::uint8_t>(value));
      const Material b = segments.at(static_cast<float>(value));
      ASSERT_EQ(a.tau, b.tau);
      ASSERT_EQ(a.r, b.r);
      ASSERT_FLOAT_EQ(a.tau,
                      static_cast<float>(tf.at(value).opacity > 0 ? extinctionOf(tf.at(value).opacity, 0.7) : 0));
    }
  }
}

}  // namespace
}  // namespace kiln::test
