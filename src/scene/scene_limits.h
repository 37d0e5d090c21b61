// The most things of a kind in one job. Each sample is tested against all lights and planes, each frame against all
// keys, so that a job with many more would never end; a list in a file has an end that a reader sees.
#pragma once

#include <cstddef>

namespace kiln {

inline constexpr std::size_t kMostLights = 64;
inline constexpr std::size_t kMostClipPlanes = 64;  // beside the six of a region in the world
inline constexpr std::size_t kMostVolumesOfJob = 64;
inline constexpr std::size_t kMostOutputs = 64;  // more files of each frame
inline constexpr std::size_t kMostKeys = 10'000;
inline constexpr std::size_t kMostMatrices = 100'000;  // one a frame: an hour of film
inline constexpr std::size_t kMostPoints = 65'536;     // one a value of 16 bits
inline constexpr std::size_t kMostLabelLooks = 262'144;

}  // namespace kiln
