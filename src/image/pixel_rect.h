// A rectangle of pixels of an image; (0, 0) is the upper left pixel.
#pragma once

#include <algorithm>
#include <cstdint>

namespace kiln {

/// The longest side of a drawn, read or written image. unit: pixels.
inline constexpr int kLargestSide_px = 65536;
/// A coordinate beyond any image that still fits an int. unit: pixels.
inline constexpr double kFar_px = 1e8;

/// A half-open rectangle in pixels; may reach outside the image.
struct PixelRect {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  bool operator==(const PixelRect&) const = default;
  bool empty() const { return x0 >= x1 || y0 >= y1; }
  bool contains(int x, int y) const { return x >= x0 && x < x1 && y >= y0 && y < y1; }
  bool contains(const PixelRect& other) const {
    return other.x0 >= x0 && other.x1 <= x1 && other.y0 >= y0 && other.y1 <= y1;
  }
  /// requires: not empty.
  int width() const { return x1 - x0; }
  int height() const { return y1 - y0; }
  std::uint64_t count() const { return static_cast<std::uint64_t>(width()) * static_cast<std::uint64_t>(height()); }
};

inline PixelRect intersection(const PixelRect& a, const PixelRect& b) {
  return {std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
}
/// The smallest rectangle that holds both.
inline PixelRect aroundBoth(const PixelRect& a, const PixelRect& b) {
  if (a.empty()) return b;
  if (b.empty()) return a;
  return {std::min(a.x0, b.x0), std::min(a.y0, b.y0), std::max(a.x1, b.x1), std::max(a.y1, b.y1)};
}

}  // namespace kiln
