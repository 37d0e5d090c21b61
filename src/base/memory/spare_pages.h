// Sets the bound of the large pages that a process keeps for its next buffers (base/memory/large_pages.h).
#pragma once

#include <cstddef>

namespace kiln {

/// Sets the bound of spared memory, at most kMostSpare (the initial bound), and frees spared memory beyond it. unit:
/// bytes. thread: safe.
void boundSparePages(std::size_t bytes) noexcept;

}  // namespace kiln
