#include "image/srgb.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

namespace kiln {
namespace {

long expectedByte(double linear) { return std::lround(255 * srgbFromLinear(linear)); }

TEST(Srgb, TheCurveIsItsOwnInverse) {
  for (int i = 0; i <= 1000; ++i) EXPECT_NEAR(linearFromSrgb(srgbFromLinear(i / 1000.0)), i / 1000.0, 1e-7);
}

// The standard's own: 50 % grey is 188, 18 % grey 118.
TEST(Srgb, BytesOfKnownLights) {
  const SrgbBytes& bytes = SrgbBytes::all();
  EXPECT_EQ(bytes.of(0), 0);
  EXPECT_EQ(bytes.of(0.18), 118);
  EXPECT_EQ(bytes.of(0.5), 188);
  EXPECT_EQ(bytes.of(1), 255);
}

TEST(Srgb, BytesOfWhatIsNoLightAreThoseOfTheNearest) {
  const SrgbBytes& bytes = SrgbBytes::all();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double v : {-infinity, -1.0, -0.0, std::numeric_limits<double>::denorm_min(), std::nan("")})
    EXPECT_EQ(bytes.of(v), 0) << v;
  for (const double v : {std::nextafter(1.0, 0.0), 1.5, infinity}) EXPECT_EQ(bytes.of(v), 255) << v;
}

TEST(Srgb, BytesAreTheNearestToTheCurve) {
  const SrgbBytes& bytes = SrgbBytes::all();
  // Around each border of two bytes, as near as numbers lie, and of each cell of a table.
  const auto isRightAround = [&](double v) {
    double below = v, above = v;
    for (int i = 0; i < 40; ++i) {
      for (const double at : {below, above}) {
        if (at > 1) continue;
        ASSERT_EQ(bytes.of(at), expectedByte(at)) << at;
      }
      below = std::nextafter(below, 0.0);
      above = std::nextafter(above, 2.0);
    }
  };
  for (int byte = 0; byte < 255; ++byte) isRightAround(linearFromSrgb((byte + 0.5) / 255));
  for (int cell = 1; cell <= 4096; ++cell) isRightAround(cell / 4096.0);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> light(0, 1), dark(0, 0.01);
  for (int i = 0; i < 200'000; ++i) {
    const double v = (i % 2 == 0 ? light : dark)(random);
    ASSERT_EQ(bytes.of(v), expectedByte(v)) << v;
  }
}

}  // namespace
}  // namespace kiln
