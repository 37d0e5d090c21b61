// Known because each exception is made here as the library throws it.
#include "base/refusal.h"

#include <gtest/gtest.h>

#include <cerrno>
#include <new>
#include <stdexcept>
#include <system_error>

#include "base/error.h"

namespace kiln::test {
namespace {

TEST(Refusal, IsKnownByTypeAndByMessage) {
  EXPECT_EQ(refusalOf(std::bad_alloc()), Refusal::kMemory);
  EXPECT_EQ(refusalOf(std::bad_array_new_length()), Refusal::kMemory);
  EXPECT_EQ(refusalOf(std::system_error(ENOMEM, std::generic_category())), Refusal::kMemory);
  EXPECT_EQ(refusalOf(std::system_error(EAGAIN, std::generic_category())), Refusal::kThreads);
  EXPECT_EQ(refusalOf(std::runtime_error("pthread_create has failed: Resource temporarily unavailable")),
            Refusal::kThreads);
  EXPECT_EQ(refusalOf(std::runtime_error("std::bad_alloc")), Refusal::kMemory);
  EXPECT_EQ(refusalOf(std::system_error(EIO, std::generic_category())), Refusal::kNone);
  EXPECT_EQ(refusalOf(std::runtime_error("LZ4 failed")), Refusal::kNone);
  EXPECT_EQ(refusalOf(Error(ErrorCode::kDamaged, "a.vdb: is damaged")), Refusal::kNone);
}

template <class Thrown>
void handle(const Thrown& thrown) {
  try {
    throw thrown;
  } catch (const std::exception&) {
    rethrowRefusal();
  }
}

TEST(Refusal, PassesWhereOtherExceptionsAreTranslated) {
  EXPECT_THROW(handle(std::bad_alloc()), std::bad_alloc);
  EXPECT_THROW(handle(std::system_error(EAGAIN, std::generic_category())), std::system_error);
  EXPECT_NO_THROW(handle(std::runtime_error("LZ4 failed")));
}

}  // namespace
}  // namespace kiln::test
