#include "splat/tile_windows.h"

#include <algorithm>
#include <cassert>

namespace kiln {
namespace {

// Of each window along one axis, the blocks of the tile that it touches: bit b of byte 0, for block b.
std::vector<std::uint64_t> blocksAlong(int edge, int taps) {
  std::vector<std::uint64_t> out;
  for (int window = 0; window < edge + taps - 1; ++window) {
    const int first = std::max(window - taps + 1, 0) >> 3, last = std::min(window, edge - 1) >> 3;
    out.push_back((std::uint64_t{2} << last) - (std::uint64_t{1} << first));
  }
  return out;
}

std::uint64_t rowsOf(std::uint64_t blocks) {
  std::uint64_t out = 0;
  for (int row = 0; row < 8; ++row) out |= (blocks >> row & 1) != 0 ? std::uint64_t{0xff} << (8 * row) : 0;
  return out;
}

// Each bit that is set sets the `more` bits after it, too.
void spread(std::int32_t* words, int count, int more) {
  for (int reach = 1; more > 0; reach *= 2) {
    const int by = std::min({reach, more, 31});
    for (int i = count - 1; i >= 0; --i) {
      const auto own = static_cast<std::uint32_t>(words[i]);
      const std::uint32_t below = i > 0 ? static_cast<std::uint32_t>(words[i - 1]) >> (32 - by) : 0;
      words[i] = static_cast<std::int32_t>(own | own << by | below);
    }
    more -= by;
  }
}

}  // namespace

void TileWindows::reset(const TilePixels& tile, int taps) {
  assert(tile.rect.width() <= kSweepEdge && tile.rect.height() <= kSweepEdge);
  width_ = tile.rect.width(), height_ = tile.rect.height(), taps_ = taps;
  columns_ = blocksAlong(width_, taps);
  for (std::uint64_t& blocks : columns_) blocks *= 0x0101010101010101u;
  rows_ = blocksAlong(height_, taps);
  for (std::uint64_t& blocks : rows_) blocks = rowsOf(blocks);
  pixels_.assign(static_cast<std::size_t>(height_), 0);
  for (int y = 0; y < height_; ++y) {
    const float* const alpha = tile.rgba + y * tile.stride + 3;
    std::uint64_t open = 0;
    for (int x = 0; x < width_; ++x) open |= std::uint64_t{alpha[4 * x] != 1.0f} << x;
    pixels_[static_cast<std::size_t>(y)] = open;
  }
  const int words = (columns() + 31) / 32;
  stride_ = taps > kMostWholeTaps ? 0 : words;
  open_.resize(static_cast<std::size_t>(std::max(rows() * stride_, words) + 2 * kWordsBeside));
  first_closed_ = 0, last_closed_ = height_ - 1;
  update();
}

void TileWindows::update() {
  if (first_closed_ > last_closed_) return;
  if (stride_ == 0) {
    const bool open = std::any_of(pixels_.begin(), pixels_.end(), [](std::uint64_t row) { return row != 0; });
    std::fill(open_.begin(), open_.end(), open ? -1 : 0);
  } else {
    for (int window = first_closed_; window < last_closed_ + taps_; ++window) updateRow(window);
  }
  first_closed_ = kSweepEdge, last_closed_ = -1;
}

bool TileWindows::allOpen(const PixelRect& rect) const {
  const std::uint64_t columns = (~std::uint64_t{0} >> (64 - rect.width())) << rect.x0;
  std::uint64_t open = columns;
  for (int y = rect.y0; y < rect.y1; ++y) open &= pixels_[static_cast<std::size_t>(y)];
  return open == columns;
}

void TileWindows::updateRow(int window) {
  std::uint64_t open = 0;
  for (int y = std::max(window - taps_ + 1, 0); y <= std::min(window, height_ - 1); ++y)
    open |= pixels_[static_cast<std::size_t>(y)];
  std::int32_t* const words = &open_[static_cast<std::size_t>(window * stride_ + kWordsBeside)];
  std::fill_n(words, stride_, 0);
  words[0] = static_cast<std::int32_t>(static_cast<std::uint32_t>(open));
  if (stride_ > 1) words[1] = static_cast<std::int32_t>(static_cast<std::uint32_t>(open >> 32));
  spread(words, stride_, taps_ - 1);
}

std::size_t TileWindows::bytes() const {
  const auto of = [](const auto& v) { return v.capacity() * sizeof(v[0]); };
  return of(columns_) + of(rows_) + of(pixels_) + of(open_);
}

}  // namespace kiln
