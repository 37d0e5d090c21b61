#include "phantom/models/figure.h"

#include <algorithm>
#include <cassert>

#include "phantom/models/labyrinth.h"

namespace kiln::phantom {
namespace {

bool within(const Shape& a, const Shape& b, float mm) {
  for (int i = 0; i < 3; ++i) {
    if (std::abs(a.centre[i] - b.centre[i]) > a.extent[i] + b.extent[i] + mm) return false;
  }
  return true;
}

// Bounds the distance from its box at which a shape affects a surface of its part. The decisive blend is the shape's
// own, or that of a later shape that joins it. The influence ends within five quarters of this blend from the surface
// of the union. A carving shape also reaches through its shell.
float reachOf(std::span<const Shape> part, std::size_t i) {
  float blend = part[i].blend;
  for (std::size_t j = i + 1; j < part.size(); ++j) {
    if (within(part[i], part[j], 2 * part[j].blend)) blend = std::max(blend, part[j].blend);
  }
  return 1.5f * blend + (part[i].carves ? part[i].shell : 0.f);
}

}  // namespace

void addPair(PartList& parts, const std::string& name, const Layers& layers, const std::vector<ShapeSpec>& shapes) {
  parts.push_back({"left " + name, layers, shapes, {}});
  PartSpec& right = parts.emplace_back(PartSpec{"right " + name, layers, {}, {}});
  for (const ShapeSpec& shape : shapes) right.shapes.push_back(shape.mirrored());
}

std::vector<ShapeSpec> bothSides(const std::vector<ShapeSpec>& shapes) {
  std::vector<ShapeSpec> out;
  for (const ShapeSpec& shape : shapes) {
    out.push_back(shape);
    out.push_back(shape.mirrored());
  }
  return out;
}

Figure::Figure(const PartList& specs) {
  for (const PartSpec& spec : specs) {
    assert(!spec.shapes.empty() && !spec.shapes.front().carves);
    parts_.push_back({spec.name, spec.layers, shapes_.size(), spec.shapes.size(), spec.folds});
    for (const ShapeSpec& shape : spec.shapes) shapes_.push_back(prepared(shape));
  }
  reaches_.resize(shapes_.size());
  for (const Part& part : parts_) {
    const std::span<const Shape> own = std::span<const Shape>(shapes_).subspan(part.first, part.count);
    for (std::size_t i = 0; i < part.count; ++i) reaches_[part.first + i] = reachOf(own, i);
  }
}

Figure::Depth Figure::depthIn(const Part& part, const glm::vec3& p) const {
  Depth depth{};
  for (std::size_t i = part.first; i < part.first + part.count; ++i) {
    const Shape& shape = shapes_[i];
    const float d = distanceTo(shape, p.x, p.y, p.z);
    if (i == part.first) {
      depth = {d, d + shape.shell};
    } else {
      depth = {joined(shape, depth.outer, d, 0), joined(shape, depth.inner, d, shape.shell)};
    }
  }
  if (part.folds.depth_mm > 0) {
    depth.outer = Labyrinth(part.folds).cut(depth.outer, p.x, p.y, p.z);
    depth.inner = depth.outer + shapes_[part.first].shell;
  }
  return depth;
}

Place Figure::placeAt(const glm::vec3& p) const {
  for (PartId id = parts_.size(); id-- > 0;) {
    const Part& part = parts_[id];
    const Depth depth = depthIn(part, p);
    if (!(depth.outer < 0)) continue;
    if (depth.inner < 0) return {id, part.layers.inner};
    return {id, depth.outer + static_cast<float>(part.layers.rind_mm) < 0 ? part.layers.outer : part.layers.rind};
  }
  return {};
}

const Part* Figure::find(std::string_view name) const {
  const auto it = std::find_if(parts_.begin(), parts_.end(), [&](const Part& part) { return part.name == name; });
  return it == parts_.end() ? nullptr : &*it;
}

}  // namespace kiln::phantom
