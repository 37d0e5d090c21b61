// What slabs cover of a pixel, against cases whose answer is known: a body's straight edge, a body that leans, and fog.
#include "splat/coverage.h"

#include <gtest/gtest.h>

#include <cmath>

#include "splat/lay_sheet.h"
#include "splat/sheet.h"

namespace kiln {
namespace {

constexpr float kRounding = 1.0f / 255;

// A block of sheets that is one pixel; the others of it take nothing.
class Pixel {
 public:
  // What it gains by a slab that is filled so far with samples of `opacity`.
  void add(float filled, float opacity) {
    alignas(64) std::int32_t sums[4 * kBlockEdge] = {}, fills[kBlockEdge] = {};
    fills[0] = static_cast<std::int32_t>(filled * Sheet::kOne);
    for (int c = 0; c < 4; ++c) sums[c] = static_cast<std::int32_t>(filled * opacity * Sheet::kOne);
    SheetBlock block;
    block.pixels = rgba_, block.sums = sums, block.filled = fills, block.covered = &covered_;
    block.stride = 4, block.columns = kBlockEdge;
    block.width = block.height = 1;
    block.takes[0] = 1;
    block.opaque_at = 2;
    laySheet(block, nullptr);
  }
  float alpha() const { return rgba_[3]; }

 private:
  float rgba_[4] = {};
  CoveredPixel covered_ = 0;
};

// The part that a slab covers which is filled so far.
float partOf(float filled, float opacity = 1) {
  Pixel pixel;
  pixel.add(filled, opacity);
  return pixel.alpha() / opacity;
}

TEST(Coverage, AnEdgeCoversWhatItDoesHoweverDeepTheBody) {
  Pixel opaque, milk;
  for (int slab = 0; slab < 50; ++slab) opaque.add(0.4f, 1);
  EXPECT_NEAR(opaque.alpha(), partOf(0.4f), kRounding);
  // Of the covered part, as much as of a whole pixel.
  for (int slab = 0; slab < 50; ++slab) milk.add(0.4f, 0.02f);
  EXPECT_NEAR(milk.alpha(), partOf(0.4f, 0.02f) * (1 - std::pow(0.98f, 50.0f)), kRounding);
}

TEST(Coverage, ABodyThatLeansClosesThePixel) {
  Pixel pixel;
  for (const float filled : {0.2f, 0.5f, 0.9f, 1.0f}) {
    pixel.add(filled, 1);
    EXPECT_NEAR(pixel.alpha(), partOf(filled), kRounding);
  }
  EXPECT_NEAR(pixel.alpha(), 1, 1e-6);
}

TEST(Coverage, WhatCoversThePixelIsLaidOver) {
  Pixel pixel;
  for (int slab = 0; slab < 10; ++slab) {
    const float over = pixel.alpha() + (1 - pixel.alpha()) * 0.1f;
    pixel.add(1, 0.1f);
    EXPECT_NEAR(pixel.alpha(), over, 1e-6);
  }
  // Behind fog, an edge shows through it.
  const float fog = pixel.alpha();
  pixel.add(0.4f, 1);
  EXPECT_NEAR(pixel.alpha(), fog + (1 - fog) * partOf(0.4f), 1e-6);
}

TEST(Coverage, IsTheSumOfWhatIsSplitOverTwoSlabs) {
  for (const float opacity : {0.01f, 0.3f, 1.0f}) {
    for (const float filled : {0.1f, 0.25f, 0.5f, 0.8f})
      EXPECT_NEAR(partOf(filled, opacity) + partOf(1 - filled, opacity), 1, 1e-5) << opacity;
  }
  const float erosion = erosionOf(1, 0.25f);
  EXPECT_FLOAT_EQ(erosion, 0.25f);
  EXPECT_NEAR(erosionOf(0.001f, 0.25f), 0, 0.002f);
  EXPECT_FLOAT_EQ(fillingOfHalf(erosion), 0.6f);
}

// A lattice fills pixels by some per cent more or less, which a medium must not show.
TEST(Coverage, AMediumDoesNotShowHowItIsFilled) {
  for (const float filled : {0.96f, 0.98f, 1.02f, 1.04f}) EXPECT_NEAR(partOf(filled, 0.01f), 1, 0.001) << filled;
}

}  // namespace
}  // namespace kiln
