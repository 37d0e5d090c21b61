// Known answers: the values of CSS, decoded as sRGB.
#include "image/named_color.h"

#include <gtest/gtest.h>

#include <set>

#include "image/srgb.h"

namespace kiln {
namespace {

void expectSrgb(const char* text, int red, int green, int blue) {
  const auto color = colorNamed(text);
  ASSERT_TRUE(color) << text;
  EXPECT_EQ(*color, linearFromSrgb(glm::dvec3(red, green, blue) / 255.0)) << text;
}

TEST(NamedColor, NamesAndDigits_areSrgb) {
  expectSrgb("orange", 255, 165, 0);
  expectSrgb("Navy", 0, 0, 128);
  expectSrgb("grey", 128, 128, 128);
  expectSrgb("SkyBlue", 135, 206, 235);
  expectSrgb("rebeccapurple", 102, 51, 153);
  expectSrgb("aliceblue", 240, 248, 255);
  expectSrgb("yellowgreen", 154, 205, 50);
  expectSrgb("#f80", 255, 136, 0);
  expectSrgb("#FF8800", 255, 136, 0);
  expectSrgb("#0a0b0c", 10, 11, 12);
  EXPECT_EQ(colorNamed("white"), glm::dvec3(1));
  EXPECT_EQ(colorNamed("#000"), glm::dvec3(0));
  // Half of sRGB's range is 21.6 % of the light.
  EXPECT_NEAR(colorNamed("gray")->r, 0.21586, 1e-5);
}

TEST(NamedColor, OtherTexts_areNone) {
  for (const char* text : {"", "#", "#f", "#ff", "#ff88", "#ff880", "#ff88000", "#ggg", "#-ff", "#+ff", "# ff", "f80",
                           "oragne", "orange ", "1,0,0", "transparent"})
    EXPECT_FALSE(colorNamed(text)) << text;
}

TEST(NamedColor, EachNameOfTheList_isAColour) {
  EXPECT_EQ(colorNames().size(), 148u);
  std::set<std::string_view> names;
  for (const std::string_view name : colorNames()) {
    EXPECT_TRUE(colorNamed(name)) << name;
    EXPECT_TRUE(names.insert(name).second) << name;
  }
}

}  // namespace
}  // namespace kiln
