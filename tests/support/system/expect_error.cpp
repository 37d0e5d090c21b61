#include "support/system/expect_error.h"

#include <gtest/gtest.h>

namespace kiln::test {

void expectOneLine(const Error& error) {
  EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
  EXPECT_FALSE(std::string(error.what()).empty());
}

void expectError(const std::function<void()>& call, ErrorCode code, const std::string& part) {
  SCOPED_TRACE(part);
  try {
    call();
    ADD_FAILURE() << "no error";
  } catch (const Error& error) {
    expectOneLine(error);
    EXPECT_EQ(static_cast<int>(error.code()), static_cast<int>(code)) << error.what();
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
}

}  // namespace kiln::test
