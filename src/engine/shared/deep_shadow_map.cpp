#include "engine/shared/deep_shadow_map.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kiln {
namespace {

// Slope of a line that has no point yet. unit: transmittance per world unit.
constexpr float kSteep = 1e30f;

}  // namespace

DeepShadowMap::DeepShadowMap(const View& light, const DepthRange& depths)
    : view_(light),
      frame_{light.projection == Projection::kPerspective,
             light.size.width,
             light.size.height,
             shadowStride(light.size.width),
             static_cast<float>(light.focal_px),
             static_cast<float>(light.centre_px.x - 0.5),
             static_cast<float>(light.centre_px.y - 0.5),
             static_cast<float>(light.size.width - 1),
             static_cast<float>(light.size.height - 1),
             static_cast<float>(depths.near),
             static_cast<float>(kSteps / (depths.far - depths.near))} {
  const std::size_t pixels = placeOf(0, light.size.height);
  Knots clear;
  clear.z.fill(std::numeric_limits<std::uint16_t>::max());
  clear.t.fill(std::numeric_limits<std::uint16_t>::max());
  pixels_.assign(pixels, clear);
  columns_.resize(pixels);
}

std::uint64_t DeepShadowMap::bytesFor(int width, int height, bool drawing) {
  const auto places = static_cast<std::uint64_t>(shadowStride(width)) * static_cast<std::uint64_t>(height);
  return places * (sizeof(Knots) + sizeof(std::int32_t) + (drawing ? sizeof(Column) : 0));
}

void DeepShadowMap::addPoint(const Point& point, Column& column, Knots& knots) const {
  if (column.knots == 0) {
    addKnot(point, column, knots);
    return;
  }
  const auto slope = [&](float t) { return (t - column.start.t) / std::max(point.z - column.start.z, 1e-30f); };
  const float least = slope(point.t - kShadowError), most = slope(point.t + kShadowError);
  if (std::max(least, column.least) <= std::min(most, column.most)) {
    column.least = std::max(least, column.least), column.most = std::min(most, column.most);
    column.end = point;
    return;
  }
  const float middle = 0.5f * (column.least + column.most);
  const float t = column.start.t + middle * (column.end.z - column.start.z);
  addKnot({column.end.z, std::clamp(t, 0.0f, 1.0f)}, column, knots);
  addPoint(point, column, knots);
}

void DeepShadowMap::addKnot(const Point& point, Column& column, Knots& knots) const {
  if (column.knots == kShadowKnots) {
    // Removing a knot changes the polyline most at the knot's depth.
    int least_at = 1;
    float least = 2 * kSteps;
    for (std::size_t i = 1; i + 1 < kShadowKnots; ++i) {
      const float before = knots.z[i - 1], span = knots.z[i + 1] - before;
      const float part = span > 0 ? (knots.z[i] - before) / span : 0;
      const float line = std::lerp(static_cast<float>(knots.t[i - 1]), static_cast<float>(knots.t[i + 1]), part);
      const float change = std::abs(line - knots.t[i]);
      if (change < least) least = change, least_at = static_cast<int>(i);
    }
    std::copy(knots.z.begin() + least_at + 1, knots.z.end(), knots.z.begin() + least_at);
    std::copy(knots.t.begin() + least_at + 1, knots.t.end(), knots.t.begin() + least_at);
    --column.knots;
  }
  const auto place = static_cast<std::size_t>(column.knots++);
  const auto rounded = [](float v) { return static_cast<std::uint16_t>(std::lround(std::clamp(v, 0.0f, kSteps))); };
  knots.z[place] = rounded((point.z - frame_.near) * frame_.per_depth);
  knots.t[place] = rounded(point.t * kSteps);
  column.start = column.end = point;
  column.least = -kSteep, column.most = kSteep;
}

void DeepShadowMap::finish() {
  for (std::size_t i = 0; i < pixels_.size(); ++i) {
    Column& column = columns_[i];
    Knots& knots = pixels_[i];
    if (column.knots == 0) continue;
    if (column.end.z > column.start.z) addKnot(column.end, column, knots);
    for (auto k = static_cast<std::size_t>(column.knots); k < kShadowKnots; ++k) {
      knots.z[k] = std::numeric_limits<std::uint16_t>::max();
      knots.t[k] = knots.t[k - 1];
    }
  }
  columns_ = {};
  findSpans();
}

std::uint16_t DeepShadowMap::darkAfter(const Knots& knots) {
  std::uint16_t out = std::numeric_limits<std::uint16_t>::max();
  for (std::size_t k = kShadowKnots; k-- > 0 && knots.t[k] == 0;) out = knots.z[k];
  return out;
}

void DeepShadowMap::findSpans() {
  spans_.assign(pixels_.size(), 0);
  const std::size_t below = placeOf(0, 1);
  for (int y = 0; y + 1 < frame_.height; ++y) {
    for (int x = 0; x + 1 < frame_.width; ++x) {
      const std::size_t place = placeOf(x, y);
      std::uint32_t first = std::numeric_limits<std::uint16_t>::max(), dark = 0;
      for (const std::size_t beside : {std::size_t{0}, std::size_t{1}, below, below + 1}) {
        const Knots& knots = pixels_[place + beside];
        first = std::min<std::uint32_t>(first, knots.z[0]);
        dark = std::max<std::uint32_t>(dark, darkAfter(knots));
      }
      spans_[place] = static_cast<std::int32_t>(first | dark << 16);
    }
  }
}

}  // namespace kiln
