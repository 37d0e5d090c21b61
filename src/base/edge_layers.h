// What lies in the pixels of a partial image that slabs cover only in part, slab by slab: what is behind it in the
// whole picture is seen beside these slabs as well as through them, and how much of it is a matter of all of them
// (splat/coverage.h). Where a slab has covered all of a pixel, what follows is laid over one another as ever, and is
// one layer. A pixel that its first slab covers has no layers: its colour says everything.
#pragma once

#include <array>
#include <atomic>

#include "base/pixel_lists.h"

namespace kiln {

/// A slab, or several that lie behind one which covers all of the pixel. What is in front of it lets `seen` of the
/// pixel's area see it: it adds seen × rgba.
struct EdgeLayer {
  float part = 0;               // of the pixel's area that it covers
  std::array<float, 4> rgba{};  // premultiplied
};

class EdgeLayers {
 public:
  /// From so much on, a slab covers all of a pixel.
  static constexpr float kWhole = 0.998f;
  /// A scan's picture needs a fifth to a half of a layer a pixel; what is translucent and ragged all over, ten and
  /// more.
  static constexpr std::uint64_t kLeastPixelBytes = 64, kMostPixelBytes = 1024;

  /// Of the pixels of `rect`; layers take `pixel_bytes` for each of them, at most.
  explicit EdgeLayers(const PixelRect& rect, std::uint64_t pixel_bytes = kMostPixelBytes);
  /// All that so many pixels take, at most. unit: bytes.
  static std::uint64_t bytesFor(std::uint64_t pixels, std::uint64_t pixel_bytes);

  const PixelRect& rect() const { return lists_.rect(); }
  /// A slab behind all that the pixel holds, which has `alpha_in_front`. thread: as PixelLists::append.
  void add(int x, int y, EdgeLayer slab, float alpha_in_front);
  /// A layer as another of these objects has it.
  void put(int x, int y, const EdgeLayer& layer);
  int count(int x, int y) const { return lists_.count(x, y); }
  /// Calls f(layer) from front to back.
  template <class F>
  void forEach(int x, int y, F f) const {
    lists_.forEach(x, y, [&](const EdgeLayer& layer) { f(layer); });
  }
  /// Whether there were more layers than there is room for, so that some tell of several as if they were one.
  bool incomplete() const { return incomplete_.load(std::memory_order_relaxed); }

 private:
  PixelLists<EdgeLayer> lists_;
  std::atomic<bool> incomplete_ = false;
};

/// Lays a layer behind what a pixel holds, as slabs are laid when they are drawn (splat/lay_sheet.cpp). `covered`: what
/// of the pixel's area is covered by then, and after. `pixel`: premultiplied RGBA; not divided by its alpha where that
/// reaches the threshold.
void layBehind(const EdgeLayer& layer, float* pixel, float& covered);

}  // namespace kiln
