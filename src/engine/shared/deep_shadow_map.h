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
// Cost. A look-up reads four cache lines. Memory: 64 bytes a pixel, and 28 more while the map is drawn.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <vector>

#include "scene/camera/camera.h"

namespace kiln {

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
  /// unit: bytes; `drawing`: before finish().
  static std::uint64_t bytesFor(std::uint64_t pixels, bool drawing);

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

  /// Transmittance from the light to a point of the light's view space, between four pixels. requires: finished.
  float transmittance(const glm::vec3& light_point) const {
    const float scale = perspective_ ? focal_ / light_point.z : focal_;
    const float x = std::clamp(centre_x_ + scale * light_point.x, 0.0f, last_x_),
                y = std::clamp(centre_y_ + scale * light_point.y, 0.0f, last_y_);
    const int x0 = std::min(static_cast<int>(x), view_.size.width - 2),
              y0 = std::min(static_cast<int>(y), view_.size.height - 2);
    const float depth = std::clamp((light_point.z - near_) * per_depth_, 0.0f, kSteps);
    const Knots* const above = &pixels_[placeOf(x0, y0)];
    const Knots* const below = above + view_.size.width;
    // Most samples see the light: nothing lies in front of them.
    const auto passed = static_cast<std::uint16_t>(depth);
    if (above[0].z[0] > passed && above[1].z[0] > passed && below[0].z[0] > passed && below[1].z[0] > passed) return 1;
    const float fx = x - static_cast<float>(x0), fy = y - static_cast<float>(y0);
    const auto along = [&](const Knots* pixel) {
      const float t = transmittanceAt(pixel[0], depth);
      return t + fx * (transmittanceAt(pixel[1], depth) - t);
    };
    const float upper = along(above);
    return upper + fy * (along(below) - upper);
  }

 private:
  // Sorted by depth; a pixel with fewer knots repeats the last transmittance at the greatest depth.
  struct alignas(64) Knots {
    std::array<std::uint16_t, kShadowKnots> z, t;
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
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(view_.size.width) + static_cast<std::size_t>(x);
  }
  void addPoint(const Point& point, Column& column, Knots& knots) const;
  void addKnot(const Point& point, Column& column, Knots& knots) const;
  static float transmittanceAt(const Knots& knots, float depth) {
    const auto whole = static_cast<std::uint16_t>(depth);
    std::uint16_t passed = 0;
    for (const std::uint16_t z : knots.z) passed = static_cast<std::uint16_t>(passed + (z <= whole ? 1 : 0));
    if (passed == 0) return 1;
    if (passed == kShadowKnots) return static_cast<float>(knots.t.back()) / kSteps;
    const float z = knots.z[passed - 1u], t = knots.t[passed - 1u];
    const float part = (depth - z) / (static_cast<float>(knots.z[passed]) - z);
    return (t + part * (static_cast<float>(knots.t[passed]) - t)) / kSteps;
  }

  static constexpr float kSteps = std::numeric_limits<std::uint16_t>::max();

  View view_;
  bool perspective_;
  float focal_, centre_x_, centre_y_, last_x_, last_y_;  // unit: pixels, from the middle of the first
  float near_, per_depth_;                               // unit: steps of a knot's depth per world unit
  std::vector<Knots> pixels_;
  std::vector<Column> columns_;  // until finished
};

}  // namespace kiln
