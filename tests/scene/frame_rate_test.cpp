// Rates of videos. Known because NTSC's rates are 1000/1001 of whole rates, by definition.
#include "scene/frame_rate.h"

#include <gtest/gtest.h>

namespace kiln::test {
namespace {

TEST(FrameRate, DecimalsOfNtsc_areItsFractions) {
  for (const char* text : {"23.976", "23.98", "23.976024", "23.976023976023978", "24000/1001"})
    EXPECT_EQ(frameRateFrom(text), (FrameRate{24000, 1001})) << text;
  EXPECT_EQ(frameRateFrom("29.97"), (FrameRate{30000, 1001}));
  EXPECT_EQ(frameRateFrom("59.94"), (FrameRate{60000, 1001}));
  EXPECT_EQ(frameRateFrom("119.88"), (FrameRate{120000, 1001}));
}

TEST(FrameRate, OtherDecimals_areWhatTheySay) {
  EXPECT_EQ(frameRateFrom("24"), (FrameRate{24, 1}));
  EXPECT_EQ(frameRateFrom("24.0"), (FrameRate{24, 1}));
  EXPECT_EQ(frameRateFrom("12.5"), (FrameRate{25, 2}));
  EXPECT_EQ(frameRateFrom("0.1"), (FrameRate{1, 10}));
  EXPECT_EQ(frameRateFrom("60/2"), (FrameRate{30, 1}));
  EXPECT_EQ(frameRateFrom("23.9"), (FrameRate{239, 10}));
  EXPECT_EQ((FrameRate{24, 1}.text()), "24");
  EXPECT_EQ((FrameRate{24000, 1001}.text()), "24000/1001");
}

TEST(FrameRate, WhatIsNoRate_isRefused) {
  for (const char* text : {"", "0", "-24", "24.", ".", "1001", "0.05", "24/0", "0/1", "24000/1001/1", "24fps", "nan",
                           "inf", "1e2", " 24", "24 ", "99999999999999999999", "1/99999999999999999999"})
    EXPECT_FALSE(frameRateFrom(text)) << text;
}

}  // namespace
}  // namespace kiln::test
