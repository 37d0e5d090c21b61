// Channels: several volumes, each projected in its own colours, and added. A picture is the sum of the volumes' own
// pictures, whatever the bricks, tiles, threads, budgets and bands.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/thread/parallel.h"
#include "support/reference/drawing.h"
#include "support/system/expect_error.h"
#include "support/system/sanitized.h"
#include "support/volumes/random_scene.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

using Paths = std::vector<std::filesystem::path>;
constexpr ImageSize kChannelsSize{80, 70};
constexpr Mode kChannelModes[] = {Mode::kMip, Mode::kMinip, Mode::kAverage, Mode::kAttenuatedMip};

// Three channels: two of equal geometry, and one of another place and resolution.
std::vector<DenseVolume> channelVolumes() {
  return {head({{30, 41, 27}, VoxelType::u8, anisotropicAffine()}, usualRange(VoxelType::u8)),
          cheese({{30, 41, 27}, VoxelType::u16, anisotropicAffine()}, 4, {0, 4000}),
          cheese({{22, 25, 31}, VoxelType::f32, obliqueAffine()}, 2, {0, 1})};
}

FrameRequest channelRequest(std::uint64_t seed, const std::vector<DenseVolume>& volumes, Mode mode) {
  const RandomScene scene = randomScene(seed, volumes[0], kChannelsSize);
  FrameRequest out;
  out.view = scene.view;
  out.mode = mode;
  out.level = 0;  // smaller bricks have more levels
  const glm::dvec3 colors[] = {{1, 0, 0.2}, {0, 1, 0}, {0.1, 0.3, 1}};
  Random random(seed);
  for (std::size_t i = 0; i < volumes.size(); ++i) {
    const ValueRange range = volumes[i].range();
    VolumeRequest volume;
    volume.transfer_function.points = {{range.lo, glm::dvec3(0), 0}, {range.hi, colors[i], 1}};
    if (i == 1) volume.clipping = randomClipping(random, volumes[i].geometry);
    out.volumes.push_back(volume);
  }
  return out;
}

// The request with the colours of all channels but one black.
FrameRequest alone(const FrameRequest& request, std::size_t channel) {
  FrameRequest out = request;
  for (std::size_t i = 0; i < out.volumes.size(); ++i) {
    if (i != channel)
      for (TransferPoint& point : out.volumes[i].transfer_function.points) point.color = glm::dvec3(0);
  }
  return out;
}

class Channels : public ::testing::Test {
 protected:
  void SetUp() override {
    volumes_ = channelVolumes();
    for (std::size_t i = 0; i < volumes_.size(); ++i) {
      small_.push_back(makeStore(volumes_[i], "small_" + std::to_string(i), 16));
      large_.push_back(makeStore(volumes_[i], "large_" + std::to_string(i), 64));
    }
  }
  std::vector<DenseVolume> volumes_;
  Paths small_, large_;
};

// The sum of floats in the order of the volumes, so that each pixel is equal to the bit.
TEST_F(Channels, AreTheSumOfTheirOwnPictures) {
  for (const Mode mode : kChannelModes) {
    for (std::uint64_t seed = 810; seed < casesOf(813u, 811u); ++seed) {
      SCOPED_TRACE("seed " + std::to_string(seed) + " mode " + std::to_string(static_cast<int>(mode)));
      const FrameRequest request = channelRequest(seed, volumes_, mode);
      const Image all = draw(large_, request);
      Image sum(all.width, all.height);
      for (std::size_t i = 0; i < volumes_.size(); ++i) {
        const Image one = draw(large_, alone(request, i));
        for (std::size_t at = 0; at < sum.rgba.size(); ++at)
          sum.rgba[at] = at % 4 == 3 ? std::max(sum.rgba[at], one.rgba[at]) : sum.rgba[at] + one.rgba[at];
      }
      EXPECT_TRUE(showsSomething(all));
      EXPECT_TRUE(equalBits(all, sum));
    }
  }
}

// A single volume has the picture of a frame of one volume.
TEST_F(Channels, OneChannelIsTheVolumesOwnPicture) {
  for (const Mode mode : kChannelModes) {
    FrameRequest request = channelRequest(815, volumes_, mode);
    request.volumes.resize(1);
    const Image channel = draw(Paths{large_[0]}, request);
    request.transfer_function = request.volumes[0].transfer_function;
    request.clipping = request.volumes[0].clipping;
    request.volumes.clear();
    EXPECT_TRUE(equalBits(channel, draw(large_[0], request)));
  }
}

// Known because none of the varied options is part of the picture's definition.
TEST_F(Channels, AreDrawnAlikeByBricksThreadsTilesMemoryAndCrops) {
  for (const Mode mode : kChannelModes) {
    FrameRequest request = channelRequest(820 + static_cast<std::uint64_t>(mode), volumes_, mode);
    request.visibility.method = VisibilityMethod::kNone;
    const Image truth = draw(large_, request);
    EXPECT_TRUE(showsSomething(truth));
    EXPECT_TRUE(equalBits(truth, draw(small_, request))) << "bricks of 16";
    request.visibility.method = VisibilityMethod::kMask;
    const ThreadLimit one(1);
    request.tile_px = 128;
    FrameStatistics statistics;
    EXPECT_TRUE(equalBits(truth, draw(small_, request, 1u << 20, &statistics))) << "culled, little memory";
    EXPECT_GT(statistics.bricks_read, 0u);
    EXPECT_LE(statistics.bricks_interesting, statistics.bricks_total);
    request.crop = PixelRect{13, 9, 77, 66};
    EXPECT_TRUE(equalBits(partOf(truth, *request.crop), draw(small_, request))) << "cropped";
    request.crop.reset();
    request.samples = 4;
    const Image bands = draw(small_, request);
    request.band_px = 64;
    EXPECT_TRUE(equalBits(bands, draw(small_, request))) << "bands";
  }
}

TEST_F(Channels, HaveNoPlaneOfValues) {
  FrameRequest request = channelRequest(830, volumes_, Mode::kMip);
  request.aovs.value = true;
  expectError([&] { draw(large_, request); }, ErrorCode::kUsage, "--aov: value is of one projected volume");
}

// A weak layer in front of a strong one: the strong value is weakened by the length and the share of the weak layer.
TEST(AttenuatedMip, BehindALayerIsKnown) {
  const DenseVolume volume = fill({{24, 24, 64}, VoxelType::u8}, [](auto, auto, auto z) {
    return z >= 10 && z < 30 ? 100 : z >= 40 && z < 50 ? 250 : 0;
  });
  const auto store = makeStore(volume, "layers", 16);
  for (const Projection projection : {Projection::kOrthographic, Projection::kPerspective}) {
    Camera camera = cameraFrom(volume.geometry, {0, 0, -1}, projection);
    camera.height = 10, camera.fov_deg = 3;
    FrameRequest request;
    request.view = resolve(camera, {20, 20});
    request.mode = Mode::kAttenuatedMip;
    request.transfer_function.points = {{0, glm::dvec3(0), 0}, {250, glm::dvec3(1), 1}};
    request.aovs.value = true;
    for (const double attenuation : {0.0, 0.02, 0.05, 0.2}) {
      request.attenuation = attenuation;
      // In front of the strong layer lie 20 voxels of 0.4 and half a voxel of its own rise.
      const double behind = 250 * std::exp(-attenuation * (20 * 0.4 + 0.5)), expected = std::max(100.0, behind);
      const Image image = draw(store, request);
      for (const float value : image.planes.front().values)
        ASSERT_NEAR(value, expected, 2 + 2 * attenuation * expected) << "attenuation " << attenuation;
    }
  }
}

// Bricks behind closed pixels are not read, and change no bit (see Projection.IsTheSame…).
TEST(AttenuatedMip, BricksBehindAreNotRead) {
  const DenseVolume volume =
      fill({{32, 32, 128}, VoxelType::u8}, [](auto x, auto y, auto z) { return 200 + (x + y + z) % 9; });
  const auto store = makeStore(volume, "deep", 16);
  FrameRequest request;
  Camera camera = cameraFrom(volume.geometry, {0, 0, -1}, Projection::kOrthographic);
  camera.height = 20;
  request.view = resolve(camera, {64, 64});
  request.mode = Mode::kAttenuatedMip;
  request.attenuation = 0.2;
  request.transfer_function.points = {{0, glm::dvec3(0), 0}, {209, glm::dvec3(1), 1}};
  const ThreadLimit one(1);
  FrameStatistics culled, all;
  const Image image = draw(store, request, 1u << 28, &culled);
  request.visibility.method = VisibilityMethod::kNone;
  EXPECT_TRUE(equalBits(image, draw(store, request, 1u << 28, &all)));
  EXPECT_LE(2 * culled.bricks_read, all.bricks_read);
}

}  // namespace
}  // namespace kiln::test
