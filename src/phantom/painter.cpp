// Two roads by what is near: a block that one solid holds whole takes that part's inner tissue from it; elsewhere the
// distances of the near shapes are computed for 512 voxels at a time, from the part of highest precedence down, until
// nothing shines through.
// A shape is near where the block comes closer to the box around it than its reach; beyond, it has no say (shape.h:
// `smoothMin` is exactly the least there).
#include "phantom/painter.h"

#include <algorithm>

#include "phantom/labyrinth.h"

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

void distances(const Shape& shape, Work& work) noexcept {
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

// union = join(union, d), at `depth` below the surface.
void join(const Shape& shape, float depth, bool first, Work& work, float* surface) noexcept {
  const float* const d = work.d;
  const float blend = shape.blend, inverse = blend > 0 ? 1 / blend : 0.f;
  if (first) {
    work.rows([&](int at) {
      for (int i = at; i < at + kEdge; ++i) surface[i] = d[i] + depth;
    });
  } else if (shape.carves) {
    work.rows([&](int at) {
      for (int i = at; i < at + kEdge; ++i) surface[i] = -smoothMin(-surface[i], d[i] - depth, blend, inverse);
    });
  } else {
    work.rows([&](int at) {
      for (int i = at; i < at + kEdge; ++i) surface[i] = smoothMin(surface[i], d[i] + depth, blend, inverse);
    });
  }
}

// Gives what is left of each voxel to a tissue by its coverage: all where the voxel's centre is half a voxel or more
// inside the surface, nothing where it is half a voxel outside, linear between.
void give(float tissue_value, const float* surface, float offset, float inverse_blur, Work& work) noexcept {
  work.rows([&](int at) {
    for (int i = at; i < at + kEdge; ++i) {
      const float covered = std::min(std::max(0.5f - (surface[i] + offset) * inverse_blur, 0.f), 1.f);
      work.value[i] += work.left[i] * covered * tissue_value;
      work.left[i] *= 1 - covered;
    }
  });
}

// Cuts a part's folds into the union of its shapes.
void fold(const Folds& folds, float shell, Work& work) noexcept {
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

bool nothingLeft(Work& work) noexcept {
  float most = 0;
  work.rows([&](int at) {
    for (int i = at; i < at + kEdge; ++i) most = std::max(most, work.left[i]);
  });
  return most == 0;
}

// How far below a solid's surface nothing but the part's inner tissue is.
float crust(const Part& part, const Shape& shape) {
  return (part.layered() ? shape.shell : static_cast<float>(part.layers.rind_mm)) +
         static_cast<float>(part.folds.depth_mm);
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

bool Painter::isNear(std::size_t index, const Ball& ball) const {
  const Shape& shape = figure_.shapes()[index];
  const float reach = figure_.reaches()[index] + blur_;
  for (int i = 0; i < 3; ++i) {
    if (std::abs(ball.centre[i] - shape.centre[i]) > ball.half[i] + shape.extent[i] + reach) return false;
  }
  // The distance of an unstretched shape grows no faster than the way to it.
  if (shape.kind == ShapeKind::kStretchedCone) return true;
  return distanceTo(shape, ball.centre[0], ball.centre[1], ball.centre[2]) < ball.radius + reach + 0.01f;
}

void Painter::choose(const VoxelBox& box, const NearShapes* from, NearShapes& out) const {
  const Ball ball = ballAround(box);
  out.clear();
  const auto add = [&](PartId part, std::size_t count, auto&& shapeAt) {
    const std::size_t first = out.shapes.size();
    for (std::size_t i = 0; i < count; ++i) {
      if (isNear(shapeAt(i), ball)) out.shapes.push_back(static_cast<std::uint32_t>(shapeAt(i)));
    }
    if (out.shapes.size() > first) out.parts.push_back({part, first, out.shapes.size() - first});
  };
  if (from) {
    for (const NearPart& p : from->parts)
      add(p.part, p.count, [&](std::size_t i) { return from->shapes[p.first + i]; });
    return;
  }
  const std::span<const Part> parts = figure_.parts();
  for (PartId id = parts.size(); id-- > 0;)
    add(id, parts[id].count, [&](std::size_t i) { return parts[id].first + i; });
}

// Whether one solid alone makes the part's inner tissue of the whole block: the union only goes deeper.
bool Painter::holdsBlock(const Part& part, const NearShapes& near, const NearPart& chosen, const Ball& ball,
                         Work& work) const noexcept {
  const Shape* deepest = nullptr;
  float depth = -(1.2f * ball.radius + blur_);
  for (std::size_t i = chosen.first; i < chosen.first + chosen.count; ++i) {
    const Shape& shape = figure_.shapes()[near.shapes[i]];
    if (shape.carves) return false;
    const float d = distanceTo(shape, ball.centre[0], ball.centre[1], ball.centre[2]) + crust(part, shape);
    if (d < depth) {
      depth = d;
      deepest = &shape;
    }
  }
  if (!deepest) return false;
  distances(*deepest, work);
  float highest = -1e9f;
  work.rows([&](int at) {
    for (int i = at; i < at + kEdge; ++i) highest = std::max(highest, work.d[i]);
  });
  return highest + crust(part, *deepest) < -blur_;
}

void Painter::paintPart(const NearShapes& near, const NearPart& chosen, const Ball& ball, Work& work) const noexcept {
  const Part& part = figure_.parts()[chosen.part];
  const Layers& layers = part.layers;
  if (holdsBlock(part, near, chosen, ball, work)) {
    const float value = values_.of(layers.inner);
    work.rows([&](int at) {
      for (int i = at; i < at + kEdge; ++i) {
        work.value[i] += work.left[i] * value;
        work.left[i] = 0;
      }
    });
    return;
  }
  bool first = true;
  for (std::size_t i = chosen.first; i < chosen.first + chosen.count; ++i) {
    const Shape& shape = figure_.shapes()[near.shapes[i]];
    if (first && shape.carves) continue;  // nothing there to take from
    distances(shape, work);
    join(shape, 0, first, work, work.outer);
    if (part.layered()) join(shape, shape.shell, first, work, work.inner);
    first = false;
  }
  if (first) return;
  if (part.folds.depth_mm > 0) fold(part.folds, figure_.shapes()[part.first].shell, work);
  if (part.layered()) give(values_.of(layers.inner), work.inner, 0, inverse_blur_, work);
  if (layers.rind_mm > 0) {
    give(values_.of(layers.outer), work.outer, static_cast<float>(layers.rind_mm), inverse_blur_, work);
    give(values_.of(layers.rind), work.outer, 0, inverse_blur_, work);
  } else {
    give(values_.of(layers.outer), work.outer, 0, inverse_blur_, work);
  }
}

void Painter::paint(const VoxelBox& block, const NearShapes& near, Work& work) const noexcept {
  const Ball ball = ballAround(block);
  work.rows([&](int at) {
    for (int i = at; i < at + kEdge; ++i) {
      work.value[i] = 0;
      work.left[i] = 1;
    }
  });
  for (const NearPart& chosen : near.parts) {
    paintPart(near, chosen, ball, work);
    if (nothingLeft(work)) return;
  }
  const float air = values_.of(Tissue::kAir);
  work.rows([&](int at) {
    for (int i = at; i < at + kEdge; ++i) work.value[i] += work.left[i] * air;
  });
}

}  // namespace kiln::phantom
