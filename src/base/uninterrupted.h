// Repeats system calls interrupted by a signal; network and user-space file systems allow such interrupts.
#pragma once

#include <cerrno>

namespace kiln {

/// Repeats the call until it does not fail with EINTR, and returns its result. requires: the call returns a negative
/// number and sets errno on failure.
template <class Call>
auto uninterrupted(const Call& call) {
  auto result = call();
  while (result < 0 && errno == EINTR) result = call();
  return result;
}

}  // namespace kiln
