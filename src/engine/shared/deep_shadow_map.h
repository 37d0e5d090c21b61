// Transmittance from a light, as a function of depth for each pixel of the light's view.
// Problem. Samples of a picture need the transmittance between a light and any point, without rays through the volume.
// Method. An engine draws the light's view and adds each sample as a layer. Each pixel keeps a polyline of
// transmittance over depth: points that a line represents within kShadowError need no knot.
//
// Invariant. A pixel depends on its layers in order of depth only, hence never on bricks, tiles or threads.
//
// Source: Lokovic and Veach 2000, §3.2 (compression of a visibility function). Differs: at most kShadowKnots knots a
// pixel, in integers; the knot that matters least makes room for a knot too many.
//
// Cost. A look-up reads a word, and four cache lines near layers. Memory: 68 bytes a place (shadowStride), and 28
// more while the map is drawn.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <glm/vec3.hpp>
#include <limits>
#include <vector>

#include "base/memory/large_pages.h"
#include "scene/camera/camera.h"

namespace kiln {

/// Places from row to row of a map of so many pixels. Rows that begin at equal sets of a cache would evict each other:
/// a row begins 17 places of 64 behind the row above. Figures: frame/decisions/shadow-lookups.md.
constexpr int shadowStride(int width) {
  constexpr int kSets = 64, kShift = 17;  // unit: places
  return width + (kSets + kShift - width % kSets) % kSets;
}

/// Knots of a pixel: 16 depths and transmittances of two bytes each fill a cache line.
inline constexpr int kShadowKnots = 16;
/// Largest error of a polyline with few enough knots. unit: transmittance.
inline constexpr float kShadowError = 0.002f;

/// The range of depths that a map holds. unit: world, along the light's view.
struct DepthRange {
  double near = 0, far = 1;
};

class DeepShadowMap {
 public:
  /// A map without layers. requires: `light` is no panorama; depths.near < depths.far.
  DeepShadowMap(const View& light, const DepthRange& depths);
  /// Memory of a map of width × height pixels. unit: bytes; `drawing`: before finish().
  static std::uint64_t bytesFor(int width, int height, bool drawing);

  const View& view() const { return view_; }

  /// Adds a layer from `z` to `z_back` behind all layers of the pixel; alpha in front of and behind the layer.
  /// thread: one thread at a time for each pixel.
  void add(int x, int y, float z, float z_back, float alpha_before, float alpha_after) {
    Column& column = columns_[placeOf(x, y)];
    Knots& knots = pixels_[placeOf(x, y)];
    if (column.knots == 0 || z > column.end.z) addPoint({z, 1 - alpha_before}, column, knots);
    addPoint({z_back, 1 - alpha_after}, column, knots);
  }
  /// Ends the polylines. requires: all layers are added.
  void finish();

  /// Position of look-ups in the map.
  struct Frame {
    bool perspective = false;
    int width = 0, height = 0;                                            // unit: pixels
    int stride = 0;                                                       // places from row to row
    float focal = 1, centre_x = 0, centre_y = 0, last_x = 0, last_y = 0;  // unit: pixels, from the middle of the first
    float near = 0, per_depth = 1;                                        // unit: steps of a depth per world unit
  };
  const Frame& frame() const { return frame_; }
  /// Greatest depth. unit: steps.
  static constexpr float kSteps = std::numeric_limits<std::uint16_t>::max();
  /// For each pixel, over the four pixels from it on to the right and down: the lower 16 bits are the first depth with
  /// a layer, all light reaches depths in front of it; the upper 16 bits a depth behind which no light is left. A word
  /// answers most look-ups, so that knots, each a cache line, are read near layers only. unit: steps.
  const std::int32_t* spans() const { return spans_.data(); }

  /// Transmittance from the light to a point of the light's view space, between four pixels. requires: finished.
  float transmittance(const glm::vec3& light_point) const {
    const Frame& f = frame_;
    const float scale = f.perspective ? f.focal / light_point.z : f.focal;
    const float x = std::clamp(f.centre_x + scale * light_point.x, 0.0f, f.last_x),
                y = std::clamp(f.centre_y + scale * light_point.y, 0.0f, f.last_y);
    const int x0 = std::min(static_cast<int>(x), f.width - 2), y0 = std::min(static_cast<int>(y), f.height - 2);
    const float depth = std::clamp((light_point.z - f.near) * f.per_depth, 0.0f, kSteps);
    const std::int32_t place = y0 * f.stride + x0;
    const auto span = static_cast<std::uint32_t>(spans_[static_cast<std::size_t>(place)]);
    const auto whole = static_cast<std::uint16_t>(depth);
    if ((span & 0xffff) > whole) return 1;
    if (whole > span >> 16) return 0;
    const auto through = [&](int beside) { return pieceAt(place + beside, whole, &passedIn).at(depth); };
    const float fx = x - static_cast<float>(x0), fy = y - static_cast<float>(y0);
    const float upper = std::lerp(through(0), through(1), fx);
    return std::lerp(upper, std::lerp(through(f.stride), through(f.stride + 1), fx), fy);
  }
  /// Depths of a pixel's knots. shape: kShadowKnots, ascending. unit: steps.
  using Depths = std::array<std::uint16_t, kShadowKnots>;
  /// The piece of a polyline around a depth: depths and transmittances at its ends, the first in the lower 16 bits.
  struct Piece {
    std::uint32_t depths, shares;
    float at(float depth) const {
      const auto first = [](std::uint32_t ends) { return static_cast<float>(ends & 0xffff); };
      const auto last = [](std::uint32_t ends) { return static_cast<float>(ends >> 16); };
      const float part = (depth - first(depths)) / std::max(last(depths) - first(depths), 1.0f);
      return std::lerp(first(shares), last(shares), std::clamp(part, 0.0f, 1.0f)) / kSteps;
    }
  };
  /// `passed(depths, whole)` counts the depths that are not above `whole`.
  template <class Passed>
  Piece pieceAt(std::int32_t place, std::uint16_t whole, const Passed& passed) const {
    const Knots& knots = pixels_[static_cast<std::size_t>(place)];
    const std::size_t behind = passed(knots.z, whole);
    const std::size_t last = std::clamp<std::size_t>(behind, 1, kShadowKnots - 1);
    // All light reaches depths in front of the first knot.
    return {bothOf(knots.z, last), bothOf(knots.t, last) | (behind == 0 ? ~std::uint32_t{0} : 0)};
  }

 private:
  // Sorted by depth; a pixel with fewer knots repeats the last transmittance at the greatest depth.
  struct alignas(64) Knots {
    Depths z;
    std::array<std::uint16_t, kShadowKnots> t;
  };
  struct Point {
    float z = 0, t = 1;
  };
  // The line since the last knot: slopes that pass all points within the error.
  struct Column {
    Point start, end;  // the last knot; the last point
    float least = 0, most = 0;
    int knots = 0;
  };

  std::size_t placeOf(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(frame_.stride) + static_cast<std::size_t>(x);
  }
  void addPoint(const Point& point, Column& column, Knots& knots) const;
  void addKnot(const Point& point, Column& column, Knots& knots) const;
  static std::size_t passedIn(const Depths& depths, std::uint16_t whole) {
    std::size_t out = 0;
    for (const std::uint16_t z : depths) out += z <= whole ? 1 : 0;
    return out;
  }
  static std::uint32_t bothOf(const Depths& knots, std::size_t last) {
    static_assert(std::endian::native == std::endian::little);
    std::uint32_t both;
    std::memcpy(&both, knots.data() + last - 1, sizeof both);
    return both;
  }

  // The depth behind which no light is left.
  static std::uint16_t darkAfter(const Knots& knots);
  void findSpans();

  View view_;
  Frame frame_;
  // In large pages, because look-ups are scattered: frame/decisions/shadow-lookups.md.
  template <class T>
  using Pages = std::vector<T, UnsetAllocator<T>>;
  Pages<Knots> pixels_;
  Pages<std::int32_t> spans_;  // from finish() on
  Pages<Column> columns_;      // until finished
};

}  // namespace kiln
