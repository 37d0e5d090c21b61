// The bound of the large pages that a process keeps for its next buffers (base/memory/large_pages.h).
#pragma once

#include <cstddef>

namespace kiln {

/// Sets how much spared memory the process keeps from now on, at most kMostSpare, which is the initial bound. Gives
/// back the rest. unit: bytes. thread: safe.
void boundSparePages(std::size_t bytes) noexcept;

}  // namespace kiln
