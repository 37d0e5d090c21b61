#include "base/module.h"

#include <gtest/gtest.h>

#include <string>

#include "base/error.h"

namespace kiln {
namespace {

// Known because the C library's `strlen` has a specified result.
TEST(Module, GivesAFunction) {
  const auto length =
      reinterpret_cast<std::size_t (*)(const char*)>(functionOfModule("libc.so.6", "strlen", "nothing has a length"));
  EXPECT_EQ(length("kiln"), 4u);
}

TEST(Module, SaysWhatIsNotThereAndWhatThatMeans) {
  try {
    functionOfModule("libkiln_none.so", "any", "pigs cannot fly");
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUnsupported);
    const std::string said = error.what();
    EXPECT_EQ(said.find("libkiln_none.so: cannot be loaded, so that pigs cannot fly ("), 0u) << said;
  }
  try {
    functionOfModule("libc.so.6", "kilnNone", "pigs cannot fly");
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()), "libc.so.6: belongs to another version of Kiln; reinstall Kiln");
  }
}

}  // namespace
}  // namespace kiln
