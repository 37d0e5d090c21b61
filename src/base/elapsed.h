// Seconds since a point in time.
#pragma once

#include <chrono>

namespace kiln {

inline double secondsSince(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

}  // namespace kiln
