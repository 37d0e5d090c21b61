// Problem. The exact test of any rectangle in O(log² n).
// Method. A segment tree over the rows of the image; each node, a chunk of rows, has a segment tree over the columns. A
// node of such a secondary tree is a standard rectangle and counts its opaque halves. Any rectangle of pixels is the
// product of O(log n) standard intervals along each axis.
// Invariant. A count is two exactly if every pixel of the standard rectangle inside the image is opaque.
// Source: Lee and Ihm §2.2 (Preparata and Shamos 1985).
// Differs: a leaf of a thick chunk counts the leaves of its two thinner chunks instead of testing the pixels of its
// column. Images need be neither square nor powers of two.
// Cost: a closed pixel takes O(log² n) at worst, and O(1) while no count fills up.
#include <atomic>
#include <bit>
#include <cstdint>
#include <vector>

#include "occlusion/visibility.h"

namespace kiln {
namespace {

constexpr std::uint8_t kOpaque = 2;

// A complete binary tree in heap order: node 1 is the root, nodes 2i and 2i+1 are the halves of i, node leaves + k is
// unit k.
int leavesFor(int units) { return static_cast<int>(std::bit_ceil(static_cast<unsigned>(units))); }

class RangeTreeVisibility final : public Visibility {
 public:
  RangeTreeVisibility(int width, int height)
      : image_{0, 0, width, height},
        columns_(leavesFor(width)),
        rows_(leavesFor(height)),
        counts_(rangeTreeBytes(width, height)) {
    markOutside();
  }

  bool hidden(const PixelRect& wanted) const override {
    const PixelRect rect = intersection(wanted, image_);
    if (rect.empty()) return true;
    int lo = rect.y0 + rows_;
    int hi = rect.y1 + rows_;
    for (; lo < hi; lo >>= 1, hi >>= 1) {
      if ((lo & 1) != 0 && !hiddenIn(lo++, rect)) return false;
      if ((hi & 1) != 0 && !hiddenIn(--hi, rect)) return false;
    }
    return true;
  }

  void close(int x, int y) override {
    int chunk = rows_ + y;
    *at(chunk, columns_ + x) = kOpaque;
    for (int thickness = 0;; ++thickness) {
      // The leaf of column x has just become opaque in this chunk.
      int segment = columns_ + x;
      for (int length = 1; segment > 1; ++length) {
        segment >>= 1;
        if (!fills(chunk, segment, std::max(thickness, length))) break;
      }
      if (chunk == 1) return;
      chunk >>= 1;
      if (!fills(chunk, columns_ + x, thickness + 1)) return;
    }
  }

 private:
  std::uint8_t* at(int chunk, int segment) {
    return &counts_[static_cast<std::size_t>(chunk) * (2 * columns_) + segment];
  }

  // Counts another opaque half of a standard rectangle; returns true if the rectangle is now opaque.
  bool fills(int chunk, int segment, int level) {
    std::uint8_t& count = *at(chunk, segment);
    return (level > kVisibilityTileLevel ? std::atomic_ref(count).fetch_add(1) + 1 : ++count) == kOpaque;
  }

  // True if all standard intervals of [x0, x1) in the secondary tree of a chunk are opaque.
  bool hiddenIn(int chunk, const PixelRect& rect) const {
    const std::uint8_t* const counts = &counts_[static_cast<std::size_t>(chunk) * (2 * columns_)];
    int lo = rect.x0 + columns_;
    int hi = rect.x1 + columns_;
    for (; lo < hi; lo >>= 1, hi >>= 1) {
      if ((lo & 1) != 0 && counts[lo++] != kOpaque) return false;
      if ((hi & 1) != 0 && counts[--hi] != kOpaque) return false;
    }
    return true;
  }

  // Marks the outer half of nodes across the end of the image as opaque. Nodes wholly outside are never tested.
  void markOutside() {
    for (int chunk = rows_ + image_.y1 - 1; chunk >= 1; chunk >>= 1) {
      if (chunk > 1 && (chunk & 1) == 0 && outside(chunk + 1, rows_, image_.y1)) {
        for (int x = 0; x < image_.x1; ++x) *at(chunk >> 1, columns_ + x) = 1;
      }
    }
    for (int segment = columns_ + image_.x1 - 1; segment > 1; segment >>= 1) {
      if ((segment & 1) != 0 || !outside(segment + 1, columns_, image_.x1)) continue;
      for (int chunk = 1; chunk < 2 * rows_; ++chunk) *at(chunk, segment >> 1) = 1;
    }
  }
  // True if the first unit of a node lies at or beyond `end`.
  static bool outside(int node, int leaves, int end) {
    while (node < leaves) node <<= 1;
    return node - leaves >= end;
  }

  PixelRect image_;
  int columns_, rows_;
  std::vector<std::uint8_t> counts_;
};

}  // namespace

std::unique_ptr<Visibility> makeRangeTreeVisibility(int width, int height) {
  return std::make_unique<RangeTreeVisibility>(width, height);
}

std::uint64_t rangeTreeBytes(int width, int height) {
  return std::uint64_t{4} * static_cast<std::uint64_t>(leavesFor(width)) *
         static_cast<std::uint64_t>(leavesFor(height));
}

}  // namespace kiln
