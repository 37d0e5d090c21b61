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
std::optional<RayZone> shortRay(const RayFrame& frame, const DepthSpan& whole) {
  if (whole.empty() || hasMiddle(frame, whole)) return std::nullopt;
  const RayZone slab{{whole.near, whole.far, whole.far - whole.near, 1}};
  const double middle = whole.near + 0.5 * slab.thickness;
  const bool drawn = std::any_of(frame.zones.begin(), frame.zones.end(),
                                 [&](const SlabZone& zone) { return zone.near <= middle && middle < zone.far; });
  return drawn ? std::optional(slab) : std::nullopt;
}

// Depths of a ray that belong to a sample: those of its slab. The first and the last sample of a ray also have the
// depths to the ray's ends.
struct Piece {
  double begin, middle, end;
  bool first, last;
};

// The pieces of a ray in a zone.
class Pieces {
 public:
  // `whole`: the ray's interval in the whole volume.
  Pieces(const RayZone& zone, const DepthSpan& whole)
      : zone_(zone), whole_(whole), slabs_{zone.slabFrom(whole.near), zone.slabFrom(whole.far)} {}

  double middle(int slab) const { return zone_.near + (slab + 0.5) * zone_.thickness; }
  Piece at(int slab) const {
    const double begin = zone_.near + slab * zone_.thickness;
    const bool first = slab == slabs_.first && (slab > 0 || zone_.before < whole_.near);
    const bool last = slab + 1 == slabs_.end && (slabs_.end < zone_.slabs || zone_.after >= whole_.far);
    return {first ? whole_.near : begin, middle(slab), last ? whole_.far : begin + zone_.thickness, first, last};
  }

 private:
  const RayZone& zone_;
  const DepthSpan whole_;
  const SlabSpan slabs_;  // slabs with samples of the ray
};

// Means of values, weighted by depth. Equation (5).
class MeanRule {
 public:
  MeanRule(const Attenuation&, const PixelRay&) {}

  bool endsRay(double, double) const { return false; }
  bool raises(const ValueRange&, double, double) const { return true; }
  // Bound of the weight that values of pieces from here on have.
  double weightBehind(double) const { return 1; }
  // Takes a piece; `field` has the values. `weight`: as above; 0 if no value raises the pixel. Returns true if the
  // pixel changes.
  template <class Field>
  bool take(const Field& field, const PixelRay& ray, const Piece& piece, double, double& held, double& length) const {
    const double value = field.valueAt(ray.inIndexSpace().at(piece.middle));
    if (std::isnan(value)) return false;
    held += value * (piece.end - piece.begin);
    length += piece.end - piece.begin;
    return true;
  }
};

// Attenuated maxima. The middle of a piece gives the piece's attenuation, which grows evenly along the piece. Equation
// (7).
class AttenuatedRule {
 public:
  AttenuatedRule(const Attenuation& attenuation, const PixelRay& ray)
      : attenuation_(attenuation), per_depth_(attenuation.per_length * ray.oblique()) {
    const glm::dvec3 slope = glm::abs(ray.slope());
    reach_ = kReach / std::max({slope.x, slope.y, slope.z});
  }

  double weightBehind(double sum) const { return std::exp(-sum); }
  bool endsRay(double held, double weight) const { return !(weight > held); }
  bool raises(const ValueRange& range, double held, double weight) const {
    return attenuation_.share(range.hi) * weight > held;
  }
  template <class Field>
  bool take(const Field& field, const PixelRay& ray, const Piece& piece, double weight, double& held,
            double& sum) const {
    const double value = field.valueAt(ray.inIndexSpace().at(piece.middle));
    if (std::isnan(value)) return false;
    const double share = attenuation_.share(value), depth = per_depth_ * (piece.end - piece.begin) * share;
    const double before = held;
    if (weight > held) raise(field, ray, piece, {share, depth, sum, weight}, held);
    sum += depth;
    return held > before || depth > 0;
  }

 private:
  // Values are compared up to here from the middle of a piece, whose cell bounds and holds them. Pieces of rays far
  // from the middle of a wide view are longer. unit: voxels along each axis.
  static constexpr double kReach = 0.5;

  struct Middle {
    double share, depth, sum, weight;
  };
  // Compares values in the middle of a piece, at ends of a ray, and on planes of voxels, where the field has its bends
  // and most of its maxima.
  template <class Field>
  void raise(const Field& field, const PixelRay& ray, const Piece& piece, const Middle& middle, double& held) const {
    const IndexRay& line = ray.inIndexSpace();
    const double rate = middle.depth / (piece.end - piece.begin);
    const auto compare = [&](double at, double share) {
      // The first test spares most exponentials.
      if (share * middle.weight > held)
        held = std::max(held, share * std::exp(-(middle.sum + (at - piece.begin) * rate)));
    };
    const auto compareAt = [&](double at) { compare(at, attenuation_.share(field.valueAt(line.at(at)))); };
    const double begin = std::max(piece.begin, piece.middle - reach_), end = std::min(piece.end, piece.middle + reach_);
    compare(piece.middle, middle.share);
    if (piece.first) compareAt(begin);
    if (piece.last) compareAt(end);
    const glm::dvec3 from = line.at(begin), to = line.at(end);
    for (int axis = 0; axis < 3; ++axis) {
      const double plane = std::floor(std::max(from[axis], to[axis]));
      if (plane > std::min(from[axis], to[axis])) compareAt((plane - line.base[axis]) / line.slope[axis]);
    }
  }

  const Attenuation& attenuation_;
  const double per_depth_;
  double reach_;  // kReach, as a depth
};

// Takes the samples of a brick along rays, front to back.
template <class T, class Rule>
class BrickSamples {
 public:
  BrickSamples(const BrickBlock& block, bool all, const Attenuation& attenuation, DrawCounts& counts)
      : attenuation_(attenuation), cells_(block), field_(block), all_(all), counts_(counts) {}

  // Takes the samples of `span`. `whole`: the ray's interval in the whole volume.
  void take(const PixelRay& ray, const DepthSpan& whole, const RayZone& zone, const SlabSpan& span, double& held,
            double& length) noexcept {
    counts_.visited += static_cast<std::uint64_t>(span.end - span.first);
    const glm::dvec3 base = cells_.placeOf(ray.base()), inverse = 1.0 / ray.slope();
    const double slabs_per_depth = 1 / zone.thickness;
    const Rule rule(attenuation_, ray);
    const Pieces pieces(zone, whole);
    for (int slab = span.first; slab < span.end;) {
      const glm::dvec3 place = base + pieces.middle(slab) * ray.slope();
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
      double weight = rule.weightBehind(length);
      if (!all_ && rule.endsRay(held, weight)) return;
      const ValueRange& range = cells_.range(cell);
      if (range.empty()) {
        ++counts_.nodes_hidden;
        slab = leaves;
        continue;
      }
      if (!all_ && !rule.raises(range, held, weight)) weight = 0;
      counts_.splats += static_cast<std::uint64_t>(leaves - slab);
      for (; slab < leaves; ++slab) {
        if (rule.take(field_, ray, pieces.at(slab), weight, held, length)) counts_.changed = true;
      }
    }
  }

 private:
  const Attenuation& attenuation_;
  const BrickCells cells_;
  const InterpolatedBrick<T> field_;
  const bool all_;
  DrawCounts& counts_;
};

// The field of a brick of one value.
struct ConstantField {
  double value;
  double valueAt(const glm::dvec3&) const { return value; }
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
    for (const RayZone& zone : frame.zones) {
      const SlabSpan span = slabsOf(zone, part);
      if (span.empty()) continue;
      take(ray, whole, zone, span, held, length);
      taken = true;
    }
    if (taken) return;
    const std::optional<RayZone> slab = shortRay(frame, whole);
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
                  [&](const PixelRay& ray, const DepthSpan& whole, const RayZone& zone, const SlabSpan& span,
                      double& held, double& length) { rays.take(ray, whole, zone, span, held, length); });
    };
    const auto raise = [&](auto extremum) {
      forEachStretch(
          frame, block.core, bound, all, rect, values,
          [&](const IndexRay& ray, const RayStretch& part, double& held) { extremum.take(ray, part, held); });
    };
    switch (values.rule()) {
      case PixelValue::kMean:
        return sample(BrickSamples<T, MeanRule>(block, all, values.attenuation(), counts));
      case PixelValue::kAttenuated:
        return sample(BrickSamples<T, AttenuatedRule>(block, all, values.attenuation(), counts));
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
  const ConstantField field{value};
  const auto draw = [&]<class Rule>(std::type_identity<Rule>) {
    forEachSpan(frame, core, rect, values,
                [&](const PixelRay& ray, const DepthSpan& whole, const RayZone& zone, const SlabSpan& span,
                    double& held, double& length) {
                  const Rule rule(values.attenuation(), ray);
                  const Pieces pieces(zone, whole);
                  counts.visited += static_cast<std::uint64_t>(span.end - span.first);
                  counts.changed = true;
                  // Add piece by piece as projectBrick would, for equal bits.
                  for (int slab = span.first; slab < span.end; ++slab)
                    rule.take(field, ray, pieces.at(slab), rule.weightBehind(length), held, length);
                });
  };
  if (values.mean())
    draw(std::type_identity<MeanRule>());
  else
    draw(std::type_identity<AttenuatedRule>());
}

}  // namespace kiln
