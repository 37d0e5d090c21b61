// The most things of a kind in one picture. Each sample is tested against all of them, so that a job with many more
// would never end; a list in a file has an end that a reader sees.
#pragma once

#include <cstddef>

namespace kiln {

inline constexpr std::size_t kMostLights = 64;
inline constexpr std::size_t kMostClipPlanes = 64;  // beside the six of a region in the world

}  // namespace kiln
