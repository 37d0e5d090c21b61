// What several volumes put into one slab, made one: where they overlap, their extinctions add up, and light comes from
// each as much as it absorbs. As slabs behind each other do (splat/coverage.h), what one fills of a pixel is taken to
// contain, or to be a part of, what the others fill.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace kiln {

/// A block of a volume's sheet. shape: of `sums` and `aovs` four numbers a pixel.
struct VolumeBlock {
  std::int32_t* sums = nullptr;
  std::int32_t* filled = nullptr;
  std::int32_t* aovs = nullptr;  // null where there are none
};

/// Each pixel that several volumes fill goes to the block of that which fills the most, and is empty in the others; the
/// others' pixels stay as they are, bit for bit. shape: `width` × `height` pixels, rows `columns` pixels apart.
/// requires: at most kMostVolumes blocks, in an order that nothing but the scene decides.
void joinVolumes(std::span<const VolumeBlock> blocks, std::ptrdiff_t columns, int width, int height) noexcept;
inline constexpr std::size_t kMostVolumes = 64;

}  // namespace kiln
