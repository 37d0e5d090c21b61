// What two volumes put into a slab is known in closed form where both fill it, and one alone is left as it is.
#include "splat/join_volumes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "splat/sheet.h"

namespace kiln {
namespace {

constexpr double kOne = Sheet::kOne;

// Two pixels of a volume.
struct Block {
  std::vector<std::int32_t> sums = std::vector<std::int32_t>(8), filled = std::vector<std::int32_t>(2),
                            aovs = std::vector<std::int32_t>(8);
  // Fills `part` of the pixel with material of that opacity and color, the same in each channel.
  void fill(std::size_t pixel, double part, double opacity, double color) {
    filled[pixel] = static_cast<std::int32_t>(kOne * part);
    for (std::size_t c = 0; c < 3; ++c) sums[4 * pixel + c] = static_cast<std::int32_t>(kOne * part * opacity * color);
    sums[4 * pixel + 3] = static_cast<std::int32_t>(kOne * part * opacity);
    aovs[4 * pixel] = sums[4 * pixel + 3];
  }
  VolumeBlock block() { return {sums.data(), filled.data(), aovs.data()}; }
};

TEST(JoinVolumes, ExtinctionsAddUpAndColorsMixByThem) {
  Block a, b;
  a.fill(0, 1, 0.5, 1);
  b.fill(0, 1, 0.75, 0.25);
  a.fill(1, 0.3, 0.4, 1);
  const std::vector<std::int32_t> alone = a.sums;
  const VolumeBlock blocks[] = {a.block(), b.block()};
  joinVolumes(blocks, 2, 2, 1);
  // Optical depths ln 2 and 2 ln 2.
  const double opacity = 1 - 0.5 * 0.25, color = (1 + 2 * 0.25) / 3;
  EXPECT_NEAR(a.sums[3] / kOne, opacity, 1e-6);
  EXPECT_NEAR(a.sums[0] / kOne, opacity * color, 1e-6);
  EXPECT_NEAR(a.filled[0] / kOne, 1, 1e-6);
  // A plane's sums stay weighted by what is seen.
  EXPECT_NEAR(a.aovs[0] / kOne, opacity, 1e-6);
  EXPECT_EQ(b.filled[0], 0);
  EXPECT_EQ(b.sums, std::vector<std::int32_t>(8));
  for (std::size_t i = 4; i < 8; ++i) EXPECT_EQ(a.sums[i], alone[i]) << "of one volume";
}

// What fills less lies in what fills more, whose block has the pixel then.
TEST(JoinVolumes, WhatFillsLessLiesInWhatFillsMore) {
  Block a, b;
  a.fill(0, 0.25, 0.9, 1);
  b.fill(0, 1, 0.2, 0);
  const VolumeBlock blocks[] = {a.block(), b.block()};
  joinVolumes(blocks, 2, 2, 1);
  EXPECT_EQ(a.filled[0], 0);
  EXPECT_NEAR(b.filled[0] / kOne, 1, 1e-6);
  const double both = 1 - 0.1 * 0.8;
  EXPECT_NEAR(b.sums[3] / kOne, 0.25 * both + 0.75 * 0.2, 1e-6);
  const double share = std::log(0.1) / (std::log(0.1) + std::log(0.8));
  EXPECT_NEAR(b.sums[0] / kOne, 0.25 * both * share, 1e-6);
}

}  // namespace
}  // namespace kiln
