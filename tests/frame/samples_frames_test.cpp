// A pixel of several samples, unfiltered, is the mean of as many pixels of a larger image with an equal view. Holds for
// all bands of rows, threads, bricks in memory and crops. Known from the larger picture.
#include <gtest/gtest.h>

#include "base/error.h"
#include "base/thread/parallel.h"
#include "frame/frame_memory.h"
#include "job/job_facts.h"
#include "sequence/render_job_run.h"
#include "store/store_reader.h"
#include "support/reference/drawing.h"
#include "support/reference/function_bytes.h"
#include "support/reference/lattices.h"
#include "support/volumes/random_scene.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

constexpr ImageSize kSampledSize{29, 40};

// The largest departure of `image` from the means of edge × edge pixels of `larger`.
double departure(const Image& image, const Image& larger, int edge) {
  double most = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      for (int channel = 0; channel < 4; ++channel) {
        double sum = 0;
        for (int i = 0; i < edge * edge; ++i) sum += larger.pixel(edge * x + i % edge, edge * y + i / edge)[channel];
        most = std::max(most, std::abs(image.pixel(x, y)[channel] - sum / (edge * edge)));
      }
    }
  }
  return most;
}

class Samples : public ::testing::TestWithParam<Lattice> {
 protected:
  FrameRequest requestFor(std::uint64_t seed) const {
    RandomScene scene = randomScene(seed, volume_, kSampledSize);
    // Views from outside: inside the volume a voxel has thousands of samples, which takes seconds and tests nothing
    // more.
    const Projection projection = seed % 2 == 0 ? Projection::kOrthographic : Projection::kPerspective;
    scene.view = resolve(cameraFrom(volume_.geometry, randomDirection(seed, 0), projection), kSampledSize);
    scene.background = {};
    return requestOf(scene, GetParam(), randomThreshold(seed));
  }

  const DenseVolume volume_ = head({{40, 51, 37}, VoxelType::u8, anisotropicAffine()}, usualRange(VoxelType::u8));
  const std::filesystem::path store_ = makeStore(volume_, "samples", 16);
};

// First depth: the nearest of the sub-pixels' first hits. Mean depth: the mean of the sub-pixels, weighted by alpha.
void expectDepthsOf(const Image& larger, int edge, const Image& image, std::uint64_t seed) {
  ASSERT_EQ(image.planes.size(), 2u);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      float first = std::numeric_limits<float>::infinity();
      double alpha = 0, sum = 0;
      for (int i = 0; i < edge * edge; ++i) {
        const auto at = static_cast<std::size_t>((edge * y + i / edge) * larger.width + edge * x + i % edge);
        first = std::min(first, larger.planes[0].values[at]);
        alpha += larger.rgba[4 * at + 3];
        if (larger.rgba[4 * at + 3] > 0) sum += larger.rgba[4 * at + 3] * larger.planes[1].values[at];
      }
      const auto at = static_cast<std::size_t>(y * image.width + x);
      EXPECT_EQ(image.planes[0].values[at], first) << "seed " << seed;
      if (alpha > 0)
        EXPECT_NEAR(image.planes[1].values[at], sum / alpha, 1e-5 * sum / alpha) << "seed " << seed;
      else
        EXPECT_EQ(image.planes[1].values[at], std::numeric_limits<float>::infinity());
    }
  }
}

TEST_P(Samples, AreMeansOfALargerPicture) {
  for (const std::uint64_t seed : {301, 302}) {
    FrameRequest request = requestFor(seed);
    request.samples = seed == 302 ? 16 : 4;
    request.filters_rays = false;
    const int edge = subPixelsAlongEdge(request.samples);
    request.aovs.depth = request.samples == 4;
    FrameStatistics statistics, of_larger;
    const Image image = draw(store_, request, 1ull << 30, &statistics);
    FrameRequest larger = request;
    larger.samples = 1;
    larger.view.size = {edge * kSampledSize.width, edge * kSampledSize.height};
    larger.view.focal_px = edge * request.view.focal_px;
    larger.view.centre_px = {edge * request.view.centre_px.x, edge * request.view.centre_px.y};
    const Image larger_image = draw(store_, larger, 1ull << 30, &of_larger);
    EXPECT_LT(departure(image, larger_image, edge), 1e-6) << "seed " << seed;
    if (request.aovs.depth) expectDepthsOf(larger_image, edge, image, seed);
    EXPECT_EQ(statistics.bricks_contributing, of_larger.bricks_contributing) << "seed " << seed;
    EXPECT_EQ(statistics.samples, static_cast<unsigned>(request.samples));

    request.aovs.normal = request.aovs.depth;
    request.background = {{0.1, 0.2, 0.3, 0.5}, {0.7, 0, 0.1, 1}};
    const Image whole = draw(store_, request);
    request.band_px = 64 << seed % 2;
    request.visibility.method = seed % 2 == 0 ? VisibilityMethod::kNone : VisibilityMethod::kRangeTree;
    request.tile_px = seed % 2 == 0 ? 0 : 128;
    const std::uint64_t one_brick = StoreReader(store_).largestReadBytes();
    EXPECT_TRUE(equalBits(whole, draw(store_, request, one_brick))) << "bands, seed " << seed;
    const ThreadLimit one(1);
    request.crop = PixelRect{7, 11, 28, 36};
    EXPECT_TRUE(equalBits(partOf(whole, *request.crop), draw(store_, request))) << "crop, seed " << seed;
  }
}

// Known because the budget reported as the smallest works, and a byte less fails.
TEST_P(Samples, AreDrawnInBandsThatFitTheMemory) {
  RenderJob job;
  job.volume = store_;
  job.picture.size = {100, 90};
  job.picture.samples = 4;
  job.picture.aovs = {true, true};
  job.picture.lattice = GetParam();
  const StoreReader store(store_);
  const FrameMemory ample = frameMemory(store, job);
  job.speed.memory_bytes = ample.smallest();
  const FrameMemory least = frameMemory(store, job);
  EXPECT_GE(ample.band_px, 180);
  // Four floats, three of depth, three of a normal.
  constexpr unsigned of_pixel = 40;
  const unsigned beside = GetParam() == Lattice::kPixel ? 2 : 0;
  EXPECT_EQ(ample.band, of_pixel * (200 + beside) * (180 + beside));
  EXPECT_EQ(least.band, of_pixel * (200 + beside) * (64 + beside));
  EXPECT_EQ(least.smallest(), ample.smallest());
  EXPECT_LE(least.besideBricks() + least.brick, job.speed.memory_bytes);
  Progress silent;
  job.speed.memory_bytes += functionBytesOf(job);
  const RenderResult small = runRenderJob(job, 2, silent);
  EXPECT_LE(small.statistics.peak_cache_bytes + small.statistics.peak_slabs_bytes + least.image + least.band +
                least.visibility + least.index,
            job.speed.memory_bytes);
  --job.speed.memory_bytes;
  EXPECT_THROW(runRenderJob(job, 1, silent), Error);
  job.speed.memory_bytes = 1ull << 30;
  EXPECT_TRUE(equalBits(small.image, runRenderJob(job, 1, silent).image));
}

INSTANTIATE_TEST_SUITE_P(Lattices, Samples, ::testing::ValuesIn(kLattices));

}  // namespace
}  // namespace kiln::test
