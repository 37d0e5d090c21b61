// Values that a store or its pictures cannot have: the conversion says so. Known because the files are written here.
#include <gtest/gtest.h>

#include <cstring>

#include "support/system/tool_test.h"

namespace kiln::test {
namespace {

class ValueLoss : public ToolTest {
 protected:
  ValueLoss() : ToolTest("value_loss_") {}
  // Returns standard error of converting a volume of two voxels.
  template <class T>
  std::string converted(T first, T second, const std::string& type, const std::string& option) const {
    const T values[] = {first, second};
    std::string bytes(sizeof values, '\0');
    std::memcpy(bytes.data(), values, sizeof values);
    writeText(in("v.raw"), bytes);
    return done({"convert", in("v.raw"), in("v.kiln"), "--dims", "2,1,1", "--orient", "LPS", "--type", type, option,
                 "--overwrite"})
        .err;
  }
};

TEST_F(ValueLoss, OfHalvesBeyondTheirRange_isWarnedOf) {
  EXPECT_NE(converted<float>(1, -70000, "f32", "--half")
                .find("v.kiln: --half: values beyond 65504 became 65504 (found magnitudes up to 70000)"),
            std::string::npos);
  EXPECT_NE(converted<float>(0, 1e-9f, "f32", "--half").find("v.kiln: --half: all values became 0"), std::string::npos);
  EXPECT_NE(converted<std::uint16_t>(1, 65535, "u16", "--half").find("values beyond 65504"), std::string::npos);
  // The nearest half of 65519 is the largest half; one value of two becomes 0; a volume of zeros loses nothing.
  EXPECT_EQ(converted<float>(1, 65519, "f32", "--half"), "");
  EXPECT_EQ(converted<float>(1, 1e-9f, "f32", "--half"), "");
  EXPECT_EQ(converted<float>(0, 0, "f32", "--half"), "");
}

// Known because a half next to 0.3 is 0.300048828125.
TEST_F(ValueLoss, OfHalves_hasABackgroundAmongTheirValues) {
  const float values[] = {0.3f, 0.3f, 1};
  writeText(in("f.raw"), std::string(reinterpret_cast<const char*>(values), sizeof values));
  done({"convert", in("f.raw"), in("f.kiln"), "--dims", "3,1,1", "--orient", "LPS", "--type", "f32"});
  done({"export", in("f.kiln"), in("f.vdb"), "--background", "0.3"});
  done({"convert", in("f.vdb"), in("h.kiln"), "--half"});
  EXPECT_NE(done({"info", in("h.kiln")}).out.find("background 0.300049"), std::string::npos);
}

TEST_F(ValueLoss, OfLabelsBeyondTheLargestDrawn_isWarnedOf) {
  EXPECT_NE(converted<std::uint32_t>(1, 4294967295u, "u32", "--labels")
                .find("v.kiln: labels above 8388608 cannot be drawn (largest found: 4294967295)"),
            std::string::npos);
  EXPECT_NE(converted<std::int32_t>(-8388609, 5, "i32", "--labels")
                .find("v.kiln: labels below -8388608 cannot be drawn (smallest found: -8388609)"),
            std::string::npos);
  EXPECT_EQ(converted<std::uint32_t>(1, 8388608, "u32", "--labels"), "");
}

}  // namespace
}  // namespace kiln::test
