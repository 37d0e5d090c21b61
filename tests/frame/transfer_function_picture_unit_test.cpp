// The picture of a transfer function over a histogram.
#include <gtest/gtest.h>

#include <cmath>

#include "frame/transfer_function_picture.h"
#include "image/srgb.h"

namespace kiln::test {
namespace {

// Returns whether a pixel has this colour, which plots round to bytes. unit: sRGB.
bool has(const float* pixel, const glm::dvec3& srgb) {
  for (int channel = 0; channel < 3; ++channel) {
    if (std::abs(pixel[channel] - linearFromSrgb(std::round(255 * srgb[channel]) / 255)) > 1e-4) return false;
  }
  return true;
}

// Known: 0.9 lies midway between two rows of the plot, where opacities differ by rounding alone.
TEST(TransferFunctionPicture, AFlatCurveHasOneHeight) {
  TransferFunction function;
  function.points = {{-0.396845279, glm::dvec3(1), 0.9}, {0.312886089, glm::dvec3(1), 0.9}, {0.9, glm::dvec3(1), 0.9}};
  const Image picture = transferFunctionPicture(function, {0, 1, {1, 2, 3}});
  const auto firstRow = [&](int x) {
    for (int y = 0; y < 330; ++y) {
      if (has(picture.pixel(x, y), {0.80, 0.20, 0.10})) return y;
    }
    return -1;
  };
  ASSERT_GT(firstRow(56), 0);
  for (int x = 57; x < 936; ++x) ASSERT_EQ(firstRow(x), firstRow(56)) << x;
}

TEST(TransferFunctionPicture, AVolumeOfOneValueHasABar) {
  TransferFunction function;
  function.points = {{0, glm::dvec3(1), 0}, {10, glm::dvec3(1), 0}};
  const Image picture = transferFunctionPicture(function, {7, 7, {720}});
  int bars = 0;
  for (int x = 56; x < 936; ++x) bars += has(picture.pixel(x, 90), {0.72, 0.76, 0.80});
  EXPECT_GE(bars, 1);
}

}  // namespace
}  // namespace kiln::test
