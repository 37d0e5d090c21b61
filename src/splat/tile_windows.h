// A tile as footprints see it. A window is a place where a footprint may lie and touch the tile, all of the same size;
// windows are counted from the one whose last pixel is the tile's first. Of each is known which blocks of the tile it
// touches, and whether every pixel of the tile in it is closed, which costs a bit to ask and few words to keep: the
// answer of the mask (occlusion/mask.cpp), for the one rectangle that each sample asks about.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "splat/splat_cell.h"

namespace kiln {

/// The edge of what is swept at a time, at most: a row is a word. unit: pixels.
inline constexpr int kSweepEdge = 64;

/// The edge of a block of the tile; there are at most 8×8. unit: pixels.
inline constexpr int kBlockEdge = 8;

/// Footprints of more pixels along an axis, as samples of very large voxels have, are clipped to the tile before they
/// are added to it, and the tile's windows are all open as long as one pixel is: what is kept for them does not grow
/// with them. unit: pixels.
inline constexpr int kMostWholeTaps = 32;

/// Where a sample's footprint lies, packed: a sample waits with it. unit: pixels; phases of a pixel.
struct FootprintPlace {
  static constexpr int kPhases = 64;
  static constexpr std::int32_t kCounted = 1 << 16;
  std::int32_t window;  // x + 2^16 y
  std::int32_t phases;  // x + 2^8 y, both kPhases more of a soft sample's, and kCounted where the sample counts

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
  /// The blocks of 8×8 pixels that the window touches: bit 8 y + x.
  std::uint64_t blocks(const FootprintPlace& at) const {
    return columns_[static_cast<std::size_t>(at.x())] & rows_[static_cast<std::size_t>(at.y())];
  }
  /// Whether a pixel in it was open when `update` was last called; of clipped footprints, whether any of the tile was.
  bool open(const FootprintPlace& at) const {
    return (openWords()[at.y() * stride_ + (at.x() >> 5)] >> (at.x() & 31) & 1) != 0;
  }
  /// The same: bit x & 31 of word y stride + x / 32. So many words before and after them may be read, too.
  static constexpr int kWordsBeside = 8;
  const std::int32_t* openWords() const { return open_.data() + kWordsBeside; }
  int stride() const { return stride_; }
  /// Pixel (x, y), counted from the tile's corner, is closed: `update` then tells the windows.
  void close(int x, int y) {
    pixels_[static_cast<std::size_t>(y)] &= ~(std::uint64_t{1} << x);
    first_closed_ = y < first_closed_ ? y : first_closed_;
    last_closed_ = y > last_closed_ ? y : last_closed_;
  }
  void update();
  /// Whether all pixels of `rect` are open. requires: counted from the tile's corner, in the tile, not empty.
  bool allOpen(const PixelRect& rect) const;
  /// Of pixels (x, y) to (x + 7, y), those that are open: a bit each. requires: x a multiple of 8.
  unsigned openPixels(int x, int y) const {
    return static_cast<unsigned>(pixels_[static_cast<std::size_t>(y)] >> x & 0xff);
  }
  /// unit: bytes.
  std::size_t bytes() const;

 private:
  void updateRow(int window);

  int width_ = 0, height_ = 0, taps_ = 1, stride_ = 0;
  int first_closed_ = kSweepEdge, last_closed_ = -1;  // since the last update
  std::vector<std::uint64_t> columns_, rows_;
  std::vector<std::uint64_t> pixels_;  // open ones: bit x of word y
  std::vector<std::int32_t> open_;
};

}  // namespace kiln
