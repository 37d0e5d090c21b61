// The mask: one bit a pixel, 8×8 pixels a 64-bit word, and on top one word for each 8×8 words, a tile of 64×64 pixels,
// whose bit is set where a word is full. Invariant: a bit of the upper word is set exactly where all 64 bits of its
// lower word are; pixels outside of the image count as opaque from the start. Exact. A rectangle costs one AND-compare
// of the upper word per tile where its words are full, and one per word along its border where they are not. Source:
// ours; the pyramid idea is Greene, Kass and Miller 1993.
#include <cstdint>
#include <vector>

#include "occlusion/visibility.h"

namespace kiln {
namespace {

constexpr int kWord = 8;  // pixels along a word, and words along a tile
static_assert(kWord * kWord == kVisibilityTile);

// Bits [x0, x1) of rows [y0, y1) of an 8×8 word. requires: 0 <= x0 < x1 <= 8, the same for y.
std::uint64_t rectBits(int x0, int y0, int x1, int y1) {
  const std::uint64_t row = ((0xffu >> (kWord - (x1 - x0))) << x0) & 0xffu;
  const std::uint64_t rows = row * 0x0101010101010101ull;
  const int count = y1 - y0;
  const std::uint64_t kept = count == kWord ? ~0ull : ((1ull << (kWord * count)) - 1) << (kWord * y0);
  return rows & kept;
}

// What of [lo, hi) lies in the eight units that begin at `first`, counted from there.
struct Span8 {
  int lo, hi;
};
Span8 within(int lo, int hi, int first) { return {std::max(lo - first, 0), std::min(hi - first, kWord)}; }

class MaskVisibility final : public Visibility {
 public:
  MaskVisibility(int width, int height)
      : image_{0, 0, width, height},
        tiles_x_((width + kVisibilityTile - 1) / kVisibilityTile),
        words_x_(tiles_x_ * kWord),
        tiles_(static_cast<std::size_t>(tiles_x_) * ((height + kVisibilityTile - 1) / kVisibilityTile)),
        words_(tiles_.size() * kWord * kWord) {
    const int tiles_y = static_cast<int>(tiles_.size()) / std::max(tiles_x_, 1);
    for (int wy = 0; wy < tiles_y * kWord; ++wy) {
      for (int wx = 0; wx < words_x_; ++wx) {
        const Span8 x = within(0, width, wx * kWord);
        const Span8 y = within(0, height, wy * kWord);
        const bool touches = x.lo < x.hi && y.lo < y.hi;
        word(wx, wy) = touches ? ~rectBits(x.lo, y.lo, x.hi, y.hi) : ~0ull;
        if (word(wx, wy) == ~0ull) tile(wx / kWord, wy / kWord) |= bitOf(wx % kWord, wy % kWord);
      }
    }
  }

  bool hidden(const PixelRect& wanted) const override {
    const PixelRect rect = intersection(wanted, image_);
    if (rect.empty()) return true;
    const PixelRect words = {rect.x0 / kWord, rect.y0 / kWord, (rect.x1 - 1) / kWord + 1, (rect.y1 - 1) / kWord + 1};
    for (int ty = words.y0 / kWord; ty <= (words.y1 - 1) / kWord; ++ty) {
      for (int tx = words.x0 / kWord; tx <= (words.x1 - 1) / kWord; ++tx) {
        const Span8 x = within(words.x0, words.x1, tx * kWord);
        const Span8 y = within(words.y0, words.y1, ty * kWord);
        const std::uint64_t open = rectBits(x.lo, y.lo, x.hi, y.hi) & ~tile(tx, ty);
        if (open != 0 && !coveredWords(open, tx, ty, rect)) return false;
      }
    }
    return true;
  }

  void close(int x, int y) override {
    std::uint64_t& bits = word(x / kWord, y / kWord);
    bits |= bitOf(x % kWord, y % kWord);
    if (bits == ~0ull) tile(x / kVisibilityTile, y / kVisibilityTile) |= bitOf(x / kWord % kWord, y / kWord % kWord);
  }

 private:
  static std::uint64_t bitOf(int x, int y) { return 1ull << (y * kWord + x); }

  // Words of a tile that are not full may still be full where the rectangle is.
  bool coveredWords(std::uint64_t open, int tx, int ty, const PixelRect& rect) const {
    for (; open != 0; open &= open - 1) {
      const int bit = __builtin_ctzll(open);
      const int wx = tx * kWord + bit % kWord;
      const int wy = ty * kWord + bit / kWord;
      const Span8 x = within(rect.x0, rect.x1, wx * kWord);
      const Span8 y = within(rect.y0, rect.y1, wy * kWord);
      const std::uint64_t asked = rectBits(x.lo, y.lo, x.hi, y.hi);
      if ((word(wx, wy) & asked) != asked) return false;
    }
    return true;
  }

  std::uint64_t& tile(int tx, int ty) { return tiles_[static_cast<std::size_t>(ty) * tiles_x_ + tx]; }
  std::uint64_t tile(int tx, int ty) const { return tiles_[static_cast<std::size_t>(ty) * tiles_x_ + tx]; }
  std::uint64_t& word(int wx, int wy) { return words_[static_cast<std::size_t>(wy) * words_x_ + wx]; }
  std::uint64_t word(int wx, int wy) const { return words_[static_cast<std::size_t>(wy) * words_x_ + wx]; }

  PixelRect image_;
  int tiles_x_, words_x_;
  std::vector<std::uint64_t> tiles_, words_;
};

}  // namespace

std::unique_ptr<Visibility> makeMaskVisibility(int width, int height) {
  return std::make_unique<MaskVisibility>(width, height);
}

}  // namespace kiln
