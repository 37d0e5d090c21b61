// A list of elements per pixel, most of them short or empty.
// Method. Elements lie in chunks of 4. Each square of 64×64 pixels has its own pages of chunks, so threads in different
// squares share only the page counter.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "image/pixel_rect.h"

namespace kiln {

template <class T>
class PixelLists {
 public:
  static constexpr int kLongest = std::numeric_limits<std::uint16_t>::max();

  /// Lists for the pixels of `rect`. Elements take at most `most_bytes`, rounded up to a page.
  explicit PixelLists(const PixelRect& rect, std::uint64_t most_bytes = ~std::uint64_t{0})
      : rect_(rect),
        columns_(squaresAlong(rect.x0, rect.x1)),
        pixels_(rect.count()),
        squares_(static_cast<std::size_t>(columns_ * squaresAlong(rect.y0, rect.y1))),
        most_pages_(most_bytes / sizeof(Page) + (most_bytes % sizeof(Page) != 0 ? 1 : 0)) {}

  /// Upper bound of the memory for lists of `elements` each. unit: bytes.
  static std::uint64_t bytesFor(std::uint64_t pixels, int elements) {
    const auto chunks = static_cast<std::uint64_t>((elements + kChunk - 1) / kChunk);
    // Each square has at most one page that is not full.
    const std::uint64_t squares = pixels / (kSquare * kSquare) + 1;
    return pixels * (sizeof(Pixel) + chunks * sizeof(Chunk)) + squares * (sizeof(Page) + sizeof(Square));
  }

  const PixelRect& rect() const { return rect_; }
  int count(int x, int y) const { return pixels_[placeOf(x, y)].count; }
  /// requires: count(x, y) > 0.
  T& last(int x, int y) {
    const Pixel& pixel = pixels_[placeOf(x, y)];
    return lastChunk(squares_[squareOf(x, y)], pixel).elements[(pixel.count - 1) % kChunk];
  }
  /// Appends an element to the list of a pixel. Returns false, without appending, if the list has kLongest elements or
  /// the memory is used up.
  /// thread: one thread at a time in each square of 64×64 pixels, counted from pixel (0, 0).
  bool append(int x, int y, const T& element) {
    Pixel& pixel = pixels_[placeOf(x, y)];
    Square& square = squares_[squareOf(x, y)];
    if (pixel.count == kLongest) return false;
    if (pixel.count % kChunk == 0) {
      if (!hasChunk(square)) return false;
      const std::uint32_t next = square.used++;
      (pixel.count == 0 ? pixel.first : lastChunk(square, pixel).next) = next;
    }
    const int place = pixel.count++ % kChunk;
    lastChunk(square, pixel).elements[place] = element;
    return true;
  }
  /// Calls f(element) from the first to the last element.
  template <class F>
  void forEach(int x, int y, F f) const {
    const Pixel& pixel = pixels_[placeOf(x, y)];
    if (pixel.count == 0) return;
    const Square& square = squares_[squareOf(x, y)];
    Chunk* chunk = &square.at(pixel.first);
    for (int i = 0; i < pixel.count; ++i) {
      if (i > 0 && i % kChunk == 0) chunk = &square.at(chunk->next);
      f(chunk->elements[i % kChunk]);
    }
  }

 private:
  static constexpr int kChunk = 4, kPageChunks = 64, kSquare = 64;
  struct Chunk {
    T elements[kChunk];
    std::uint32_t next;
  };
  struct Page {
    Chunk chunks[kPageChunks];
  };
  struct Square {
    std::vector<std::unique_ptr<Page>> pages;
    std::uint32_t used = 0;  // number of chunks in use
    Chunk& at(std::uint32_t i) const { return pages[i / kPageChunks]->chunks[i % kPageChunks]; }
  };
  struct Pixel {
    std::uint32_t first = 0;
    std::uint16_t count = 0;
  };

  static int squaresAlong(int from, int to) { return (to - 1) / kSquare - from / kSquare + 1; }
  std::size_t placeOf(int x, int y) const {
    return static_cast<std::size_t>(y - rect_.y0) * static_cast<std::size_t>(rect_.width()) +
           static_cast<std::size_t>(x - rect_.x0);
  }
  std::size_t squareOf(int x, int y) const {
    return static_cast<std::size_t>((y / kSquare - rect_.y0 / kSquare) * columns_ + x / kSquare - rect_.x0 / kSquare);
  }
  Chunk& lastChunk(const Square& square, const Pixel& pixel) const {
    Chunk* chunk = &square.at(pixel.first);
    for (int before = kChunk; before < pixel.count; before += kChunk) chunk = &square.at(chunk->next);
    return *chunk;
  }
  // Makes sure that the square has a free chunk; returns false if the memory is used up.
  bool hasChunk(Square& square) {
    if (square.used < square.pages.size() * kPageChunks) return true;
    if (pages_.fetch_add(1, std::memory_order_relaxed) >= most_pages_) return false;
    square.pages.push_back(std::make_unique<Page>());
    return true;
  }

  const PixelRect rect_;
  const int columns_;
  std::vector<Pixel> pixels_;
  std::vector<Square> squares_;
  const std::uint64_t most_pages_;
  std::atomic<std::uint64_t> pages_ = 0;
};

}  // namespace kiln
