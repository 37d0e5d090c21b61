// The known word that a misspelt one probably means. Known because edits are counted by hand.
#include "base/nearest_word.h"

#include <gtest/gtest.h>

namespace kiln::test {
namespace {

constexpr std::string_view kWords[] = {"azimuth", "elevation", "zoom", "fov"};

TEST(NearestWord, HasTheFewestEdits) {
  EXPECT_EQ(nearestWord("azimut", kWords), "azimuth");
  EXPECT_EQ(nearestWord("zom", kWords), "zoom");
  EXPECT_EQ(nearestWord("elevations", kWords), "elevation");
}

TEST(NearestWord, MeantWord_isBegunExceededOrHasFewEdits) {
  EXPECT_EQ(meantWord("ele", kWords), "elevation");
  EXPECT_EQ(meantWord("zoom-of-the-eye", kWords), "zoom");
  EXPECT_EQ(meantWord("fvo", kWords), "fov");          // two letters of three
  EXPECT_EQ(meantWord("alimats", kWords), "azimuth");  // three letters of seven
  EXPECT_EQ(meantWord("blimats", kWords), std::nullopt);
  EXPECT_EQ(meantWord("", kWords), std::nullopt);
  EXPECT_EQ(meantWord("zoom", {}), std::nullopt);
  EXPECT_EQ(meantWordHint("zom", kWords), "; did you mean 'zoom'?");
  EXPECT_EQ(meantWordHint("quux", kWords), "");
}

}  // namespace
}  // namespace kiln::test
