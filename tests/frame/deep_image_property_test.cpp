// Deep images. Known:
// 1. Composited by *over*, a pixel's samples equal the flat pixel, for every scene and every limit on the number of
// samples.
// 2. Samples of a pixel do not overlap in depth.
// 3. Crops, tiles, threads and memory change no sample.
// 4. Deep images of parts of the volume, merged by depth, equal the deep image of the whole volume.
#include <ImfChannelList.h>
#include <ImfDeepScanLineInputFile.h>
#include <ImfHeader.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "base/file/file.h"
#include "image/compare.h"
#include "image/file/image_file.h"
#include "sequence/render_job_run.h"
#include "support/reference/drawing.h"
#include "support/system/sanitized.h"
#include "support/volumes/random_scene.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

constexpr ImageSize kDeepSize{70, 60};

FrameRequest deepRequest(const RandomScene& scene, const DeepBound& bound) {
  FrameRequest request = requestOf(scene, Lattice::kPixel, 0.99);
  request.background = {};
  request.deep = bound;
  request.filters_rays = false;
  return request;
}

std::vector<DeepSample> samplesAt(const Image& image, int x, int y) {
  std::vector<DeepSample> out(static_cast<std::size_t>(image.deep->count(x, y)));
  image.deep->copy(x, y, out.data());
  return out;
}

std::array<double, 4> laidOver(const std::vector<DeepSample>& samples) {
  std::array<double, 4> out{};
  for (const DeepSample& s : samples) {
    const double open = 1 - out[3];
    for (std::size_t c = 0; c < 4; ++c) out[c] += open * s.rgba[c];
  }
  return out;
}

double largestDifference(const Image& a, const Image& b) {
  double out = 0;
  for (std::size_t i = 0; i < a.rgba.size(); ++i)
    out = std::max(out, std::abs(double{a.rgba[i]} - b.rgba[i]) / std::max(1.0, std::abs(double{b.rgba[i]})));
  return out;
}

class DeepImages : public ::testing::Test {
 protected:
  void SetUp() override {
    volume_ = head({{40, 51, 37}, VoxelType::u8, obliqueAffine()}, usualRange(VoxelType::u8));
    store_ = makeStore(volume_, "deep", 16);
    directory_ = store_.parent_path();
  }
  DenseVolume volume_;
  fs::path store_, directory_;
  Progress silent_;
};

TEST_F(DeepImages, AreTheFlatPicture) {
  int several = 0;
  for (std::uint64_t seed = 300; seed < casesOf(308u, 303u); ++seed) {
    const RandomScene scene = randomScene(seed, volume_, kDeepSize);
    const DeepBound bound{seed % 3 == 0 ? 5 : 1024, seed % 3 == 1 ? 0.01f : 0};
    FrameRequest request = deepRequest(scene, bound);
    const Image image = draw(store_, request);
    request.deep.reset();
    EXPECT_TRUE(equalBits(colorsOf(image), draw(store_, request))) << seed;
    for (int y = 0; y < kDeepSize.height; ++y) {
      for (int x = 0; x < kDeepSize.width; ++x) {
        const std::vector<DeepSample> samples = samplesAt(image, x, y);
        const std::array<double, 4> flat = laidOver(samples);
        for (std::size_t c = 0; c < 4; ++c)
          ASSERT_NEAR(flat[c], image.pixel(x, y)[c], 1e-5 * std::max(1.0, flat[c])) << seed << ": " << x << ", " << y;
        for (std::size_t i = 0; i < samples.size(); ++i) {
          ASSERT_LT(samples[i].z, samples[i].z_back);
          ASSERT_LE(samples[i > 0 ? i - 1 : 0].z, samples[i].z);
          ASSERT_TRUE(i == 0 || samples[i - 1].z_back <= samples[i].z);
        }
        several += samples.size() > 3 ? 1 : 0;
      }
    }
  }
  EXPECT_GT(several, casesOf(1000, 300));
}

TEST_F(DeepImages, OfSeveralVolumesAreTheFlatPicture) {
  const RandomScene scene = randomScene(309, volume_, kDeepSize);
  FrameRequest request = deepRequest(scene, {1024, 0});
  request.clipping = {};
  TransferFunction other = scene.transfer_function;
  for (TransferPoint& point : other.points) point.opacity *= 0.1;
  request.volumes = {{scene.transfer_function, {}, {}}, {other, {}, {}}};
  const Image image = draw({store_, store_}, request);
  EXPECT_TRUE(showsSomething(image));
  for (int y = 0; y < kDeepSize.height; ++y) {
    for (int x = 0; x < kDeepSize.width; ++x) {
      const std::array<double, 4> flat = laidOver(samplesAt(image, x, y));
      for (std::size_t c = 0; c < 4; ++c)
        ASSERT_NEAR(flat[c], image.pixel(x, y)[c], 1e-5 * std::max(1.0, flat[c])) << x << ", " << y;
    }
  }
}

TEST_F(DeepImages, DoNotDependOnWhatDoesNotChangeAPicture) {
  const auto other = makeStore(volume_, "deep_large", 64);
  for (std::uint64_t seed = 310; seed < 313; ++seed) {
    const RandomScene scene = randomScene(seed, volume_, {150, 140});
    FrameRequest request = deepRequest(scene, {6, 0.001f});
    request.level = 0;
    const Image whole = draw(store_, request);
    request.crop = PixelRect{60, 33, 141, 130};
    request.tile_px = 128;
    request.visibility.method = VisibilityMethod::kNone;
    const Image crop = draw(other, request, 4u << 20);
    for (int y = 33; y < 130; ++y) {
      for (int x = 60; x < 141; ++x) {
        const std::vector<DeepSample> a = samplesAt(whole, x, y), b = samplesAt(crop, x, y);
        ASSERT_EQ(a.size(), b.size()) << seed << ": " << x << ", " << y;
        for (std::size_t i = 0; i < a.size(); ++i) {
          ASSERT_EQ(a[i].z, b[i].z);
          ASSERT_EQ(a[i].z_back, b[i].z_back);
          ASSERT_EQ(a[i].rgba, b[i].rgba);
        }
      }
    }
  }
}

RenderJob jobOf(const fs::path& store, const RandomScene& scene) {
  RenderJob job;
  job.volume = store;
  job.picture.size = kDeepSize;
  job.picture.camera = specOf(scene.camera);
  job.picture.transfer_function = scene.transfer_function;
  job.picture.shading = scene.shading;
  return job;
}

// OpenEXR's own reader composites deep samples when flat rows are read.
TEST_F(DeepImages, InFilesFlattenWithinHalfAFloatsRounding) {
  for (std::uint64_t seed = 320; seed < 326; ++seed) {
    RenderJob job = jobOf(store_, randomScene(seed, volume_, kDeepSize));
    job.output.path = directory_ / "deep.exr";
    job.output.deep = true;
    job.output.deep_bound.samples = 12;
    job.output.exr_compression = seed % 3 == 0 ? "rle" : seed % 3 == 1 ? "none" : "zip";
    if (seed % 2 == 0) job.picture.crop = PixelRect{7, 5, 60, 55};
    const Image flat = colorsOf(runRenderJob(job, 1, silent_).image);
    EXPECT_LE(largestDifference(readImage(job.output.path), flat), 0x1p-11) << seed;
    job.output.exr_float = true;
    runRenderJob(job, 1, silent_);
    EXPECT_LE(largestDifference(readImage(job.output.path), flat), 1e-5) << seed;
    checkImage(job.output.path);
    EXPECT_TRUE(readImageText(job.output.path).contains("kiln:job"));

    const Imf::DeepScanLineInputFile file(job.output.path.c_str());
    EXPECT_EQ(file.header().type(), Imf::DEEPSCANLINE);
    EXPECT_EQ(file.header().dataWindow().min.x, seed % 2 == 0 ? 7 : 0);
    EXPECT_EQ(file.header().displayWindow().max.x, kDeepSize.width - 1);
    EXPECT_TRUE(Imf::hasWorldToCamera(file.header()));
    std::string names;
    for (auto c = file.header().channels().begin(); c != file.header().channels().end(); ++c) {
      names += std::string(c.name()) + " ";
      EXPECT_EQ(c.channel().type, Imf::FLOAT);
    }
    EXPECT_EQ(names, "A B G R Z ZBack ");
  }
}

// Merges deep images as compositing programs do: all samples in order of depth.
Image mergedByDepth(const std::vector<Image>& parts) {
  Image out(kDeepSize.width, kDeepSize.height);
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      std::vector<DeepSample> all;
      for (const Image& part : parts) {
        const std::vector<DeepSample> samples = samplesAt(part, x, y);
        all.insert(all.end(), samples.begin(), samples.end());
      }
      std::stable_sort(all.begin(), all.end(), [](const DeepSample& a, const DeepSample& b) { return a.z < b.z; });
      for (std::size_t i = 1; i < all.size(); ++i) EXPECT_LE(all[i - 1].z_back, all[i].z) << "samples overlap";
      const std::array<double, 4> flat = laidOver(all);
      std::copy(flat.begin(), flat.end(), out.pixel(x, y));
    }
  }
  return out;
}

TEST_F(DeepImages, OfPartsMakeTheWhole) {
  double worst_mean = 0, worst = 0;
  for (std::uint64_t seed = 330; seed < casesOf(338u, 332u); ++seed) {
    const RandomScene scene = randomScene(seed, volume_, kDeepSize);
    FrameRequest request = deepRequest(scene, {1024, 0});
    request.opacity_threshold = 0.998;
    request.clipping = {};
    const Image whole = draw(store_, request);
    std::vector<Image> parts;
    for (const VoxelBox& box :
         {VoxelBox{{0, 0, 0}, {40, 51, 17}}, VoxelBox{{0, 0, 17}, {19, 51, 37}}, VoxelBox{{19, 0, 17}, {40, 51, 37}}}) {
      request.clipping.part = box;
      parts.push_back(draw(store_, request));
    }
    const Image merged = mergedByDepth(parts);
    double sum = 0;
    for (std::size_t i = 0; i < merged.rgba.size(); ++i)
      sum += std::abs(merged.rgba[i] - whole.rgba[i]) / std::max(1.0f, whole.rgba[i]);
    const double largest = largestDifference(merged, colorsOf(whole)),
                 mean = sum / static_cast<double>(merged.rgba.size());
    worst = std::max(worst, largest), worst_mean = std::max(worst_mean, mean);
  }
  std::printf("deep images of three parts: a pixel is off by %.4f at most, by %.5f in the mean\n", worst, worst_mean);
  // Tolerance: the light behind pixels that reached the opacity threshold.
  EXPECT_LT(worst, 0.0021);
  EXPECT_LT(worst_mean, 0.0001);
}

// A medium has no edges, so its parts follow each other in depth like slabs.
TEST_F(DeepImages, OfPartsOfAMediumAreTheWhole) {
  const auto fog = makeStore(fill({{40, 44, 36}, VoxelType::f32},
                                  [](auto i, auto j, auto k) { return 100.0 + static_cast<double>(i + 2 * j + k); }),
                             "deep_fog", 16);
  RandomScene scene = randomScene(1, volume_, kDeepSize);
  scene.camera = cameraFrom({{40, 44, 36}, glm::dmat4(1.0), {}, {}}, {-1, -2, 1.5}, Projection::kPerspective);
  scene.camera.target = {20, 22, 18};
  scene.camera.fov_deg = 12;
  scene.view = resolve(scene.camera, kDeepSize);
  scene.transfer_function.unit = 1;
  scene.transfer_function.points = {{100, {0.9, 0.2, 0.1}, 0.02}, {260, {0.1, 0.4, 0.9}, 0.06}};
  scene.clipping = {};
  FrameRequest request = deepRequest(scene, {1024, 0});
  request.opacity_threshold = 1;
  const Image whole = draw(fog, request);
  std::vector<Image> parts;
  for (const VoxelBox& box : {VoxelBox{{0, 0, 0}, {17, 44, 36}}, VoxelBox{{17, 0, 0}, {40, 44, 36}}}) {
    request.clipping.part = box;
    parts.push_back(draw(fog, request));
  }
  EXPECT_GT(whole.pixel(35, 30)[3], 0.4f);
  EXPECT_LT(largestDifference(mergedByDepth(parts), colorsOf(whole)), 1 / 255.0);
}

}  // namespace
}  // namespace kiln::test
