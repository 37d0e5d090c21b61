// Repeats system calls that a signal interrupts, as network and user-space file systems let signals do.
#pragma once

#include <cerrno>

namespace kiln {

/// Returns the call's result once it is no EINTR. requires: the call returns a number below 0 where it fails, and sets
/// errno.
template <class Call>
auto uninterrupted(const Call& call) {
  auto result = call();
  while (result < 0 && errno == EINTR) result = call();
  return result;
}

}  // namespace kiln
