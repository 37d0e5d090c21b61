// Problem. A figure has hundreds of shapes; computing each distance for each voxel is too slow.
// Method. The distance to each near shape is bounded over a block, and so is each surface made by joining shapes. A
// layer whose surface is half a voxel away from every voxel covers all or nothing of the block. Otherwise distances are
// computed for 512 voxels at a time, only for shapes that change the joined surface. Parts are painted from the highest
// precedence down, until nothing is left of any voxel.
// A shape is near if the block is closer to the shape's box than its reach.
// Invariant. Skipped shapes change no bit: beyond its reach a shape does not affect `smoothMin`, which is there exactly
// the minimum (shape.h).
#include "phantom/painter.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "base/vectors.h"
#include "phantom/models/labyrinth.h"

namespace kiln::phantom {
namespace {

template <ShapeKind kKind>
void distances(const Shape& shape, Work& work) noexcept {
  const Shape s = shape;
  for (int k = work.lo_z; k < work.hi_z; ++k) {
    for (int j = work.lo_y; j < work.hi_y; ++j) {
      float* const d = work.d + (k * kEdge + j) * kEdge;
      const float y = work.y[j], z = work.z[k];
      for (int i = 0; i < kEdge; ++i) d[i] = distance<kKind>(s, work.x[i], y, z);
    }
  }
}

KILN_VECTORS void distances(const Shape& shape, Work& work) noexcept {
  switch (shape.kind) {
    case ShapeKind::kCone:
      return distances<ShapeKind::kCone>(shape, work);
    case ShapeKind::kStretchedCone:
      return distances<ShapeKind::kStretchedCone>(shape, work);
    case ShapeKind::kBox:
      return distances<ShapeKind::kBox>(shape, work);
    case ShapeKind::kCylinder:
      return distances<ShapeKind::kCylinder>(shape, work);
  }
}

// surface = join(surface, d), at `depth` below the surface.
KILN_VECTORS void join(const Shape& shape, float depth, bool first, Work& work, float* surface) noexcept {
  const float* const d = work.d;
  const float blend = shape.blend, inverse = blend > 0 ? 1 / blend : 0.f;
  if (first) {
    work.each([&](int i) { surface[i] = d[i] + depth; });
  } else if (shape.carves) {
    work.each([&](int i) { surface[i] = -smoothMin(-surface[i], d[i] - depth, blend, inverse); });
  } else {
    work.each([&](int i) { surface[i] = smoothMin(surface[i], d[i] + depth, blend, inverse); });
  }
}

// Gives a tissue its share of what is left of each voxel. The coverage is 1 if the voxel's centre is half a voxel or
// more inside the surface, 0 if half a voxel outside, and linear between.
KILN_VECTORS void give(float tissue_value, const float* surface, float offset, float inverse_blur,
                       Work& work) noexcept {
  work.each([&](int i) {
    const float covered = std::min(std::max(0.5f - (surface[i] + offset) * inverse_blur, 0.f), 1.f);
    work.value[i] += work.left[i] * covered * tissue_value;
    work.left[i] *= 1 - covered;
  });
}

// Cuts the folds of a part into the union of its shapes.
KILN_VECTORS void fold(const Folds& folds, float shell, Work& work) noexcept {
  const Labyrinth labyrinth(folds);
  for (int k = work.lo_z; k < work.hi_z; ++k) {
    for (int j = work.lo_y; j < work.hi_y; ++j) {
      const int at = (k * kEdge + j) * kEdge;
      for (int i = 0; i < kEdge; ++i) {
        const float cut = labyrinth.cut(work.outer[at + i], work.x[i], work.y[j], work.z[k]);
        work.outer[at + i] = cut;
        work.inner[at + i] = cut + shell;
      }
    }
  }
}

KILN_VECTORS bool nothingLeft(Work& work) noexcept {
  std::uint32_t bits = 0;  // no share is negative
  work.each([&](int i) { bits |= std::bit_cast<std::uint32_t>(work.left[i]); });
  return bits == 0;
}

// Gives all that is left of each voxel to a tissue. The shares are not used afterwards.
KILN_VECTORS void giveRest(float tissue_value, Work& work) noexcept {
  work.each([&](int i) { work.value[i] += work.left[i] * tissue_value; });
}

KILN_VECTORS void clear(Work& work) noexcept {
  work.each([&](int i) {
    work.value[i] = 0;
    work.left[i] = 1;
  });
}

constexpr float kRoundingMm = 0.02f;

Bounds operator+(const Bounds& b, float mm) { return {b.lo + mm, b.hi + mm}; }

// All distances except that of the stretched cone have gradients of length 1 at most.
Bounds boundsAround(float at_centre, const Ball& ball) {
  const float most = ball.radius + kRoundingMm;
  return {at_centre - most, at_centre + most};
}

// The distance of a stretched cone has a gradient of at most 1 in the cone's own space. The quotient that maps it back
// to world lengths is bounded as well.
Bounds boundsOfStretched(const Shape& s, const Ball& ball) {
  float local[3], radius2 = 0, out_lo = -1e9f, out_hi = -1e9f;
  for (int j = 0; j < 3; ++j) {
    const float* const row = s.row[j];
    local[j] = row[0] * ball.centre[0] + (row[1] * ball.centre[1] + (row[2] * ball.centre[2] + row[3]));
    const float half =
        std::abs(row[0]) * ball.half[0] + std::abs(row[1]) * ball.half[1] + std::abs(row[2]) * ball.half[2];
    radius2 += half * half;
    const float from_middle = std::abs(ball.centre[j] - s.centre[j]) - s.extent[j];
    out_lo = std::max(out_lo, from_middle - ball.half[j]);
    out_hi = std::max(out_hi, from_middle + ball.half[j]);
  }
  const float rho2 = local[0] * local[0] + local[1] * local[1];
  const float t = std::min(std::max(local[2] - std::sqrt(rho2) * s.slope, 0.f), s.length), rise = local[2] - t;
  const float d = std::sqrt(rho2 + rise * rise) - s.radius + s.cosine * t;
  const float radius = std::sqrt(radius2), lo = d - radius, hi = d + radius;
  // The quotient is (f + tiny) / (g + tiny), with f the length from the axis; the stretches bound g / f.
  const float most = std::max(s.stretch[0], std::max(s.stretch[1], s.stretch[2]));
  const float least = std::min(s.stretch[0], std::min(s.stretch[1], s.stretch[2]));
  const float f = std::max(lo + std::min(s.radius, s.radius - s.cosine * s.length), 0.f);
  const float quotient_lo = most < 1 ? (f + s.tiny) / (most * f + s.tiny) : 1 / most;
  const float quotient_hi = std::max(1 / least, 1.f);
  return {std::max(lo * (lo < 0 ? quotient_hi : quotient_lo), out_lo) - kRoundingMm,
          std::max(hi * (hi < 0 ? quotient_lo : quotient_hi), out_hi) + kRoundingMm};
}

// Bounds of the joined surface: smoothMin is monotone in both arguments.
Bounds joined(const Shape& shape, const Bounds& before, const Bounds& d, float depth) {
  if (shape.carves) {
    return {joined(shape, before.lo, d.hi, depth), joined(shape, before.hi, d.lo, depth)};
  }
  return {joined(shape, before.lo, d.lo, depth), joined(shape, before.hi, d.hi, depth)};
}

// True if the surface is the same without the shape, bit for bit.
bool isIdle(const Shape& shape, const Bounds& before, const Bounds& d, float depth) {
  if (shape.carves) return d.lo - depth + before.lo >= shape.blend;
  return d.lo + depth - before.hi >= shape.blend;
}

// True if the surface is the shape's alone, bit for bit.
bool isAlone(const Shape& shape, const Bounds& before, const Bounds& d, float depth) {
  return !shape.carves && before.lo - (d.hi + depth) >= shape.blend;
}

// Bounds of a part's surfaces in a block, and the first shape that affects the surfaces.
struct Surfaces {
  Bounds outer, inner;
  std::size_t first;
};
std::optional<Surfaces> surfacesOf(const Part& part, std::span<const NearShape> near, std::span<const Shape> shapes) {
  std::optional<Surfaces> out;
  for (std::size_t i = 0; i < near.size(); ++i) {
    const Shape& shape = shapes[near[i].index];
    const Bounds& d = near[i].distance;
    if (!out && shape.carves) continue;  // nothing to carve yet
    if (!out || (isAlone(shape, out->outer, d, 0) && isAlone(shape, out->inner, d, shape.shell))) {
      out = {d, d + shape.shell, i};
    } else {
      out->outer = joined(shape, out->outer, d, 0);
      out->inner = joined(shape, out->inner, d, shape.shell);
    }
  }
  if (out && part.folds.depth_mm > 0) {  // folds cut from the surface down to their depth
    out->outer.hi += static_cast<float>(part.folds.depth_mm);
    out->inner = out->outer + shapes[part.first].shell;
  }
  return out;
}

}  // namespace

Ball Painter::ballAround(const VoxelBox& box) const {
  const glm::vec3 lo = lattice_.centreOf(box.lo), hi = lattice_.centreOf({box.hi.x - 1, box.hi.y - 1, box.hi.z - 1});
  Ball ball{};
  float sum = 0;
  for (int i = 0; i < 3; ++i) {
    ball.centre[i] = 0.5f * (lo[i] + hi[i]);
    ball.half[i] = 0.5f * (hi[i] - lo[i]);
    sum += ball.half[i] * ball.half[i];
  }
  ball.radius = std::sqrt(sum);
  return ball;
}

bool Painter::isInReach(std::size_t index, const Ball& ball) const {
  const Shape& shape = figure_.shapes()[index];
  const float reach = figure_.reaches()[index] + blur_;
  for (int i = 0; i < 3; ++i) {
    if (std::abs(ball.centre[i] - shape.centre[i]) > ball.half[i] + shape.extent[i] + reach) return false;
  }
  return true;
}

std::optional<Bounds> Painter::boundsIfNear(std::size_t index, const Ball& ball) const {
  if (!isInReach(index, ball)) return std::nullopt;
  const Shape& shape = figure_.shapes()[index];
  if (shape.kind == ShapeKind::kStretchedCone) return boundsOfStretched(shape, ball);
  const float d = distanceTo(shape, ball.centre[0], ball.centre[1], ball.centre[2]);
  if (!(d < ball.radius + figure_.reaches()[index] + blur_ + 0.01f)) return std::nullopt;
  return boundsAround(d, ball);
}

void Painter::choose(const VoxelBox& box, NearShapes& out) const {
  const Ball ball = ballAround(box);
  const std::span<const Part> parts = figure_.parts();
  out.clear();
  for (PartId id = parts.size(); id-- > 0;) {
    const std::size_t first = out.shapes.size();
    for (std::size_t i = parts[id].first; i < parts[id].first + parts[id].count; ++i) {
      if (isInReach(i, ball)) out.shapes.push_back({static_cast<std::uint32_t>(i), {}});
    }
    if (out.shapes.size() > first) out.parts.push_back({id, first, out.shapes.size() - first});
  }
}

void Painter::choose(const VoxelBox& box, const NearShapes& from, NearShapes& out) const {
  const Ball ball = ballAround(box);
  out.clear();
  for (const NearPart& p : from.parts) {
    const std::size_t first = out.shapes.size();
    for (std::size_t i = p.first; i < p.first + p.count; ++i) {
      const std::uint32_t index = from.shapes[i].index;
      if (const auto distance = boundsIfNear(index, ball)) out.shapes.push_back({index, *distance});
    }
    if (out.shapes.size() > first) out.parts.push_back({p.part, first, out.shapes.size() - first});
  }
}

// Joins the near shapes voxel by voxel, from the first shape that affects the surfaces.
void Painter::computeSurfaces(const Part& part, std::span<const NearShape> near, bool inner,
                              Work& work) const noexcept {
  Bounds outer_bounds{}, inner_bounds{};
  bool first = true;
  for (const NearShape& n : near) {
    const Shape& shape = figure_.shapes()[n.index];
    const bool idle_outer = !first && isIdle(shape, outer_bounds, n.distance, 0);
    const bool idle_inner = !first && isIdle(shape, inner_bounds, n.distance, shape.shell);
    if (idle_outer && idle_inner) continue;
    distances(shape, work);
    join(shape, 0, first, work, work.outer);
    if (inner) join(shape, shape.shell, first, work, work.inner);
    outer_bounds = first ? n.distance : joined(shape, outer_bounds, n.distance, 0);
    inner_bounds = first ? n.distance + shape.shell : joined(shape, inner_bounds, n.distance, shape.shell);
    first = false;
  }
  if (part.folds.depth_mm > 0) fold(part.folds, figure_.shapes()[part.first].shell, work);
}

std::optional<Tissue> Painter::paintPart(const NearShapes& near, const NearPart& chosen, Work& work) const noexcept {
  const Part& part = figure_.parts()[chosen.part];
  const std::span<const NearShape> shapes = std::span(near.shapes).subspan(chosen.first, chosen.count);
  const std::optional<Surfaces> surfaces = surfacesOf(part, shapes, figure_.shapes());
  if (!surfaces) return std::nullopt;
  // From the deepest layer outwards, each at its depth below its surface.
  struct Layer {
    Tissue tissue;
    bool inner;  // uses the inner surface
    float below_mm;
    bool present;
  };
  const auto rind_mm = static_cast<float>(part.layers.rind_mm);
  const Layer layers[] = {{part.layers.inner, true, 0, part.layered()},
                          {part.layers.outer, false, rind_mm, true},
                          {part.layers.rind, false, 0, rind_mm > 0}};
  const auto boundsOf = [&](const Layer& layer) {
    return (layer.inner ? surfaces->inner : surfaces->outer) + layer.below_mm;
  };
  const auto coversNothing = [&](const Layer& layer) { return !layer.present || boundsOf(layer).lo > 0.5f * blur_; };
  const auto coversAll = [&](const Layer& layer) { return boundsOf(layer).hi < -0.5f * blur_; };
  bool computed = false;
  for (const Layer& layer : layers) {
    if (coversNothing(layer)) continue;
    if (coversAll(layer)) return layer.tissue;
    if (!computed) computeSurfaces(part, shapes.subspan(surfaces->first), part.layered(), work);
    computed = true;
    if (std::exchange(work.blank, false)) clear(work);
    give(values_.of(layer.tissue), layer.inner ? work.inner : work.outer, layer.below_mm, inverse_blur_, work);
  }
  return computed && nothingLeft(work) ? std::optional(Tissue::kAir) : std::nullopt;
}

std::optional<float> Painter::paint(const NearShapes& near, Work& work) const noexcept {
  work.blank = true;
  Tissue rest = Tissue::kAir;
  for (const NearPart& chosen : near.parts) {
    if (const std::optional<Tissue> all = paintPart(near, chosen, work)) {
      rest = *all;
      break;
    }
  }
  if (work.blank) return values_.of(rest);
  giveRest(values_.of(rest), work);
  return std::nullopt;
}

}  // namespace kiln::phantom
