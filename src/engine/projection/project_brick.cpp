#include "engine/projection/project_brick.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "engine/shared/brick_cells.h"
#include "engine/shared/brick_extremum.h"
#include "engine/shared/interpolated_brick.h"

namespace kiln {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Clips the ray to a box of voxels, the volume and the clip region. A box and its neighbour compute their common plane
// with equal operations, so that no sample is in both boxes.
DepthSpan partIn(const RayFrame& frame, const PixelRay& ray, const VoxelBox& box) {
  glm::dvec3 lo, hi;
  for (int axis = 0; axis < 3; ++axis) {
    lo[axis] = static_cast<double>(box.lo[axis]) - 0.5;
    // The last voxel of a coarser level may reach beyond the end of level 0.
    hi[axis] = box.hi[axis] == frame.dims[axis] ? frame.end[axis] : static_cast<double>(box.hi[axis]) - 0.5;
  }
  const double nearest = frame.projector->perspective() ? frame.projector->nearDepth() : -kInfinity;
  DepthSpan out = ray.inIndexSpace().within(lo, hi, {nearest, kInfinity});
  if (!frame.clip->showsAll()) frame.clip->cutLine(ray.base(), ray.slope(), out.near, out.far);
  return out;
}

SlabSpan slabsOf(const SlabZone& zone, const DepthSpan& part) {
  if (part.far <= zone.near || part.near >= zone.far) return {};
  return {zone.slabFrom(part.near), zone.slabFrom(part.far)};
}

// Returns true if the interval contains the middle of a slab of any zone.
bool hasMiddle(const RayFrame& frame, const DepthSpan& part) {
  return std::any_of(frame.zones.begin(), frame.zones.end(),
                     [&](const SlabZone& zone) { return !slabsOf(zone, part).empty(); });
}

// Returns a slab that covers all of `whole` if `whole` passes between the samples of all zones, as in a clip region
// thinner than the sample distance. The slab's sample is at the middle of `whole`.
std::optional<SlabZone> shortRay(const RayFrame& frame, const DepthSpan& whole) {
  if (whole.empty() || hasMiddle(frame, whole)) return std::nullopt;
  const SlabZone slab{whole.near, whole.far, whole.far - whole.near, 1};
  const double middle = whole.near + 0.5 * slab.thickness;
  const bool drawn = std::any_of(frame.zones.begin(), frame.zones.end(),
                                 [&](const SlabZone& zone) { return zone.near <= middle && middle < zone.far; });
  return drawn ? std::optional(slab) : std::nullopt;
}

// Returns the weight of a sample in a mean: the slab's thickness, or for the first and last slab of a ray the part
// inside `whole`.
double lengthOf(const SlabZone& zone, int slab, const DepthSpan& whole) {
  const double begin = zone.near + slab * zone.thickness, end = begin + zone.thickness;
  const bool first = begin - 0.5 * zone.thickness < whole.near, last = end + 0.5 * zone.thickness >= whole.far;
  return (last ? whole.far : end) - (first ? whole.near : begin);
}

enum class Rule { kMean, kAttenuated };

// Takes a sample of a mean or of an attenuated maximum. `length`: of the sample, along the ray. Equations (5), (7).
template <Rule kRule>
bool takeSample(const Attenuation& attenuation, double value, double length, double& held, double& sum) {
  if constexpr (kRule == Rule::kMean) {
    held += value * length;
    sum += length;
    return true;
  } else {
    const double share = attenuation.share(value), depth = attenuation.per_length * length * share;
    const double weighted = share * std::exp(-(sum + 0.5 * depth));
    sum += depth;
    const bool changes = weighted > held;
    held = changes ? weighted : held;
    return changes || depth > 0;
  }
}

// Weights of a mean are depths; attenuation has lengths along the ray.
template <Rule kRule>
double sampleLength(const PixelRay& ray, double depth) {
  return kRule == Rule::kAttenuated ? depth * ray.oblique() : depth;
}

// Takes the samples of a brick along rays, front to back.
template <class T, Rule kRule>
class BrickSamples {
 public:
  BrickSamples(const BrickBlock& block, bool all, const Attenuation& attenuation, DrawCounts& counts)
      : attenuation_(attenuation), cells_(block), field_(block), all_(all), counts_(counts) {}

  // Takes the samples of `span`. `whole`: the ray's interval in the whole volume.
  void take(const PixelRay& ray, const DepthSpan& whole, const SlabZone& zone, const SlabSpan& span, double& held,
            double& length) noexcept {
    counts_.visited += static_cast<std::uint64_t>(span.end - span.first);
    const glm::dvec3 base = cells_.placeOf(ray.base()), inverse = 1.0 / ray.slope();
    const double slabs_per_depth = 1 / zone.thickness;
    for (int slab = span.first; slab < span.end;) {
      const glm::dvec3 place = base + depthOf(zone, slab) * ray.slope();
      int cell[3];
      double leaves_at = kInfinity;
      for (int axis = 0; axis < 3; ++axis) {
        cell[axis] = cells_.cellAt(axis, place[axis]);
        if (ray.slope()[axis] == 0) continue;
        const int face = BrickCells::faceBehind(cell[axis], ray.slope()[axis] > 0);
        leaves_at = std::min(leaves_at, (face - base[axis]) * inverse[axis]);
      }
      const double beyond = std::clamp((leaves_at - zone.near) * slabs_per_depth + 0.5, slab + 1.0, span.end + 0.0);
      const int leaves = static_cast<int>(beyond);
      ++counts_.nodes_tested;
      if (kRule == Rule::kAttenuated && !all_ && !(std::exp(-length) > held)) return;
      if (cells_.range(cell).empty()) {
        ++counts_.nodes_hidden;
        slab = leaves;
        continue;
      }
      counts_.splats += static_cast<std::uint64_t>(leaves - slab);
      for (; slab < leaves; ++slab) {
        const double value = field_.valueAt(ray.base() + depthOf(zone, slab) * ray.slope());
        if (std::isnan(value)) continue;
        const double part = sampleLength<kRule>(ray, lengthOf(zone, slab, whole));
        if (takeSample<kRule>(attenuation_, value, part, held, length)) counts_.changed = true;
      }
    }
  }

 private:
  static double depthOf(const SlabZone& zone, int slab) { return zone.near + (slab + 0.5) * zone.thickness; }

  const Attenuation& attenuation_;
  const BrickCells cells_;
  const InterpolatedBrick<T> field_;
  const bool all_;
  DrawCounts& counts_;
};

// Calls visit(ray, part, held, place in the row) for each pixel of `rect` whose ray has a part in `core`, unless the
// pixel is left out, or full(held).
template <class Full, class Visit>
void forEachRay(const RayFrame& frame, const VoxelBox& core, const PixelRect& rect, ProjectedValues& values, Full full,
                Visit visit) noexcept {
  for (int y = rect.y0; y < rect.y1; ++y) {
    double* const held = values.held(rect.x0, y);
    const Silhouette::Row outline = frame.outline->row(y);
    for (int i = 0; i < rect.width(); ++i) {
      if (std::isnan(held[i]) || full(held[i])) continue;
      const Silhouette::Part covered = outline.at(rect.x0 + i);
      if (covered.share == 0) continue;
      const PixelRay ray(*frame.projector, covered.middle);
      const DepthSpan part = partIn(frame, ray, core);
      if (!part.empty()) visit(ray, part, held[i], rect.x0 + i, y);
    }
  }
}

// Calls take(ray, whole, zone, span, held, length) for each pixel of `rect` and each zone with samples in `core`.
// `whole` is the ray's interval in the whole volume.
template <class Take>
void forEachSpan(const RayFrame& frame, const VoxelBox& core, const PixelRect& rect, ProjectedValues& values,
                 Take take) noexcept {
  const auto visit = [&](const PixelRay& ray, const DepthSpan& part, double& held, int x, int y) {
    const DepthSpan whole = partIn(frame, ray, boxOf(frame.dims));
    double& length = *values.length(x, y);
    bool taken = false;
    for (const SlabZone& zone : frame.zones) {
      const SlabSpan span = slabsOf(zone, part);
      if (span.empty()) continue;
      take(ray, whole, zone, span, held, length);
      taken = true;
    }
    if (taken) return;
    const std::optional<SlabZone> slab = shortRay(frame, whole);
    if (slab && !slabsOf(*slab, part).empty()) take(ray, whole, *slab, {0, 1}, held, length);
  };
  forEachRay(
      frame, core, rect, values, [](double) { return false; }, visit);
}

// Calls take(ray, stretch, held) for each pixel of `rect` that a value of `bound` may change, and each part of the ray
// in `core` and in a zone.
template <class Take>
void forEachStretch(const RayFrame& frame, const VoxelBox& core, double bound, bool all, const PixelRect& rect,
                    ProjectedValues& values, Take take) noexcept {
  const auto visit = [&](const PixelRay& ray, const DepthSpan& part, double& held, int, int) {
    const DepthSpan whole = partIn(frame, ray, boxOf(frame.dims));
    for (const DepthSpan& depths : frame.depths) {
      // The ends of a ray and of a level's depths belong to the brick that reaches there.
      const RayStretch stretch{{std::max(part.near, depths.near), std::min(part.far, depths.far)},
                               part.near == whole.near || depths.near >= part.near,
                               part.far == whole.far || depths.far <= part.far};
      if (!stretch.depths.empty()) take(ray.inIndexSpace(), stretch, held);
    }
  };
  forEachRay(
      frame, core, rect, values, [&](double held) { return !all && !(bound > held); }, visit);
}

}  // namespace

bool hasValue(const RayFrame& frame, PixelValue held, const glm::dvec2& place) {
  const DepthSpan part = partIn(frame, PixelRay(*frame.projector, place), boxOf(frame.dims));
  if (part.empty()) return false;
  if (takesInOrder(held)) return hasMiddle(frame, part) || shortRay(frame, part);
  return std::any_of(frame.depths.begin(), frame.depths.end(),
                     [&](const DepthSpan& depths) { return depths.near < part.far && part.near < depths.far; });
}

void projectBrick(const RayFrame& frame, const BrickBlock& block, double bound, bool all, const PixelRect& rect,
                  ProjectedValues& values, DrawCounts& counts) noexcept {
  withVoxelType(block.type, [&]<class T>(std::type_identity<T>) {
    const auto sample = [&](auto rays) {
      forEachSpan(frame, block.core, rect, values,
                  [&](const PixelRay& ray, const DepthSpan& whole, const SlabZone& zone, const SlabSpan& span,
                      double& held, double& length) { rays.take(ray, whole, zone, span, held, length); });
    };
    const auto raise = [&](auto extremum) {
      forEachStretch(
          frame, block.core, bound, all, rect, values,
          [&](const IndexRay& ray, const RayStretch& part, double& held) { extremum.take(ray, part, held); });
    };
    switch (values.rule()) {
      case PixelValue::kMean:
        return sample(BrickSamples<T, Rule::kMean>(block, all, values.attenuation(), counts));
      case PixelValue::kAttenuated:
        return sample(BrickSamples<T, Rule::kAttenuated>(block, all, values.attenuation(), counts));
      case PixelValue::kGreatest:
        return raise(BrickExtremum<T, false>(block, all, counts));
      case PixelValue::kLeast:
        return raise(BrickExtremum<T, true>(block, all, counts));
    }
  });
}

void projectConstant(const RayFrame& frame, const VoxelBox& core, double value, const PixelRect& rect,
                     ProjectedValues& values, DrawCounts& counts) noexcept {
  if (!values.accumulates()) {
    const double bound = values.sign() * value;
    return forEachStretch(frame, core, bound, false, rect, values,
                          [&](const IndexRay&, const RayStretch&, double& held) {
                            ++counts.visited;
                            counts.changed = true;
                            held = bound;
                          });
  }
  forEachSpan(frame, core, rect, values,
              [&](const PixelRay& ray, const DepthSpan& whole, const SlabZone& zone, const SlabSpan& span, double& held,
                  double& length) {
                counts.visited += static_cast<std::uint64_t>(span.end - span.first);
                counts.changed = true;
                // Add sample by sample as projectBrick would, for equal bits.
                for (int slab = span.first; slab < span.end; ++slab) {
                  const double part = lengthOf(zone, slab, whole);
                  if (values.mean())
                    takeSample<Rule::kMean>(values.attenuation(), value, part, held, length);
                  else
                    takeSample<Rule::kAttenuated>(values.attenuation(), value,
                                                  sampleLength<Rule::kAttenuated>(ray, part), held, length);
                }
              });
}

}  // namespace kiln
