// Known: the formula of the tone curve, and a picture of few colours shown by hand.
#include "image/display.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace kiln {
namespace {

TEST(Display, SoftTone_isTheLightBelowTheKneeAndStaysBelowWhite) {
  for (const double light : {0.0, 1e-6, 0.3, 0.7}) EXPECT_EQ(softTone(light), light);
  EXPECT_DOUBLE_EQ(softTone(1), 0.85);     // s = 1
  EXPECT_DOUBLE_EQ(softTone(1.6), 0.925);  // s = 3
  double before = 0;
  for (double light = 1e-3; light < 1e9; light *= 1.01) {
    const double shown = softTone(light);
    EXPECT_GT(shown, before) << light;
    EXPECT_LE(shown, 1) << light;
    before = shown;
  }
  const double h = 1e-7;
  EXPECT_NEAR((softTone(kToneKnee + h) - softTone(kToneKnee)) / h, 1, 1e-5);
}

// Pixels: transparent; dim and half covered; beyond white and half covered; red beyond white.
Image picture() {
  Image out(2, 2);
  const float rgba[] = {0, 0, 0, 0, 0.05f, 0.1f, 0.025f, 0.5f, 0.5f, 0.25f, 0.125f, 0.5f, 1.6f, 0.8f, 0, 1};
  std::copy(std::begin(rgba), std::end(rgba), out.rgba.begin());
  return out;
}

TEST(Display, AsDrawn_changesNoBit) {
  Image shown = picture();
  show({}, shown);
  EXPECT_EQ(shown.rgba, picture().rgba);
}

TEST(Display, Exposure_multipliesColoursAndKeepsAlpha) {
  Image shown = picture();
  show({.exposure = 1}, shown);
  const Image drawn = picture();
  for (std::size_t i = 0; i < shown.rgba.size(); ++i) EXPECT_EQ(shown.rgba[i], drawn.rgba[i] * (i % 4 == 3 ? 1 : 2));
}

TEST(Display, SoftTone_ofAColour_keepsItsHue) {
  Image shown = picture();
  show({.tone = Tone::kSoft}, shown);
  const Image drawn = picture();
  // The dim colour is 0.2 at most, after division by alpha: below the knee.
  for (int channel = 0; channel < 4; ++channel) EXPECT_EQ(shown.pixel(1, 0)[channel], drawn.pixel(1, 0)[channel]);
  // 1, 0.5, 0.25 at half coverage becomes 0.85, 0.425, 0.2125; 1.6, 0.8, 0 becomes 0.925, 0.4625, 0.
  const float half[] = {0.425f, 0.2125f, 0.10625f, 0.5f}, red[] = {0.925f, 0.4625f, 0, 1};
  for (int channel = 0; channel < 4; ++channel) {
    EXPECT_NEAR(shown.pixel(0, 1)[channel], half[channel], 1e-6);
    EXPECT_NEAR(shown.pixel(1, 1)[channel], red[channel], 1e-6);
  }
}

}  // namespace
}  // namespace kiln
