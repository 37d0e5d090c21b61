// Pixels are weighted sums of rays. Known from a picture of the rays themselves, added up in doubles.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/thread/parallel.h"
#include "frame/frame_memory.h"
#include "frame/pixel_filter.h"
#include "job/job_facts.h"
#include "store/store_reader.h"
#include "support/reference/drawing.h"
#include "support/system/sanitized.h"
#include "support/volumes/procedural.h"
#include "support/volumes/random_scene.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

constexpr ImageSize kFilteredSize{75, 83};
constexpr double kPixelsOfVoxel = 1.2;  // along the shortest edge

class RayPixels : public ::testing::TestWithParam<int> {
 protected:
  FrameRequest requestFor(Projection projection) const {
    FrameRequest out;
    out.level = 0;
    out.samples = GetParam();
    Camera camera = cameraFrom(volume_.geometry, {0.4, -1, 0.3}, projection);
    camera.height = kFilteredSize.height * volume_.geometry.shortestEdge() / kPixelsOfVoxel;
    out.view = resolve(camera, kFilteredSize);
    const ValueRange range = volume_.range();
    out.transfer_function.points = {{range.lo + 0.1 * (range.hi - range.lo), {1, 0.7, 0.5}, 0},
                                    {range.lo + 0.3 * (range.hi - range.lo), {1, 1, 0.8}, 0.6}};
    return out;
  }
  int edge() const { return subPixelsAlongEdge(GetParam()); }
  // Requests a picture with a pixel for each ray. With two rays a pixel, samples are as far apart along a ray as with
  // one ray a pixel.
  FrameRequest ofRays(FrameRequest request) const {
    request.filters_rays = false;
    if (request.samples == 2) request.sample_distance *= kPixelsOfVoxel;
    request.samples = 1;
    request.view = enlarged(request.view, edge());
    return request;
  }
  // Filter weights of rays, starting with the ray before the pixel along both axes.
  std::vector<std::vector<double>> weights() const {
    if (GetParam() == 2) {
      const double near = 10 / 32.0, far = 3 / 32.0;
      return {{0, 0, far, 0}, {0, near, 0, far}, {far, 0, near, 0}, {0, far, 0, 0}};
    }
    const std::vector<double> line = edge() == 1   ? std::vector{3 / 32.0, 26 / 32.0, 3 / 32.0}
                                     : edge() == 2 ? std::vector{1 / 32.0, 15 / 32.0, 15 / 32.0, 1 / 32.0}
                                                   : std::vector{0.0, 0.25, 0.25, 0.25, 0.25, 0.0};
    std::vector<std::vector<double>> out(line.size(), line);
    for (std::size_t j = 0; j < line.size(); ++j) {
      for (double& weight : out[j]) weight *= line[j];
    }
    return out;
  }
  // Returns the index of a ray inside the picture. Indices beyond the edge are clamped; in the quincunx pattern they
  // are mirrored.
  int within(int at, int size) const {
    if (GetParam() == 2) return at < 0 ? -at : at < size ? at : 2 * size - 2 - at;
    return std::clamp(at, 0, size - 1);
  }

  const DenseVolume volume_ = head({{40, 51, 37}, VoxelType::u8, anisotropicAffine()}, usualRange(VoxelType::u8));
  const std::filesystem::path store_ = makeStore(volume_, "filter", 16);
};

TEST_P(RayPixels, AreWeightedMeansOfTheRaysAroundThem) {
  for (const Projection projection : {Projection::kOrthographic, Projection::kPerspective}) {
    FrameRequest request = requestFor(projection);
    request.view.centre_px += glm::dvec2(20.3, -17.8);  // over two of the picture's edges
    const Image image = draw(store_, request), rays = draw(store_, ofRays(request));
    if (GetParam() == 2 && projection == Projection::kPerspective) continue;  // whose scale is another at each depth
    const std::vector<std::vector<double>> w = weights();
    double largest = 0, changed = 0;
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        double sum[4] = {};
        for (std::size_t j = 0; j < w.size(); ++j) {
          for (std::size_t i = 0; i < w.size(); ++i) {
            const int from_x = within(edge() * x - 1 + static_cast<int>(i), rays.width);
            const int from_y = within(edge() * y - 1 + static_cast<int>(j), rays.height);
            for (int c = 0; c < 4; ++c) sum[c] += w[j][i] * rays.pixel(from_x, from_y)[c];
          }
        }
        for (int c = 0; c < 4; ++c) largest = std::max(largest, std::abs(sum[c] - double{image.pixel(x, y)[c]}));
        changed = std::max(changed, std::abs(sum[3] - double{rays.pixel(edge() * x, edge() * y)[3]}));
      }
    }
    EXPECT_LT(largest, 1e-6);
    EXPECT_GT(changed, 0.05);
  }
}

TEST_P(RayPixels, WeighRaysByAGaussian) {
  const std::vector<std::vector<double>> w = weights();
  const double sigma = GetParam() == 1 ? 0.481 : GetParam() == 2 ? 0.456 : 0.304;
  const auto of = [&](std::size_t j, std::size_t i) {
    const auto off = [&](std::size_t k) { return (static_cast<double>(k) - 0.5) / edge() - 0.5; };
    return w[j][i] == 0 ? 0 : std::exp(-0.5 * (off(i) * off(i) + off(j) * off(j)) / (sigma * sigma));
  };
  double sum = 0, all = 0;
  for (std::size_t j = 0; j < w.size(); ++j) {
    for (std::size_t i = 0; i < w.size(); ++i) sum += w[j][i], all += of(j, i);
  }
  EXPECT_EQ(sum, 1.0);
  for (std::size_t j = 0; j < w.size() && edge() < 4; ++j) {
    for (std::size_t i = 0; i < w.size(); ++i) EXPECT_NEAR(w[j][i], of(j, i) / all, 0.0025) << i << " " << j;
  }
}

// Rays beside a piece are drawn again with the piece, although the neighbouring piece has drawn them.
TEST_P(RayPixels, AreTheSameInPieces) {
  for (const Projection projection : {Projection::kOrthographic, Projection::kPerspective}) {
    FrameRequest request = requestFor(projection);
    request.aovs = {true, true};
    request.background = {{0.1, 0.2, 0.3, 0.5}, {0.7, 0, 0.1, 1}};
    const Image whole = draw(store_, request);
    request.band_px = 64;
    EXPECT_TRUE(equalBits(whole, draw(store_, request))) << "bands";
    for (const VisibilityMethod method :
         {VisibilityMethod::kNone, VisibilityMethod::kMask, VisibilityMethod::kRangeTree, VisibilityMethod::kOverlay}) {
      if (kSanitized && method != VisibilityMethod::kMask) continue;
      request.visibility.method = method;
      const StoreReader reader(store_);
      BrickCache cache(reader, 1ull << 30);
      Progress silent;
      FramePainter painter(cache, request, silent);
      for (const PixelRect& piece : {PixelRect{0, 40, 75, 83}, PixelRect{0, 0, 31, 40}, PixelRect{31, 0, 75, 40}}) {
        EXPECT_TRUE(equalBits(partOf(whole, piece), painter.draw(piece))) << piece.x0 << " " << piece.y0;
      }
    }
    const ThreadLimit one(1);
    request.tile_px = 0;
    request.crop = PixelRect{9, 13, 61, 44};
    EXPECT_TRUE(equalBits(partOf(whole, *request.crop), draw(store_, request))) << "crop";
  }
}

TEST_P(RayPixels, TellDepthsAndNormalsOfTheirOwnRays) {
  FrameRequest request = requestFor(Projection::kOrthographic);
  request.aovs = {true, true};
  const Image image = draw(store_, request);
  ASSERT_EQ(image.planes.size(), 5u);
  const Image rays = draw(store_, ofRays(request));
  int hits = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      float first = std::numeric_limits<float>::infinity();
      for (int j = 0; j < edge() * edge(); ++j) {
        const int of_x = edge() * x + j % edge(), of_y = edge() * y + j / edge();
        if (GetParam() == 2 && (of_x + of_y) % 2 != 0) continue;
        first = std::min(first, rays.planes[0].values[static_cast<std::size_t>(of_y * rays.width + of_x)]);
      }
      const float found = image.planes[0].values[static_cast<std::size_t>(y * image.width + x)];
      if (std::isinf(first) || std::isinf(found))
        EXPECT_EQ(found, first) << x << " " << y;
      else
        EXPECT_NEAR(found, first, 1e-4 * first) << x << " " << y;
      hits += std::isinf(first) ? 0 : 1;
    }
  }
  EXPECT_GT(hits, 500);
  if (GetParam() == 2) return;  // are not drawn unfiltered
  request.filters_rays = false;
  const Image unfiltered = draw(store_, request);
  for (std::size_t i = 0; i < image.planes.size(); ++i) EXPECT_EQ(image.planes[i].values, unfiltered.planes[i].values);
  EXPECT_EQ(equalBits(image, unfiltered), GetParam() == 16);
}

TEST_P(RayPixels, OfAnOpaqueBodyAreOpaque) {
  const DenseVolume volume = fill({{30, 30, 30}, VoxelType::u8}, [](auto...) { return 100; });
  FrameRequest request = requestFor(Projection::kOrthographic);
  request.transfer_function.points = {{50, glm::dvec3(0.5), 0.999}, {150, glm::dvec3(0.5), 0.999}};
  request.view = resolve(cameraFrom(volume.geometry, {0, -1, 0}, Projection::kOrthographic), kFilteredSize);
  const Image image = draw(makeStore(volume, "solid", 16), request);
  for (int y = 25; y < 55; ++y) {
    for (int x = 25; x < 50; ++x) EXPECT_EQ(image.pixel(x, y)[3], 1.0f) << x << " " << y;
  }
}

// Samples behind a solid are not read, also if only one of two sub-pixels that share a ray is drawn.
TEST_P(RayPixels, OfACropHideWhatIsBehindThem) {
  const DenseVolume volume = fill({{48, 96, 48}, VoxelType::u8}, [](auto...) { return 100; });
  const auto store = makeStore(volume, "deep_solid", 16);
  FrameRequest request = requestFor(Projection::kOrthographic);
  request.transfer_function.points = {{50, glm::dvec3(0.5), 0.999}, {150, glm::dvec3(0.5), 0.999}};
  request.view = resolve(cameraFrom(volume.geometry, {0, -1, 0}, Projection::kOrthographic), kFilteredSize);
  request.crop = PixelRect{30, 34, 44, 49};
  FrameStatistics statistics;
  draw(store, request, 1ull << 30, &statistics);
  // Of six bricks along each ray, the last four.
  const StoreReader reader(store);
  BrickWalkCounts ignored;
  EXPECT_GE(3 * statistics.bricks_hidden, 2 * bricksInView({&reader}, request, ignored).size());
  EXPECT_LE(statistics.bricks_contributing, 9u);
}

// Rays of the whole picture are filtered in place; rays of a crop need a separate image.
TEST_P(RayPixels, AreCharged) {
  RenderJob job;
  job.volume = store_;
  job.picture.size = kFilteredSize;
  job.picture.samples = GetParam();
  const StoreReader store(store_);
  const std::uint64_t e = static_cast<std::uint64_t>(edge()), beside = GetParam() == 16 ? 0 : 2;
  const FrameMemory whole = frameMemory(store, job);
  EXPECT_EQ(whole.band, e == 1 ? 0 : 16 * (75 * e + beside) * (83 * e + beside));
  EXPECT_EQ(whole.image, 16 * 75 * 83 + (e == 1 ? PixelFilter::copiedBytes(kFilteredSize) : 0));
  if (e == 1) {
    EXPECT_GE(whole.band_px, kLargestSide_px);  // a piece is drawn at once, too
    EXPECT_LE(PixelFilter::copiedBytes({16384, 16384}), ThreadLimit::active() * 4 * 5 * 16 * 16384);
  }
  job.picture.crop = PixelRect{9, 13, 61, 44};
  EXPECT_EQ(frameMemory(store, job).band, 16 * (52 * e + beside) * (31 * e + beside));
}

INSTANTIATE_TEST_SUITE_P(Samples, RayPixels, ::testing::Values(1, 2, 4, 16));

TEST(PixelFilter, KnowsWhichSamplesAPixelIsMadeOf) {
  const PixelFilter one(1, true), two(2, true), four(4, true), means(16, true), none(1, false);
  const ImageSize size{10, 8};
  EXPECT_EQ(one.samplesOf({2, 3, 4, 5}, size), (PixelRect{1, 2, 5, 6}));
  EXPECT_EQ(one.samplesOf({0, 3, 10, 8}, size), (PixelRect{0, 2, 10, 8}));
  EXPECT_EQ(four.samplesOf({2, 3, 4, 5}, size), (PixelRect{3, 5, 9, 11}));
  EXPECT_EQ(two.samplesOf({2, 3, 4, 5}, size), (PixelRect{3, 5, 9, 11}));
  EXPECT_EQ(means.samplesOf({2, 3, 4, 5}, size), (PixelRect{8, 12, 16, 20}));
  EXPECT_EQ(none.samplesOf({2, 3, 4, 5}, size), (PixelRect{2, 3, 4, 5}));
  EXPECT_TRUE(one.inPlace({0, 0, 10, 8}, size));
  EXPECT_FALSE(one.inPlace({0, 0, 10, 7}, size));
  EXPECT_TRUE(none.inPlace({2, 3, 4, 5}, size));
  EXPECT_FALSE(four.inPlace({0, 0, 10, 8}, size));
  EXPECT_THROW(PixelFilter(9, true), Error);
}

}  // namespace
}  // namespace kiln::test
