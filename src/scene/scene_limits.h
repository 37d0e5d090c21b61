// Upper bounds for lists in a job. Each sample is tested against all lights and planes, each frame against all keys, so
// a job with many more would never finish.
#pragma once

#include <cstddef>

namespace kiln {

/// Greatest value and gradient in options: differences of values are finite.
inline constexpr double kLargestValue = 1e300;
inline constexpr std::size_t kMostLights = 64;
inline constexpr int kMostShadowEdge = 4096;        // a map of so many pixels along each side has 1 GiB
inline constexpr std::size_t kMostClipPlanes = 64;  // beside the six planes of a region in the world
inline constexpr std::size_t kMostVolumesOfJob = 64;
inline constexpr std::size_t kMostOutputs = 64;  // additional files of each frame
inline constexpr std::size_t kMostKeys = 10'000;
inline constexpr std::size_t kMostMatrices = 100'000;  // one per frame: an hour of film
inline constexpr std::size_t kMostPoints = 65'536;     // one per 16-bit value
inline constexpr std::size_t kMostRegions = 64;
inline constexpr int kMostTableEdge = 4096;
inline constexpr std::size_t kMostTableNodes = std::size_t{1} << 22;
inline constexpr std::size_t kMostIsoSurfaces = 32;  // each sample is compared with all
inline constexpr std::size_t kMostLabelLooks = 65'536;
inline constexpr std::size_t kMostMaskLabels = 65'536;

}  // namespace kiln
