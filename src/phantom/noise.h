// Noise as a function of voxel coordinates and a seed.
// Method. A hash of the coordinates; the sum of its four bytes approximates a normal distribution up to 3.4 sigma
// (Irwin-Hall).
// Invariant. Integer arithmetic only: a voxel has equal noise in any box, order and thread, and on any machine.
// Source: Steele et al., "Fast splittable pseudorandom number generators", 2014 (64-bit mixing, once per row); C.
// Wellons' search for low-bias 32-bit functions (lowbias32, once per voxel).
#pragma once

#include <cstdint>

namespace kiln::phantom {

/// The part of the hash that the voxels of a row share.
struct NoiseRow {
  std::uint32_t low = 0, high = 0;
};

inline std::uint64_t mixed64(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

inline NoiseRow noiseRow(std::uint64_t seed, std::int64_t y, std::int64_t z) {
  const std::uint64_t bits =
      mixed64(mixed64(mixed64(seed) + static_cast<std::uint64_t>(z)) + static_cast<std::uint64_t>(y));
  return {static_cast<std::uint32_t>(bits), static_cast<std::uint32_t>(bits >> 32)};
}

/// Sum of four random bytes: mean 510, standard deviation `kNoiseDeviation`.
inline std::uint32_t noiseSum(const NoiseRow& row, std::uint32_t x) {
  std::uint32_t h = x * 0x9e3779b9u + row.low;
  h = (h ^ (h >> 16)) * 0x21f0aaadu;
  h = (h ^ (h >> 15) ^ row.high) * 0xd35a2d97u;
  h ^= h >> 15;
  const std::uint32_t pairs = (h & 0x00ff00ffu) + ((h >> 8) & 0x00ff00ffu);
  return (pairs & 0xffffu) + (pairs >> 16);
}
inline constexpr float kNoiseMean = 510;
/// √(4 (256² - 1) / 12).
inline constexpr float kNoiseDeviation = 147.8005f;

}  // namespace kiln::phantom
