#include "engine/projection/project_brick.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace kiln {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Interval of a ray inside a box of voxels, the volume and the clip region. unit: depth.
struct RayPart {
  double near, far;
  bool empty() const { return !(near < far); }
};

// Clips the ray. A box and its neighbour compute their common plane with equal operations, so that no sample is in both
// boxes.
RayPart partIn(const RayFrame& frame, const PixelRay& ray, const VoxelBox& box) {
  RayPart out{frame.projector->perspective() ? frame.projector->nearDepth() : -kInfinity, kInfinity};
  for (int axis = 0; axis < 3; ++axis) {
    const double base = ray.base()[axis], slope = ray.slope()[axis];
    const double lo = static_cast<double>(box.lo[axis]) - 0.5;
    // The last voxel of a coarser level may reach beyond the end of level 0.
    const double hi = box.hi[axis] == frame.dims[axis] ? frame.end[axis] : static_cast<double>(box.hi[axis]) - 0.5;
    if (slope == 0) {
      if (base < lo || base >= hi) return {0, 0};
      continue;
    }
    const double a = (lo - base) / slope, b = (hi - base) / slope;
    out.near = std::max(out.near, slope > 0 ? a : b);
    out.far = std::min(out.far, slope > 0 ? b : a);
  }
  if (!frame.clip->showsAll()) frame.clip->cutLine(ray.base(), ray.slope(), out.near, out.far);
  return out;
}

SlabSpan slabsOf(const SlabZone& zone, const RayPart& part) {
  if (part.far <= zone.near || part.near >= zone.far) return {};
  return {zone.slabFrom(part.near), zone.slabFrom(part.far)};
}

// Returns true if the interval contains the middle of a slab of any zone.
bool hasMiddle(const RayFrame& frame, const RayPart& part) {
  return std::any_of(frame.zones.begin(), frame.zones.end(),
                     [&](const SlabZone& zone) { return !slabsOf(zone, part).empty(); });
}

// Returns a slab that covers all of `whole` if `whole` passes between the samples of all zones, as in a clip region
// thinner than the sample distance. The slab's sample is at the middle of `whole`.
std::optional<SlabZone> shortRay(const RayFrame& frame, const RayPart& whole) {
  if (whole.empty() || hasMiddle(frame, whole)) return std::nullopt;
  const SlabZone slab{whole.near, whole.far, whole.far - whole.near, 1};
  const double middle = whole.near + 0.5 * slab.thickness;
  const bool drawn = std::any_of(frame.zones.begin(), frame.zones.end(),
                                 [&](const SlabZone& zone) { return zone.near <= middle && middle < zone.far; });
  return drawn ? std::optional(slab) : std::nullopt;
}

// Returns the weight of a sample in a mean: the slab's thickness, or for the first and last slab of a ray the part
// inside `whole`.
double lengthOf(const SlabZone& zone, int slab, const RayPart& whole) {
  const double begin = zone.near + slab * zone.thickness, end = begin + zone.thickness;
  const bool first = begin - 0.5 * zone.thickness < whole.near, last = end + 0.5 * zone.thickness >= whole.far;
  return (last ? whole.far : end) - (first ? whole.near : begin);
}

// Interpolates from a to b. A voxel of weight 0 may be NaN and is ignored. Fractions have float precision, so that
// rounding does not leave [a, b] unless the values have more bits than a float.
template <class T>
double between(double a, double b, double fraction) {
  if constexpr (std::is_floating_point_v<T>) {
    if (fraction == 0) return a;
  }
  return a + fraction * (b - a);
}

enum class Rule { kExtremum, kMean, kAttenuated };

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

template <class T, Rule kRule>
class BrickRays {
 public:
  BrickRays(const BrickBlock& block, bool all, double sign, const Attenuation& attenuation, DrawCounts& counts)
      : attenuation_(attenuation),
        block_(block),
        voxels_(block.data<T>()),
        stride_y_(block.strideY()),
        stride_z_(block.strideZ()),
        first_(block.core.lo.x, block.core.lo.y, block.core.lo.z),
        all_(all),
        sign_(sign),
        counts_(counts) {
    for (int axis = 0; axis < 3; ++axis)
      last_cell_[axis] = static_cast<int>((block.core.hi[axis] - block.core.lo[axis] - 1) / kCellSize);
  }

  // Takes the samples of `span`. For means `whole` is the ray's whole interval; otherwise `length` is null.
  void take(const PixelRay& ray, const RayPart& whole, const SlabZone& zone, const SlabSpan& span, double& held,
            double* length) noexcept {
    counts_.visited += static_cast<std::uint64_t>(span.end - span.first);
    const glm::dvec3 base = ray.base() - first_, inverse = 1.0 / ray.slope();
    const double slabs_per_depth = 1 / zone.thickness;
    for (int slab = span.first; slab < span.end;) {
      const glm::dvec3 place = base + depthOf(zone, slab) * ray.slope();
      int cell[3];
      double leaves_at = kInfinity;
      for (int axis = 0; axis < 3; ++axis) {
        // Rounding may put a sample just behind the brick's last face; it belongs to the last cell.
        cell[axis] = std::clamp(static_cast<int>((place[axis] + 0.5) * (1.0 / kCellSize)), 0, last_cell_[axis]);
        if (ray.slope()[axis] == 0) continue;
        const int face = (cell[axis] + (ray.slope()[axis] > 0 ? 1 : 0)) * static_cast<int>(kCellSize);
        leaves_at = std::min(leaves_at, (face - 0.5 - base[axis]) * inverse[axis]);
      }
      const double beyond = std::clamp((leaves_at - zone.near) * slabs_per_depth + 0.5, slab + 1.0, span.end + 0.0);
      const int leaves = static_cast<int>(beyond);
      const ValueRange& range = block_.supports.at(cell[0] + 1, cell[1] + 1, cell[2] + 1);
      ++counts_.nodes_tested;
      if (kRule == Rule::kAttenuated && !all_ && !(std::exp(-*length) > held)) return;
      if (range.empty() || (kRule == Rule::kExtremum && !all_ && !((sign_ > 0 ? range.hi : -range.lo) > held))) {
        ++counts_.nodes_hidden;
        slab = leaves;
        continue;
      }
      counts_.splats += static_cast<std::uint64_t>(leaves - slab);
      for (; slab < leaves; ++slab) {
        const double value = valueAt(ray.base() + depthOf(zone, slab) * ray.slope());
        if constexpr (kRule != Rule::kExtremum) {
          if (std::isnan(value)) continue;
          const double part = sampleLength<kRule>(ray, lengthOf(zone, slab, whole));
          if (takeSample<kRule>(attenuation_, value, part, held, *length)) counts_.changed = true;
        } else if (sign_ * value > held) {
          held = sign_ * value;
          counts_.changed = true;
        }
      }
    }
  }

 private:
  static double depthOf(const SlabZone& zone, int slab) { return zone.near + (slab + 0.5) * zone.thickness; }

  // Interpolates linearly with equal arithmetic in every brick. requires: place >= -1/2, up to rounding.
  double valueAt(const glm::dvec3& place) const {
    VoxelCoord voxel;
    double part[3];
    for (int axis = 0; axis < 3; ++axis) {
      voxel[axis] = static_cast<std::int64_t>(place[axis] + 1) - 1;
      part[axis] = static_cast<float>(std::max(place[axis] - static_cast<double>(voxel[axis]), 0.0));
    }
    const T* const v = voxels_ + block_.offsetOf(voxel);
    const auto along_x = [&](std::int64_t i) {
      return between<T>(static_cast<double>(v[i]), static_cast<double>(v[i + 1]), part[0]);
    };
    const double front = between<T>(along_x(0), along_x(stride_y_), part[1]);
    const double back = between<T>(along_x(stride_z_), along_x(stride_z_ + stride_y_), part[1]);
    return between<T>(front, back, part[2]);
  }

  const Attenuation& attenuation_;
  const BrickBlock& block_;
  const T* const voxels_;
  const std::int64_t stride_y_, stride_z_;
  const glm::dvec3 first_;
  const bool all_;
  const double sign_;
  DrawCounts& counts_;
  int last_cell_[3];
};

// Calls take(ray, whole, zone, span, held, length) for each pixel of `rect` that may change and each zone with samples
// in `core`. Where the order of samples counts, `whole` is the ray's interval in the whole volume; otherwise `length`
// is null.
template <class Take>
void forEachRay(const RayFrame& frame, const VoxelBox& core, double bound, bool all, const PixelRect& rect,
                ProjectedValues& values, Take take) noexcept {
  for (int y = rect.y0; y < rect.y1; ++y) {
    double* const held = values.held(rect.x0, y);
    double* const length = values.accumulates() ? values.length(rect.x0, y) : nullptr;
    const Silhouette::Row outline = frame.outline->row(y);
    for (int i = 0; i < rect.width(); ++i) {
      if (std::isnan(held[i]) || (length == nullptr && !all && !(bound > held[i]))) continue;
      const Silhouette::Part covered = outline.at(rect.x0 + i);
      if (covered.share == 0) continue;
      const PixelRay ray(*frame.projector, covered.middle);
      const RayPart part = partIn(frame, ray, core);
      if (part.empty()) continue;
      double* const length_here = length == nullptr ? nullptr : length + i;
      RayPart whole = length != nullptr ? partIn(frame, ray, boxOf(frame.dims)) : part;
      bool taken = false;
      for (const SlabZone& zone : frame.zones) {
        const SlabSpan span = slabsOf(zone, part);
        if (span.empty()) continue;
        take(ray, whole, zone, span, held[i], length_here);
        taken = true;
      }
      if (taken) continue;
      if (length == nullptr) whole = partIn(frame, ray, boxOf(frame.dims));
      const std::optional<SlabZone> slab = shortRay(frame, whole);
      if (slab && !slabsOf(*slab, part).empty()) take(ray, whole, *slab, {0, 1}, held[i], length_here);
    }
  }
}

}  // namespace

bool hasSample(const RayFrame& frame, const glm::dvec2& place) {
  const RayPart part = partIn(frame, PixelRay(*frame.projector, place), boxOf(frame.dims));
  return !part.empty() && (hasMiddle(frame, part) || shortRay(frame, part));
}

void projectBrick(const RayFrame& frame, const BrickBlock& block, double bound, bool all, const PixelRect& rect,
                  ProjectedValues& values, DrawCounts& counts) noexcept {
  withVoxelType(block.type, [&]<class T>(std::type_identity<T>) {
    const auto run = [&](auto rays) {
      forEachRay(frame, block.core, bound, all, rect, values,
                 [&](const PixelRay& ray, const RayPart& whole, const SlabZone& zone, const SlabSpan& span,
                     double& held, double* length) { rays.take(ray, whole, zone, span, held, length); });
    };
    if (values.mean())
      run(BrickRays<T, Rule::kMean>(block, all, values.sign(), values.attenuation(), counts));
    else if (values.attenuated())
      run(BrickRays<T, Rule::kAttenuated>(block, all, values.sign(), values.attenuation(), counts));
    else
      run(BrickRays<T, Rule::kExtremum>(block, all, values.sign(), values.attenuation(), counts));
  });
}

void projectConstant(const RayFrame& frame, const VoxelBox& core, double value, const PixelRect& rect,
                     ProjectedValues& values, DrawCounts& counts) noexcept {
  const double bound = values.sign() * value;
  forEachRay(frame, core, bound, false, rect, values,
             [&](const PixelRay& ray, const RayPart& whole, const SlabZone& zone, const SlabSpan& span, double& held,
                 double* length) {
               counts.visited += static_cast<std::uint64_t>(span.end - span.first);
               counts.changed = true;
               if (length == nullptr) {
                 held = bound;
                 return;
               }
               // Add sample by sample as projectBrick would, for equal bits.
               for (int slab = span.first; slab < span.end; ++slab) {
                 const double part = lengthOf(zone, slab, whole);
                 if (values.mean())
                   takeSample<Rule::kMean>(values.attenuation(), value, part, held, *length);
                 else
                   takeSample<Rule::kAttenuated>(values.attenuation(), value,
                                                 sampleLength<Rule::kAttenuated>(ray, part), held, *length);
               }
             });
}

}  // namespace kiln
