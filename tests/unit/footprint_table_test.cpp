// Footprints are what they say they are: a pixel's square folded with a Gaussian, in no more pixels than it needs.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "splat/sheet.h"

namespace kiln {
namespace {

// What a Gaussian at `at` puts into pixel [i, i + 1).
double inPixel(double at, int i, double sigma) {
  const auto below = [&](double x) { return 0.5 * std::erfc((at - x) / (sigma * std::numbers::sqrt2)); };
  return below(i + 1) - below(i);
}

// By how much weights are wrong, at the most; of the phases from the `first` on.
double worstOf(const FootprintTable& table, int first, double sigma) {
  const int taps = table.taps();
  double worst = 0;
  for (int phase = 0; phase < FootprintTable::kPhases; ++phase) {
    // The window's first pixel is 0. An even window has the sample in the upper half of the pixel before its middle or
    // the lower half of the one after; an odd one has it in its middle pixel.
    const double within = (phase + 0.5) / FootprintTable::kPhases;
    const double at = taps / 2 + within - (taps % 2 == 0 ? 0.5 : 0);
    const float* const row = table.row(first + phase);
    double sum = 0;
    for (int i = 0; i < taps; ++i) {
      const auto weight = static_cast<double>(row[i]);
      worst = std::max(worst, std::abs(weight - inPixel(at, i, sigma)));
      sum += weight;
      if (std::abs(i + 0.5 - at) > table.radius()) {
        EXPECT_EQ(weight, 0);
      }
      for (int c = 0; c < 4; ++c) EXPECT_EQ(table.wide(first + phase)[4 * i + c], row[i]);
    }
    EXPECT_NEAR(sum, 1, 1e-6);
    for (int i = taps; i < table.padded(); ++i) EXPECT_EQ(row[i], 0);
  }
  return worst;
}

TEST(FootprintTable, HasTheGaussiansPartOfEachPixel) {
  for (const double sigma : {0.15, 0.21, 0.27, 0.33, 0.36, 0.42, 0.5, 0.55, 0.7, 1.0, 2.5}) {
    for (const double wider : {1.0, 1.3}) {
      const FootprintTable own(sigma, wider * sigma);
      EXPECT_EQ(own.taps(), FootprintTable(wider * sigma).taps());
      for (const int more : {0, 1, 4}) {
        const FootprintTable table(sigma, wider * sigma, own.taps() + more);
        ASSERT_EQ(table.taps(), own.taps() + more);
        EXPECT_EQ(table.radius(), own.radius());
        EXPECT_LT(worstOf(table, 0, sigma), 0.006) << sigma << ", " << table.taps() << " taps";
        EXPECT_LT(worstOf(table, FootprintTable::kSoftRows, wider * sigma), 0.006) << wider * sigma;
      }
    }
  }
}

TEST(FootprintTable, IsNoWiderThanItNeedsToBe) {
  // A lattice of half a pixel, one of 3/4 at the most, and one of whole pixels.
  EXPECT_EQ(FootprintTable(0.42 * 0.5).taps(), 3);
  EXPECT_EQ(FootprintTable(0.42 * 0.75).taps(), 3);
  EXPECT_EQ(FootprintTable(0.42).taps(), 4);
  EXPECT_EQ(FootprintTable(0.42 * 1.5).taps(), 5);
}

}  // namespace
}  // namespace kiln
