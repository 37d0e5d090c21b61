// Noise from a counter: the noise of a voxel is a hash of its coordinates and a seed, so that it is the same in
// whatever box, order or thread the voxel is computed. The sum of the hash's four bytes is the normal distribution's
// shape to 3.4 sigma (Irwin-Hall), by whole-number arithmetic alone: the same bits on every machine. Source of the
// mixing steps: Steele et al., "Fast splittable pseudorandom number generators", 2014 (64 bits, once a row); C.
// Wellons' search for low-bias 32-bit functions (lowbias32, a voxel).
#pragma once

#include <cstdint>

namespace kiln::phantom {

/// What the voxels of one row have in common.
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

/// The sum of four random bytes: mean 510, standard deviation `kNoiseDeviation`.
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
