// Whether a sanitizer watches: it slows what is done tenfold and more, and keeps what is freed.
#pragma once

namespace kiln::test {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

/// `all`, or `few` where a sanitizer watches: it looks at what is done, not at how often.
constexpr auto casesOf(auto all, decltype(all) few) { return kSanitized ? few : all; }

}  // namespace kiln::test
