// Known answers: two constant pictures that differ by 0.1 everywhere have a mean square of 0.01, or 20 dB. The colours
// of the map are in the caption of Lee and Ihm's Figure 11.
#include "image/compare.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "base/error.h"
#include "image/srgb.h"
#include "support/system/expect_error.h"

namespace kiln {
namespace {

Image filled(int width, int height, std::array<float, 4> rgba) {
  Image image(width, height);
  for (std::size_t i = 0; i < image.rgba.size(); ++i) image.rgba[i] = rgba[i % 4];
  return image;
}

float light(int srgb) { return static_cast<float>(linearFromSrgb(srgb / 255.0)); }

TEST(Compare, EqualPicturesAreInfinitelyAlike) {
  const Image a = filled(3, 2, {0.1f, 0.2f, 0.3f, 0.4f});
  const ImageDifference d = compareImages(a, a);
  EXPECT_TRUE(std::isinf(d.psnr_db) && d.psnr_db > 0);
  EXPECT_TRUE(std::isinf(d.foreground_psnr_db));
  EXPECT_EQ(d.largest, 0);
  EXPECT_EQ(d.differing, 0u);
  EXPECT_EQ(d.foreground, 6u);
  EXPECT_EQ(d.mean_brightness_ratio, 1);
}

TEST(Compare, ATenthEverywhereIsTwentyDecibel) {
  const ImageDifference d =
      compareImages(filled(4, 4, {0.5f, 0.5f, 0.5f, 0.5f}), filled(4, 4, {0.6f, 0.6f, 0.6f, 0.6f}));
  EXPECT_NEAR(d.psnr_db, 20, 1e-5);
  EXPECT_NEAR(d.foreground_psnr_db, 20, 1e-5);
  EXPECT_NEAR(d.largest, 0.1, 1e-6);
  EXPECT_EQ(d.differing, 16u);
  EXPECT_NEAR(d.mean_brightness_ratio, 1.2, 1e-6);
}

// Of 100 pixels a single foreground pixel is off by 0.1 in RGB: 20 dB there; over all 400 channels 0.03 / 400, or 41.2
// dB.
TEST(Compare, ForegroundIsWhereEitherAlphaIs) {
  Image a(10, 10), b(10, 10);
  for (int c = 0; c < 4; ++c) a.pixel(3, 4)[c] = b.pixel(3, 4)[c] = 0.5f;
  for (int c = 0; c < 3; ++c) b.pixel(3, 4)[c] = 0.6f;
  a.pixel(0, 0)[3] = 0.001f;  // below 1/255: still background
  const ImageDifference d = compareImages(a, b);
  EXPECT_EQ(d.foreground, 1u);
  EXPECT_EQ(d.differing, 2u);
  EXPECT_NEAR(d.foreground_psnr_db, 20, 1e-5);
  EXPECT_NEAR(d.psnr_db, -10 * std::log10(0.03 / 400), 1e-3);
}

TEST(Compare, NothingButBackgroundIsAlike) {
  const ImageDifference d = compareImages(Image(4, 4), Image(4, 4));
  EXPECT_EQ(d.foreground, 0u);
  EXPECT_TRUE(std::isinf(d.foreground_psnr_db));
  EXPECT_EQ(d.mean_brightness_ratio, 1);
}

TEST(Compare, ANanAgainstANumberIsADifference) {
  Image a = filled(2, 1, {0, 0, 0, 1});
  const Image b = a;
  a.rgba[0] = std::nanf("");
  EXPECT_TRUE(std::isinf(compareImages(a, b).largest));
  EXPECT_EQ(compareImages(a, a).differing, 0u);
  EXPECT_EQ(compareImages(a, a).mean_brightness_ratio, 1);
}

TEST(Compare, RefusesUnequalSizes) {
  test::expectError([&] { compareImages(Image(2, 3), Image(3, 2)); }, ErrorCode::kUsage, "2x3");
  EXPECT_THROW(differenceImage(Image(2, 3), Image(3, 2)), Error);
}

// Red differs by 0 … 9 steps of 255: the distance is this number, and the map's colours are at the integers.
TEST(DifferenceImage, HasTheColoursOfThePaper) {
  const int map[10][3] = {{255, 255, 255}, {255, 255, 0}, {0, 255, 0},     {0, 255, 255}, {0, 0, 255},
                          {255, 0, 255},   {255, 0, 0},   {128, 128, 128}, {0, 0, 0},     {0, 0, 0}};
  for (int distance = 0; distance < 10; ++distance) {
    const Image d = differenceImage(filled(1, 1, {light(100), light(50), light(20), 1}),
                                    filled(1, 1, {light(100 + distance), light(50), light(20), 1}));
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(255 * srgbFromLinear(d.pixel(0, 0)[c]), map[distance][c], 0.51) << distance << " " << c;
    }
    EXPECT_EQ(d.pixel(0, 0)[3], 1);
  }
}

// Red differs by 0, 1, 3 and 200 steps, and a 3-4 right triangle: each falls into the bin that ends at its distance.
TEST(DistanceHistogram, CountsPixelsByTheirDistance) {
  Image a(5, 1), b(5, 1);
  const int apart[5][2] = {{0, 0}, {1, 0}, {3, 0}, {200, 0}, {3, 4}};
  for (int x = 0; x < 5; ++x) {
    for (int c = 0; c < 2; ++c) {
      a.pixel(x, 0)[c] = light(10);
      b.pixel(x, 0)[c] = light(10 + apart[x][c]);
    }
  }
  DistanceHistogram histogram = distanceHistogram(a, b);
  EXPECT_EQ(histogram.pixels, (std::array<std::uint64_t, 10>{1, 1, 0, 1, 0, 1, 0, 0, 0, 1}));
  EXPECT_EQ(histogram.largest, 200);
  histogram.add(distanceHistogram(a, a));
  EXPECT_EQ(histogram.pixels[0], 6u);
  EXPECT_EQ(histogram.largest, 200);
  EXPECT_THROW(distanceHistogram(Image(2, 3), Image(3, 2)), Error);
}

// 3-4 right triangle: a distance of 5 over two channels is magenta.
TEST(DifferenceImage, DistanceIsEuclidean) {
  const Image d =
      differenceImage(filled(1, 1, {light(100), light(100), 0, 1}), filled(1, 1, {light(103), light(104), 0, 1}));
  EXPECT_NEAR(d.pixel(0, 0)[0], 1, 1e-6);
  EXPECT_NEAR(d.pixel(0, 0)[1], 0, 1e-6);
  EXPECT_NEAR(d.pixel(0, 0)[2], 1, 1e-6);
}

}  // namespace
}  // namespace kiln
