// True under a sanitizer, which slows code tenfold or more and keeps freed memory.
#pragma once

namespace kiln::test {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

/// Returns `all`, or `few` under a sanitizer, which checks operations, not their number.
constexpr auto casesOf(auto all, decltype(all) few) { return kSanitized ? few : all; }

}  // namespace kiln::test
