// Texts of numbers.
#include "base/number_text.h"

#include <gtest/gtest.h>

#include <limits>

namespace kiln {
namespace {

TEST(NumberText, HasTheDigitsOfTheStep) {
  EXPECT_EQ(numberText(101325.05, 0.05), "101325.05");
  EXPECT_EQ(numberText(101325.05, 0.1), "101325.1");
  EXPECT_EQ(numberText(-101325.05, 0.05), "-101325.05");
}

TEST(NumberText, HasSixDigitsElse) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(numberText(127.5, 0.255), "127.5");
  EXPECT_EQ(numberText(1 / 3.0, 10), "0.333333");
  EXPECT_EQ(numberText(0, 0.1), "0");
  EXPECT_EQ(numberText(101325.05, 0), "101325");
  EXPECT_EQ(numberText(-kInfinity, kInfinity), "-inf");
}

}  // namespace
}  // namespace kiln
