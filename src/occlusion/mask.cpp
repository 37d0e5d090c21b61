// Problem. The test of a rectangle must be exact, and cheap enough to run for every cell and voxel.
// Method. A pyramid of 64-bit masks with one bit per pixel. A word is 8×8 pixels; a tile word stands for 8×8 words
// (64×64 pixels), a block word for 8×8 tiles (512×512 pixels).
// Invariant. A bit of an upper word is set exactly if all 64 bits of the word below are set. Bits outside the image are
// set from the start, so the test is exact.
// Source: new here; the pyramid follows Greene 1993.
// Cost: an AND and a compare per block with full tiles, per tile with full words, and per word along the border of the
// rectangle.
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

// Bit y * 8 + x of a word is the unit in column x and row y. Masks of the columns and rows from a unit on, and up to a
// unit.
std::uint64_t columnsFrom(int x) { return ((0xffu << x) & 0xffu) * 0x0101010101010101ull; }
std::uint64_t columnsUpTo(int x) { return (0xffu >> (kLast - x)) * 0x0101010101010101ull; }
std::uint64_t rowsFrom(int y) { return ~0ull << (8 * y); }
std::uint64_t rowsUpTo(int y) { return ~0ull >> (8 * (kLast - y)); }

// The units of the level above that contain `units`. requires: not empty, not negative.
PixelRect coarser(const PixelRect& units) {
  return {units.x0 >> kShift, units.y0 >> kShift, ((units.x1 - 1) >> kShift) + 1, ((units.y1 - 1) >> kShift) + 1};
}
bool fewIn(const PixelRect& units) { return units.x1 - units.x0 <= 2 && units.y1 - units.y0 <= 2; }

// The bits of word (x, y) that lie in `units`. requires: at least one.
std::uint64_t bitsIn(const PixelRect& units, int x, int y) {
  const int first_x = std::max(units.x0 - (x << kShift), 0), last_x = std::min(units.x1 - 1 - (x << kShift), kLast);
  const int first_y = std::max(units.y0 - (y << kShift), 0), last_y = std::min(units.y1 - 1 - (y << kShift), kLast);
  return columnsFrom(first_x) & columnsUpTo(last_x) & rowsFrom(first_y) & rowsUpTo(last_y);
}

// Returns the words along an axis of so many units.
int wordsFor(int units) { return (units + kLast) >> kShift; }

// One level: a word per 8×8 units of the level below.
class WordGrid {
 public:
  // shape: `columns` by `rows` units; the bits of a word beyond the grid are set.
  WordGrid(int columns, int rows)
      : columns_(wordsFor(columns)), rows_(wordsFor(rows)), words_(static_cast<std::size_t>(columns_) * rows_) {
    for (int y = 0; y < rows_; ++y) {
      for (int x = 0; x < columns_; ++x) word(x, y) = ~bitsIn({0, 0, columns, rows}, x, y);
    }
  }
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  std::uint64_t& word(int x, int y) { return words_[static_cast<std::size_t>(y) * columns_ + x]; }
  const std::uint64_t& word(int x, int y) const { return words_[static_cast<std::size_t>(y) * columns_ + x]; }
  std::uint64_t& wordOf(int x, int y) { return word(x >> kShift, y >> kShift); }
  static std::uint64_t bitOf(int x, int y) { return 1ull << ((y & kLast) * 8 + (x & kLast)); }

  // The unset bits of `units`, which lie in one, two or four words. The computation has no branch on the number of
  // words.
  // requires: fewIn(coarser(units)).
  struct OpenBits {
    std::uint64_t bits[4];  // in words (x0, y0), (x1, y0), (x0, y1), (x1, y1); 0 if x1 == x0 or y1 == y0
    int x0, y0, x1, y1;
    bool none() const { return (bits[0] | bits[1] | bits[2] | bits[3]) == 0; }
  };
  OpenBits openBits(const PixelRect& units) const {
    OpenBits out;
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
    if (fewIn(words)) return words_.openBits(pixels).none();
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
    // Threads that draw different tiles share block words.
    std::atomic_ref(blocks_.wordOf(x, y)).fetch_or(WordGrid::bitOf(x, y), std::memory_order_relaxed);
  }

 private:
  // True if test(x, y) holds for each unit of `open`, bits of word (word_x, word_y).
  template <class Test>
  static bool all(int word_x, int word_y, std::uint64_t open, const Test& test) {
    for (; open != 0; open &= open - 1) {
      const int bit = std::countr_zero(open);
      if (!test((word_x << kShift) + (bit & kLast), (word_y << kShift) + (bit >> kShift))) return false;
    }
    return true;
  }

  // Tests the words of `open`: a word that is not full may be full inside the rectangle.
  bool hiddenInWords(int tile_x, int tile_y, std::uint64_t open, const PixelRect& pixels) const {
    return all(tile_x, tile_y, open, [&](int x, int y) { return (bitsIn(pixels, x, y) & ~words_.word(x, y)) == 0; });
  }

  bool hiddenInTiles(const PixelRect& words, const PixelRect& pixels) const {
    const WordGrid::OpenBits open = tiles_.openBits(words);
    return open.none() || (hiddenInWords(open.x0, open.y0, open.bits[0], pixels) &&
                           hiddenInWords(open.x1, open.y0, open.bits[1], pixels) &&
                           hiddenInWords(open.x0, open.y1, open.bits[2], pixels) &&
                           hiddenInWords(open.x1, open.y1, open.bits[3], pixels));
  }

  bool hiddenInBlocks(const PixelRect& tiles, const PixelRect& words, const PixelRect& pixels) const {
    const auto tile = [&](int x, int y) {
      return hiddenInWords(x, y, bitsIn(words, x, y) & ~tiles_.word(x, y), pixels);
    };
    const PixelRect blocks = coarser(tiles);
    for (int y = blocks.y0; y < blocks.y1; ++y) {
      for (int x = blocks.x0; x < blocks.x1; ++x) {
        // Threads that draw tiles share the block words.
        const std::uint64_t full = __atomic_load_n(&blocks_.word(x, y), __ATOMIC_RELAXED);
        if (!all(x, y, bitsIn(tiles, x, y) & ~full, tile)) return false;
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

std::uint64_t maskBytes(int width, int height) {
  std::uint64_t words = 0;
  for (int level = 0; level < 3; ++level) {
    width = wordsFor(width), height = wordsFor(height);
    words += static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
  }
  return words * sizeof(std::uint64_t);
}

}  // namespace kiln
