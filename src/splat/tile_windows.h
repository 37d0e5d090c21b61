// A tile as footprints see it. A window is a place where a footprint may lie and touch the tile, all of the same size;
// windows are counted from the one whose last pixel is the tile's first. Of each is known which blocks of the tile it
// touches, and whether every pixel of the tile in it is closed, which costs a bit to ask and few words to keep: the
// answer of the mask (occlusion/mask.cpp), for the one rectangle that each sample asks about.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/pixel_rect.h"
#include "splat/splat_cell.h"

namespace kiln {

/// The edge of what is swept at a time, at most. unit: pixels.
inline constexpr int kSweepEdge = 128;

/// The blocks of a tile, at most 8×8: block 8 y + x, counted from the tile's corner, is one bit of a word.
class TileBlocks {
 public:
  explicit TileBlocks(const PixelRect& tile)
      : tile_(tile), shift_(std::max(tile.width(), tile.height()) > kSweepEdge / 2 ? 4 : 3) {}
  int edge() const { return 1 << shift_; }
  int shift() const { return shift_; }
  PixelRect rectOf(int block) const {
    const int x = tile_.x0 + ((block & 7) << shift_), y = tile_.y0 + (block >> 3 << shift_);
    return intersection({x, y, x + edge(), y + edge()}, tile_);
  }

 private:
  PixelRect tile_;
  int shift_;
};

/// Where a sample's footprint lies, packed: a sample waits with it. unit: pixels; phases of a pixel.
struct FootprintPlace {
  static constexpr int kPhases = 64;
  static constexpr std::int32_t kCounted = 1 << 16;
  std::int32_t window;  // x + 2^16 y
  std::int32_t phases;  // x + 2^8 y, and kCounted where the sample counts

  int x() const { return window & 0xffff; }
  int y() const { return window >> 16; }
  int phaseX() const { return phases & 0xff; }
  int phaseY() const { return phases >> 8 & 0xff; }
  bool counted() const { return (phases & kCounted) != 0; }
};

class TileWindows {
 public:
  /// Of footprints of `taps` pixels along an axis. requires: the tile's edges are at most kSweepEdge, taps < 2^15.
  void reset(const TilePixels& tile, int taps);
  /// The window of the tile's corner is this many pixels after the first, along each axis.
  int before() const { return taps_ - 1; }
  /// Along each axis.
  int columns() const { return width_ + taps_ - 1; }
  int rows() const { return height_ + taps_ - 1; }
  /// The blocks that the window touches: a bit each, see TileBlocks.
  std::uint64_t blocks(const FootprintPlace& at) const {
    return columns_[static_cast<std::size_t>(at.x())] & rows_[static_cast<std::size_t>(at.y())];
  }
  /// Whether a pixel in it was open when `update` was last called.
  bool open(const FootprintPlace& at) const {
    return (openWords()[at.y() * stride_ + (at.x() >> 5)] >> (at.x() & 31) & 1) != 0;
  }
  /// The same: bit x & 31 of word y stride + x / 32. So many words before and after them may be read, too.
  static constexpr int kWordsBeside = 8;
  const std::int32_t* openWords() const { return open_.data() + kWordsBeside; }
  int stride() const { return stride_; }
  /// Pixel (x, y), counted from the tile's corner, is closed: `update` then tells the windows.
  void close(int x, int y) {
    pixels_[static_cast<std::size_t>(2 * y + (x >> 6))] &= ~(std::uint64_t{1} << (x & 63));
    first_closed_ = y < first_closed_ ? y : first_closed_;
    last_closed_ = y > last_closed_ ? y : last_closed_;
  }
  void update();
  /// Of pixels (x, y) to (x + 15, y), those that are open: a bit each. requires: x a multiple of 8.
  unsigned openPixels(int x, int y) const {
    return static_cast<unsigned>(pixels_[static_cast<std::size_t>(2 * y + (x >> 6))] >> (x & 63) & 0xffff);
  }
  /// unit: bytes.
  std::size_t bytes() const;

 private:
  void updateRow(int window);

  int width_ = 0, height_ = 0, taps_ = 1, stride_ = 0;
  int first_closed_ = kSweepEdge, last_closed_ = -1;  // since the last update
  std::vector<std::uint64_t> columns_, rows_;
  std::vector<std::uint64_t> pixels_;  // open ones: bit x & 63 of word 2 y + x / 64
  std::vector<std::int32_t> open_;
};

}  // namespace kiln
