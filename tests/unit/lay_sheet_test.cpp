// Against the definition, pixel by pixel and bit by bit: what a slab adds to a pixel, which pixels become opaque, and
// that nothing is left in the block of the sheet and nothing happens beside it; on every instruction set.
#include "splat/lay_sheet.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "splat/sheet.h"
#include "support/procedural.h"
#include "support/scalar_kernels.h"

namespace kiln::test {
namespace {

constexpr int kColumns = 20;  // of the sheet and of the image
constexpr float kOpaqueAt = 0.9f, kErosion = 0.2f, kColorUnit = 4;

struct Planes {
  std::vector<float> pixels = std::vector<float>(4 * kColumns * kBlockEdge);
  std::vector<std::int32_t> sums = std::vector<std::int32_t>(pixels.size()),
                            filled{std::vector<std::int32_t>(pixels.size() / 4)};
  std::vector<CoveredPixel> covered = std::vector<CoveredPixel>(filled.size());
  BlockBits takes{};

  explicit Planes(std::uint64_t seed) {
    const auto unit = [&] { return static_cast<float>(hashUnit(11, seed++)); };
    for (std::size_t i = 0; i < filled.size(); ++i) {
      const float fill = unit() < 0.3f ? 0 : 1.4f * unit(), opacity = unit() < 0.2f ? 0 : unit();
      filled[i] = static_cast<std::int32_t>(fill * Sheet::kOne);
      for (std::size_t c = 0; c < 4; ++c) {
        sums[4 * i + c] = static_cast<std::int32_t>(fill * opacity * (c < 3 ? unit() : 1) * Sheet::kOne);
        pixels[4 * i + c] = 0.8f * unit();
      }
      covered[i] = static_cast<CoveredPixel>(255 * unit());
    }
    for (std::uint8_t& row : takes) row = static_cast<std::uint8_t>(255 * unit());
  }
};

TEST(LaySheet, AddsWhatASlabShowsToThePixelsThatTakeIt) {
  for (const int width : {1, 3, 7, 8}) {
    const int height = 9 - width;
    SCOPED_TRACE(width);
    onEveryInstructionSet([&](std::int64_t target) {
      SCOPED_TRACE(target);
      Planes planes(static_cast<std::uint64_t>(1000 * width)), truth = planes;
      SheetBlock block;
      block.pixels = planes.pixels.data(), block.stride = 4 * kColumns;
      block.sums = planes.sums.data(), block.filled = planes.filled.data(), block.columns = kColumns;
      block.width = width, block.height = height;
      block.takes = planes.takes;
      block.covered = planes.covered.data();
      block.erosion = kErosion;
      block.color_unit = kColorUnit;
      block.opaque_at = kOpaqueAt;
      LaidPixels pixels;
      const LaidBlock laid = laySheet(block, &pixels);
      for (int y = 0; y < kBlockEdge; ++y) {
        for (int x = 0; x < kColumns; ++x) {
          const std::size_t i = static_cast<std::size_t>(y * kColumns + x), row = static_cast<std::size_t>(y);
          const bool inside = y < height && x < width;
          float* const pixel = &truth.pixels[4 * i];
          const float before = pixel[3];
          const bool takes = inside && (truth.takes[row] >> x & 1) != 0;
          const bool changed = takes && layPixelScalar(pixel, &truth.sums[4 * i], truth.filled[i], kErosion, kColorUnit,
                                                       truth.covered[i]);
          EXPECT_TRUE(std::equal(pixel, pixel + 4, &planes.pixels[4 * i])) << x << ", " << y;
          EXPECT_EQ(planes.covered[i], truth.covered[i]) << x << ", " << y;
          if (inside) {
            EXPECT_EQ(planes.filled[i], 0);
          }
          if (!inside && (y >= height || x >= kBlockEdge)) {
            EXPECT_EQ(planes.filled[i], truth.filled[i]);
          }
          if (!inside) continue;
          EXPECT_EQ(laid.changed[row] >> x & 1, changed ? 1 : 0);
          EXPECT_EQ(laid.opaque[row] >> x & 1, changed && pixel[3] >= kOpaqueAt ? 1 : 0);
          EXPECT_EQ(std::count(&planes.sums[4 * i], &planes.sums[4 * i] + 4, 0), 4);
          if (changed) {
            EXPECT_EQ(pixels.pixels[row * kBlockEdge + static_cast<std::size_t>(x)].before, before);
          }
        }
      }
    });
  }
}

}  // namespace
}  // namespace kiln::test
