#include "splat/join_volumes.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace kiln {
namespace {

struct Filling {
  std::size_t volume = 0;
  double filled = 0;  // unit: the sheet's
  double clear = 1;   // what its material lets through
  double depth = 0;   // its optical depth, of a whole slab
  double color[3] = {};
};

Filling fillingOf(const VolumeBlock& block, std::ptrdiff_t pixel, std::size_t volume) {
  // Samples are opaque to 0.9999; a float's rounding must not make them more.
  constexpr double kLeastClear = 1e-6;
  Filling out;
  out.volume = volume;
  out.filled = block.filled[pixel];
  const std::int32_t* const sums = block.sums + 4 * pixel;
  if (sums[3] <= 0) return out;
  out.clear = std::max(1 - sums[3] / out.filled, kLeastClear);
  out.depth = -std::log(out.clear);
  for (int c = 0; c < 3; ++c) out.color[c] = static_cast<double>(sums[c]) / sums[3];
  return out;
}

void joinPixel(std::span<const VolumeBlock> blocks, std::ptrdiff_t pixel, std::span<Filling> fillings) noexcept {
  // From the one that fills most; the order of equal ones is that of the volumes.
  std::stable_sort(fillings.begin(), fillings.end(),
                   [](const Filling& a, const Filling& b) { return a.filled > b.filled; });
  double light[4] = {}, clear = 1, depth = 0, color[3] = {}, opacities = 0, aovs[4] = {};
  for (std::size_t i = 0; i < fillings.size(); ++i) {
    const Filling& f = fillings[i];
    clear *= f.clear;
    depth += f.depth;
    for (int c = 0; c < 3; ++c) color[c] += f.depth * f.color[c];
    // What the first ones fill, and the next do not.
    const double part = f.filled - (i + 1 < fillings.size() ? fillings[i + 1].filled : 0);
    const double opacity = part * (1 - clear);
    for (int c = 0; c < 3 && depth > 0; ++c) light[c] += opacity * color[c] / depth;
    light[3] += opacity;
    const VolumeBlock& block = blocks[f.volume];
    opacities += block.sums[4 * pixel + 3];
    for (int k = 0; k < 4 && block.aovs != nullptr; ++k) aovs[k] += block.aovs[4 * pixel + k];
  }
  for (const Filling& f : fillings) {
    const VolumeBlock& block = blocks[f.volume];
    block.filled[pixel] = 0;
    std::fill_n(block.sums + 4 * pixel, 4, 0);
    if (block.aovs != nullptr) std::fill_n(block.aovs + 4 * pixel, 4, 0);
  }
  const VolumeBlock& most = blocks[fillings.front().volume];
  most.filled[pixel] = static_cast<std::int32_t>(fillings.front().filled);
  for (int k = 0; k < 4; ++k) most.sums[4 * pixel + k] = static_cast<std::int32_t>(std::lrint(light[k]));
  for (int k = 0; k < 4 && most.aovs != nullptr && opacities > 0; ++k)
    most.aovs[4 * pixel + k] = static_cast<std::int32_t>(std::lrint(aovs[k] * light[3] / opacities));
}

}  // namespace

void joinVolumes(std::span<const VolumeBlock> blocks, std::ptrdiff_t columns, int width, int height) noexcept {
  std::array<Filling, kMostVolumes> fillings;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const std::ptrdiff_t pixel = y * columns + x;
      std::size_t count = 0;
      for (const VolumeBlock& block : blocks) count += block.filled[pixel] > 0 ? 1 : 0;
      if (count < 2) continue;
      count = 0;
      for (std::size_t v = 0; v < blocks.size(); ++v) {
        if (blocks[v].filled[pixel] > 0) fillings[count++] = fillingOf(blocks[v], pixel, v);
      }
      joinPixel(blocks, pixel, std::span(fillings).first(count));
    }
  }
}

}  // namespace kiln
