#include "splat/project_brick.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kiln {
namespace {

// From a to b. A voxel without weight is neither: it may be NaN. A fraction has no more bits than a float, so that of
// values that have none more either the result is never rounded beyond them, and no range is left.
double between(double a, double b, double fraction) { return fraction == 0 ? a : a + fraction * (b - a); }

template <class T>
class BrickRays {
 public:
  BrickRays(const RayFrame& frame, const BrickBlock& block, bool all, ProjectedValues& values, SplatCounts& counts)
      : f_(frame),
        block_(block),
        voxels_(block.data<T>()),
        stride_y_(block.strideY()),
        stride_z_(block.strideZ()),
        all_(all),
        sign_(values.sign()),
        counts_(counts) {}

  template <bool kMean>
  void take(const PixelSlabs& ray, const SlabSpan& span, double& held, double* length) const noexcept {
    counts_.visited += static_cast<std::uint64_t>(span.end - span.first);
    for (int slab = span.first; slab < span.end;) {
      VoxelCoord cell;
      const glm::dvec3 place = at(ray, slab);
      for (int axis = 0; axis < 3; ++axis) {
        // Rounding may put a sample on a face beyond it, where it has the same voxels.
        const auto voxel = std::clamp(static_cast<std::int64_t>(std::floor(place[axis] + 0.5)), block_.core.lo[axis],
                                      block_.core.hi[axis] - 1);
        cell[axis] = (voxel - block_.core.lo[axis]) / kCellSize;
      }
      const ValueRange& range =
          block_.supports.at(static_cast<int>(cell.x) + 1, static_cast<int>(cell.y) + 1, static_cast<int>(cell.z) + 1);
      const int leaves = std::clamp(slabBeyond(ray, cell), slab + 1, span.end);
      ++counts_.nodes_tested;
      if (range.empty() || (!kMean && !all_ && !((sign_ > 0 ? range.hi : -range.lo) > held))) {
        ++counts_.nodes_hidden;
        slab = leaves;
        continue;
      }
      counts_.splats += static_cast<std::uint64_t>(leaves - slab);
      for (; slab < leaves; ++slab) {
        const double value = valueAt(at(ray, slab));
        if constexpr (kMean) {
          if (std::isnan(value)) continue;
          held += value * f_.zone.thickness;
          *length += f_.zone.thickness;
          counts_.changed = true;
        } else if (sign_ * value > held) {
          held = sign_ * value;
          counts_.changed = true;
        }
      }
    }
  }

 private:
  glm::dvec3 at(const PixelSlabs& ray, int slab) const {
    return ray.base() + (f_.zone.near + (slab + 0.5) * f_.zone.thickness) * ray.slope();
  }

  // The first slab after the ray has left the cell.
  int slabBeyond(const PixelSlabs& ray, const VoxelCoord& cell) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      const double slope = ray.slope()[axis];
      if (slope == 0) continue;
      const std::int64_t face = block_.core.lo[axis] + (cell[axis] + (slope > 0 ? 1 : 0)) * kCellSize;
      nearest = std::min(nearest, (static_cast<double>(face) - 0.5 - ray.base()[axis]) / slope);
    }
    return f_.zone.slabFrom(nearest);
  }

  double valueAt(const glm::dvec3& place) const {
    VoxelCoord voxel;
    double part[3];
    for (int axis = 0; axis < 3; ++axis) {
      const double lower = std::floor(place[axis]);
      voxel[axis] = static_cast<std::int64_t>(lower);
      part[axis] = static_cast<float>(place[axis] - lower);
    }
    const T* const v = voxels_ + block_.offsetOf(voxel);
    const auto along_x = [&](std::int64_t i) {
      return between(static_cast<double>(v[i]), static_cast<double>(v[i + 1]), part[0]);
    };
    const double front = between(along_x(0), along_x(stride_y_), part[1]);
    const double back = between(along_x(stride_z_), along_x(stride_z_ + stride_y_), part[1]);
    return between(front, back, part[2]);
  }

  const RayFrame& f_;
  const BrickBlock& block_;
  const T* const voxels_;
  const std::int64_t stride_y_, stride_z_;
  const bool all_;
  const double sign_;
  SplatCounts& counts_;
};

// Calls take(ray, span, held, length) for each pixel of `rect` that may change and has samples in `core`; `length` is
// null but for means.
template <class Take>
void forEachRay(const RayFrame& frame, const VoxelBox& core, double bound, bool all, const PixelRect& rect,
                ProjectedValues& values, const Take& take) noexcept {
  for (int y = rect.y0; y < rect.y1; ++y) {
    double* const held = values.held(rect.x0, y);
    double* const length = values.mean() ? values.length(rect.x0, y) : nullptr;
    for (int x = rect.x0; x < rect.x1; ++x) {
      const int i = x - rect.x0;
      if (length == nullptr && (std::isnan(held[i]) || (!all && !(bound > held[i])))) continue;
      const PixelSlabs ray(frame.zone, *frame.projector, x, y);
      const SlabSpan span = samplesIn(frame, ray, core);
      if (!span.empty()) take(ray, span, held[i], length == nullptr ? nullptr : length + i);
    }
  }
}

}  // namespace

SlabSpan samplesIn(const RayFrame& frame, const PixelSlabs& ray, const VoxelBox& box) {
  const SlabZone& zone = frame.zone;
  SlabSpan out{frame.projector->perspective() ? zone.slabFrom(frame.projector->nearDepth()) : 0, zone.slabs};
  for (int axis = 0; axis < 3; ++axis) {
    ray.cut(axis, static_cast<double>(box.lo[axis]) - 0.5, true, out);
    // The last voxel of a coarser level may reach beyond level 0.
    const bool last = box.hi[axis] == frame.dims[axis];
    ray.cut(axis, last ? frame.end[axis] : static_cast<double>(box.hi[axis]) - 0.5, false, out);
  }
  if (out.empty() || frame.clip->showsAll()) return out;
  double near = -std::numeric_limits<double>::infinity(), far = -near;
  frame.clip->cutLine(ray.base(), ray.slope(), near, far);
  return {std::max(out.first, zone.slabFrom(near)), std::min(out.end, zone.slabFrom(far))};
}

void projectBrick(const RayFrame& frame, const BrickBlock& block, double bound, bool all, const PixelRect& rect,
                  ProjectedValues& values, SplatCounts& counts) noexcept {
  withVoxelType(block.type, [&]<class T>(std::type_identity<T>) {
    const BrickRays<T> rays(frame, block, all, values, counts);
    forEachRay(frame, block.core, bound, all, rect, values,
               [&](const PixelSlabs& ray, const SlabSpan& span, double& held, double* length) {
                 if (length != nullptr)
                   rays.template take<true>(ray, span, held, length);
                 else
                   rays.template take<false>(ray, span, held, nullptr);
               });
  });
}

void projectConstant(const RayFrame& frame, const VoxelBox& core, double value, const PixelRect& rect,
                     ProjectedValues& values, SplatCounts& counts) noexcept {
  const double bound = values.sign() * value;
  forEachRay(frame, core, bound, false, rect, values,
             [&](const PixelSlabs&, const SlabSpan& span, double& held, double* length) {
               counts.visited += static_cast<std::uint64_t>(span.end - span.first);
               counts.changed = true;
               if (length == nullptr) {
                 held = bound;
                 return;
               }
               // As sample after sample of such a brick would, to the bit.
               for (int slab = span.first; slab < span.end; ++slab) {
                 held += value * frame.zone.thickness;
                 *length += frame.zone.thickness;
               }
             });
}

}  // namespace kiln
