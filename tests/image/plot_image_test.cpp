// Pictures with text. Known answers: sizes by the glyphs' 5 x 7 pixels, colours by the definition of "over".
#include "image/plot_image.h"

#include <gtest/gtest.h>

#include "image/srgb.h"

namespace kiln {
namespace {

const glm::dvec3 kBlack(0), kWhite(1);

int inked(const PlotImage& plot) {
  int out = 0;
  for (int y = 0; y < plot.image().height; ++y) {
    for (int x = 0; x < plot.image().width; ++x) out += plot.image().pixel(x, y)[0] > 0.5f ? 1 : 0;
  }
  return out;
}

TEST(PlotImage, Text_hasTheSizeOfItsGlyphs) {
  EXPECT_EQ(PlotImage::textWidth("abc"), 17);
  EXPECT_EQ(PlotImage::textWidth("abc", 2), 34);
  EXPECT_EQ(PlotImage::textWidth(""), 0);
  EXPECT_EQ(PlotImage::textHeight(2), 14);
}

// "|" is a column of seven pixels, "_" a row of five.
TEST(PlotImage, Glyphs_areInk) {
  PlotImage plot(20, 10, kBlack);
  plot.text(1, 1, "|", kWhite);
  EXPECT_EQ(inked(plot), 7);
  plot.text(7, 1, "_", kWhite);
  EXPECT_EQ(inked(plot), 12);
  PlotImage large(20, 20, kBlack);
  large.text(0, 0, "|", kWhite, 2);
  EXPECT_EQ(inked(large), 28);
}

TEST(PlotImage, EveryCharacterButBlank_isDifferent) {
  std::vector<std::vector<float>> seen;
  for (char c = ' '; c <= '~'; ++c) {
    PlotImage plot(5, 7, kBlack);
    plot.text(0, 0, std::string(1, c), kWhite);
    std::vector<float> pixels(plot.image().rgba.data(), plot.image().rgba.data() + 5 * 7 * 4);
    EXPECT_EQ(inked(plot) == 0, c == ' ') << c;
    EXPECT_EQ(std::count(seen.begin(), seen.end(), pixels), 0) << c;
    seen.push_back(std::move(pixels));
  }
}

TEST(PlotImage, WhatLiesOutside_isCutOff) {
  PlotImage plot(10, 10, kBlack);
  plot.text(-3, -3, "@@@@", kWhite, 3);
  plot.fill({-5, 8, 50, 50}, kWhite);
  plot.draw(Image(30, 30), -10, 5);
  EXPECT_EQ(plot.image().pixel(9, 9)[0], 1.0f);
}

TEST(PlotImage, Picture_isLaidOver) {
  PlotImage plot(4, 4, {0.5, 0.5, 0.5});
  Image half(1, 1);
  half.pixel(0, 0)[0] = 0.25f;
  half.pixel(0, 0)[3] = 0.5f;
  plot.draw(half, 2, 1);
  const auto grey = static_cast<float>(linearFromSrgb(128 / 255.0));  // the nearest byte
  EXPECT_FLOAT_EQ(plot.image().pixel(2, 1)[0], 0.25f + 0.5f * grey);
  EXPECT_FLOAT_EQ(plot.image().pixel(2, 1)[1], 0.5f * grey);
  EXPECT_FLOAT_EQ(plot.image().pixel(2, 1)[3], 1.0f);
  EXPECT_FLOAT_EQ(plot.image().pixel(1, 1)[0], grey);
}

}  // namespace
}  // namespace kiln
