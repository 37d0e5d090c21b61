// The mask: one bit a pixel, 8×8 pixels a 64-bit word; above it one word for each 8×8 words, a tile of 64×64 pixels,
// and one for each 8×8 tiles, a block of 512×512. Invariant: a bit of an upper word is set exactly where all 64 bits of
// the word below it are; what lies outside of the image counts as opaque from the start. Exact. A rectangle costs one
// AND-compare a block where its tiles are full, one a tile where its words are, and one a word along its border.
// Source: ours; the pyramid idea is Greene, Kass and Miller 1993.
#include <atomic>
#include <bit>
#include <cstdint>
#include <vector>

#include "occlusion/visibility.h"

namespace kiln {
namespace {

constexpr int kShift = 3;  // a word is 2^kShift units wide and high
constexpr int kLast = (1 << kShift) - 1;
static_assert(1 << (2 * kShift) == kVisibilityTile);

// Bit y * 8 + x of a word is its unit in column x and row y. The columns and rows from a unit on, and up to it.
std::uint64_t columnsFrom(int x) { return ((0xffu << x) & 0xffu) * 0x0101010101010101ull; }
std::uint64_t columnsUpTo(int x) { return (0xffu >> (kLast - x)) * 0x0101010101010101ull; }
std::uint64_t rowsFrom(int y) { return ~0ull << (8 * y); }
std::uint64_t rowsUpTo(int y) { return ~0ull >> (8 * (kLast - y)); }

// The units of the level above that `units` touches. requires: not empty, not negative.
PixelRect coarser(const PixelRect& units) {
  return {units.x0 >> kShift, units.y0 >> kShift, ((units.x1 - 1) >> kShift) + 1, ((units.y1 - 1) >> kShift) + 1};
}
bool fewIn(const PixelRect& units) { return units.x1 - units.x0 <= 2 && units.y1 - units.y0 <= 2; }

// Of the units of word (x, y), those that `units` has. requires: there are some.
std::uint64_t asked(const PixelRect& units, int x, int y) {
  const int first_x = std::max(units.x0 - (x << kShift), 0), last_x = std::min(units.x1 - 1 - (x << kShift), kLast);
  const int first_y = std::max(units.y0 - (y << kShift), 0), last_y = std::min(units.y1 - 1 - (y << kShift), kLast);
  return columnsFrom(first_x) & columnsUpTo(last_x) & rowsFrom(first_y) & rowsUpTo(last_y);
}

// One level: a word for each 8×8 units of the level below.
class WordGrid {
 public:
  // shape: `columns` by `rows` units; what a word has beyond them is set.
  WordGrid(int columns, int rows)
      : columns_((columns + kLast) >> kShift),
        rows_((rows + kLast) >> kShift),
        words_(static_cast<std::size_t>(columns_) * rows_) {
    for (int y = 0; y < rows_; ++y) {
      for (int x = 0; x < columns_; ++x) word(x, y) = ~asked({0, 0, columns, rows}, x, y);
    }
  }
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  std::uint64_t& word(int x, int y) { return words_[static_cast<std::size_t>(y) * columns_ + x]; }
  const std::uint64_t& word(int x, int y) const { return words_[static_cast<std::size_t>(y) * columns_ + x]; }
  std::uint64_t& wordOf(int x, int y) { return word(x >> kShift, y >> kShift); }
  static std::uint64_t bitOf(int x, int y) { return 1ull << ((y & kLast) * 8 + (x & kLast)); }

  // What of `units` is not set, in the one, two or four words that they lie in: no branch hangs on where they lie.
  // requires: fewIn(coarser(units)).
  struct Missing {
    std::uint64_t bits[4];  // of words (x0, y0), (x1, y0), (x0, y1), (x1, y1); none where x1 == x0 or y1 == y0
    int x0, y0, x1, y1;
    bool none() const { return (bits[0] | bits[1] | bits[2] | bits[3]) == 0; }
  };
  Missing missing(const PixelRect& units) const {
    Missing out;
    out.x0 = units.x0 >> kShift;
    out.y0 = units.y0 >> kShift;
    out.x1 = (units.x1 - 1) >> kShift;
    out.y1 = (units.y1 - 1) >> kShift;
    const std::uint64_t last_x = columnsUpTo((units.x1 - 1) & kLast), last_y = rowsUpTo((units.y1 - 1) & kLast);
    const std::uint64_t more_x = out.x1 > out.x0 ? ~0ull : 0, more_y = out.y1 > out.y0 ? ~0ull : 0;
    const std::uint64_t left = columnsFrom(units.x0 & kLast) & (last_x | more_x), right = last_x & more_x;
    const std::uint64_t upper = rowsFrom(units.y0 & kLast) & (last_y | more_y), lower = last_y & more_y;
    out.bits[0] = left & upper & ~word(out.x0, out.y0);
    out.bits[1] = right & upper & ~word(out.x1, out.y0);
    out.bits[2] = left & lower & ~word(out.x0, out.y1);
    out.bits[3] = right & lower & ~word(out.x1, out.y1);
    return out;
  }

 private:
  int columns_, rows_;
  std::vector<std::uint64_t> words_;
};

class MaskVisibility final : public Visibility {
 public:
  MaskVisibility(int width, int height)
      : image_{0, 0, width, height},
        words_(width, height),
        tiles_(words_.columns(), words_.rows()),
        blocks_(tiles_.columns(), tiles_.rows()) {}

  bool hidden(const PixelRect& wanted) const override {
    const PixelRect pixels = intersection(wanted, image_);
    if (pixels.empty()) return true;
    const PixelRect words = coarser(pixels);
    if (fewIn(words)) return words_.missing(pixels).none();
    const PixelRect tiles = coarser(words);
    return fewIn(tiles) ? hiddenInTiles(words, pixels) : hiddenInBlocks(tiles, words, pixels);
  }

  void close(int x, int y) override {
    if ((words_.wordOf(x, y) |= WordGrid::bitOf(x, y)) != ~0ull) return;
    x >>= kShift;
    y >>= kShift;
    if ((tiles_.wordOf(x, y) |= WordGrid::bitOf(x, y)) != ~0ull) return;
    x >>= kShift;
    y >>= kShift;
    // Blocks are shared by the threads that draw tiles.
    std::atomic_ref(blocks_.wordOf(x, y)).fetch_or(WordGrid::bitOf(x, y), std::memory_order_relaxed);
  }

 private:
  // Whether test(x, y) holds for each unit of `open`, bits of word (word_x, word_y).
  template <class Test>
  static bool all(int word_x, int word_y, std::uint64_t open, const Test& test) {
    for (; open != 0; open &= open - 1) {
      const int bit = std::countr_zero(open);
      if (!test((word_x << kShift) + (bit & kLast), (word_y << kShift) + (bit >> kShift))) return false;
    }
    return true;
  }

  // Words that are not full may still be full where the rectangle is.
  bool hiddenInWords(int tile_x, int tile_y, std::uint64_t open, const PixelRect& pixels) const {
    return all(tile_x, tile_y, open, [&](int x, int y) { return (asked(pixels, x, y) & ~words_.word(x, y)) == 0; });
  }

  bool hiddenInTiles(const PixelRect& words, const PixelRect& pixels) const {
    const WordGrid::Missing open = tiles_.missing(words);
    return open.none() || (hiddenInWords(open.x0, open.y0, open.bits[0], pixels) &&
                           hiddenInWords(open.x1, open.y0, open.bits[1], pixels) &&
                           hiddenInWords(open.x0, open.y1, open.bits[2], pixels) &&
                           hiddenInWords(open.x1, open.y1, open.bits[3], pixels));
  }

  bool hiddenInBlocks(const PixelRect& tiles, const PixelRect& words, const PixelRect& pixels) const {
    const auto tile = [&](int x, int y) {
      return hiddenInWords(x, y, asked(words, x, y) & ~tiles_.word(x, y), pixels);
    };
    const PixelRect blocks = coarser(tiles);
    for (int y = blocks.y0; y < blocks.y1; ++y) {
      for (int x = blocks.x0; x < blocks.x1; ++x) {
        // Shared by the threads that draw tiles.
        const std::uint64_t full = __atomic_load_n(&blocks_.word(x, y), __ATOMIC_RELAXED);
        if (!all(x, y, asked(tiles, x, y) & ~full, tile)) return false;
      }
    }
    return true;
  }

  PixelRect image_;
  WordGrid words_, tiles_, blocks_;
};

}  // namespace

std::unique_ptr<Visibility> makeMaskVisibility(int width, int height) {
  return std::make_unique<MaskVisibility>(width, height);
}

}  // namespace kiln
