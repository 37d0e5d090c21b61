// Layers of a pixel under a bound for the number of samples. Known: composited by *over*, the samples equal the pixel,
// for every bound. All cuts of one medium lie on a single curve, so its slabs become a single sample. A cut between
// samples differs by no more than the tolerance.
#include "image/deep_samples.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/volumes/random_scene.h"

namespace kiln::test {
namespace {

using Rgba = std::array<double, 4>;

struct Layer {
  float z, z_back;
  std::array<float, 4> before, after;
};

// Returns random layers of a pixel, some with gaps between them; the pixel closes if `closes`.
std::vector<Layer> randomLayers(Random& random, int count, bool closes) {
  std::vector<Layer> out;
  std::array<float, 4> pixel{};
  float z = -3;
  for (int i = 0; i < count; ++i) {
    z += random.chance(0.2) ? 2.5f : 0;
    Layer layer{z, z + 0.5f, pixel, {}};
    const double alpha = random.chance(0.2) ? random.uniform(0.1, 0.6) : random.uniform(0, 0.03);
    for (std::size_t c = 0; c < 4; ++c)
      pixel[c] += static_cast<float>((1 - layer.before[3]) * alpha * (c == 3 ? 1 : random.uniform(0, 1.2)));
    if (closes && i + 1 == count) {
      for (std::size_t c = 0; c < 3; ++c) pixel[c] /= pixel[3];
      pixel[3] = 1;
    }
    layer.after = pixel;
    out.push_back(layer);
    z = layer.z_back;
  }
  return out;
}

std::vector<DeepSample> keptOf(const std::vector<Layer>& layers, const DeepBound& bound) {
  DeepSamples samples({60, 120, 70, 130}, bound);
  for (const Layer& l : layers) samples.add(64, 127, l.z, l.z_back, l.before.data(), l.after.data());
  EXPECT_EQ(samples.count(63, 127), 0);
  std::vector<DeepSample> out(static_cast<std::size_t>(samples.count(64, 127)));
  samples.copy(64, 127, out.data());
  return out;
}

// Returns the light in front of a cut, with evenly filled samples.
Rgba inFrontOf(const std::vector<DeepSample>& samples, double cut) {
  Rgba out{};
  for (const DeepSample& s : samples) {
    if (s.z >= cut) continue;
    const double t = s.z_back <= cut ? 1 : (cut - s.z) / (s.z_back - s.z), alpha = s.rgba[3];
    const double part = t == 1 || alpha == 1 ? 1 : alpha < 1e-9 ? t : -std::expm1(t * std::log1p(-alpha)) / alpha;
    const double open = 1 - out[3];
    for (std::size_t c = 0; c < 4; ++c) out[c] += open * part * s.rgba[c];
  }
  return out;
}

TEST(DeepSamples, AreThePixelWhenTheyAreLaidOverOneAnother) {
  Random random(71);
  for (const int bound : {1, 2, 3, 4, 5, 24, 1024}) {
    for (int i = 0; i < 20; ++i) {
      const std::vector<Layer> layers = randomLayers(random, 60, i % 2 == 0);
      const std::vector<DeepSample> kept = keptOf(layers, {bound, 0});
      EXPECT_LE(kept.size(), static_cast<std::size_t>(bound));
      const Rgba flat = inFrontOf(kept, 1e9);
      for (std::size_t c = 0; c < 4; ++c) EXPECT_NEAR(flat[c], layers.back().after[c], 2e-6) << bound << " " << i;
      for (std::size_t s = 1; s < kept.size(); ++s) EXPECT_LE(kept[s - 1].z_back, kept[s].z);
      EXPECT_EQ(kept.front().z, layers.front().z);
      EXPECT_EQ(kept.back().z_back, layers.back().z_back);
      EXPECT_TRUE(bound != 1024 || kept.size() == layers.size());
    }
  }
}

TEST(DeepSamples, OfOneMediumAreOneSample) {
  std::vector<Layer> layers;
  for (int i = 0; i < 100; ++i) {
    const auto filled = [](int slabs) {
      const float alpha = -std::expm1(-0.02f * static_cast<float>(slabs));
      return std::array<float, 4>{0.5f * alpha, 0.25f * alpha, 0, alpha};
    };
    layers.push_back({static_cast<float>(i), static_cast<float>(i + 1), filled(i), filled(i + 1)});
  }
  EXPECT_EQ(keptOf(layers, {24, 0}).size(), 24u);
  const std::vector<DeepSample> one = keptOf(layers, {24, 1e-3f});
  ASSERT_EQ(one.size(), 1u);
  EXPECT_EQ(one[0].z, 0);
  EXPECT_EQ(one[0].z_back, 100);
  EXPECT_NEAR(one[0].rgba[3], -std::expm1(-2.0), 1e-5);
}

TEST(DeepSamples, AreJoinedWithinTheErrorThatIsAskedFor) {
  Random random(72);
  std::size_t joined = 0;
  for (const float error : {0.002f, 0.02f, 0.2f}) {
    for (int i = 0; i < 30; ++i) {
      const std::vector<Layer> layers = randomLayers(random, 80, false);
      const std::vector<DeepSample> all = keptOf(layers, {1024, 0}), kept = keptOf(layers, {1024, error});
      joined += all.size() - kept.size();
      for (double cut = -3; cut < 80; cut += 0.19) {
        const Rgba expected = inFrontOf(all, cut), found = inFrontOf(kept, cut);
        for (std::size_t c = 0; c < 4; ++c) ASSERT_NEAR(found[c], expected[c], error * 1.001f + 1e-5) << cut;
      }
    }
  }
  EXPECT_GT(joined, 1000u);
}

// Under a bound, the samples with the smallest error are merged: a shell before a mist stays separate.
TEST(DeepSamples, OfAFullPixelAreJoinedWhereItShowsLeast) {
  std::vector<Layer> layers;
  std::array<float, 4> pixel{};
  for (int i = 0; i < 40; ++i) {
    Layer layer{static_cast<float>(i), static_cast<float>(i + 1), pixel, {}};
    for (float& v : pixel) v += (1 - layer.before[3]) * (i == 20 ? 0.7f : 0.01f);
    layer.after = pixel;
    layers.push_back(layer);
  }
  const std::vector<DeepSample> kept = keptOf(layers, {3, 0});
  ASSERT_EQ(kept.size(), 3u);
  EXPECT_EQ(kept[1].z, 20);
  EXPECT_EQ(kept[1].z_back, 21);
  EXPECT_NEAR(kept[1].rgba[3], 0.7f, 1e-5);
}

}  // namespace
}  // namespace kiln::test
