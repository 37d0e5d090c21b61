// Values and gradients of a cell's samples, interpolated from its voxels. A field has
// - shown(): the spaces in which samples may be visible; empty if unknown;
// - interpolate(count): prepares the values of the first `count` samples of CellSamples::code;
// - values(n): the values of a vector of samples from the n-th on; NaN if a voxel with weight is NaN;
// - findSlopes(n, count), slopes(i): gradients of up to kLit samples of CellSamples::index from the n-th on, then a
// vector of these gradients from the i-th on. unit: value per voxel.
// Compiled once for each instruction set; hence no #pragma once.
#if defined(KILN_CELL_FIELD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KILN_CELL_FIELD_INL_H
#undef KILN_CELL_FIELD_INL_H
#else
#define KILN_CELL_FIELD_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "engine/pixel/cast_rays_in_cell.h"
#include "engine/pixel/cubic_sums-inl.h"
#include "engine/pixel/visible_spaces-inl.h"
#include "engine/pixel/voxels/label_voxels.h"
#include "engine/pixel/voxels/load_patch.h"
#include "engine/shared/sample_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

using D2 = hn::CappedTag<float, 2>;
using D4 = hn::CappedTag<float, 4>;

// Trilinear interpolation of a patch at a found sample. shape: `patch` as loadPatch's.
HWY_INLINE float interpolatedAt(const float* patch, const CellSamples& samples, std::size_t sample) {
  const float x = samples.fraction[0][sample], y = samples.fraction[1][sample], z = samples.fraction[2][sample];
  const auto mixed = [](float a, float b, float t) { return a + t * (b - a); };
  const auto row = [&](int dy, int dz) {
    const float* const first = patch + samples.offset[sample] + dz * CellInput::kPlane + dy * kPatchStride;
    return mixed(first[0], first[1], x);
  };
  return mixed(mixed(row(0, 0), row(1, 0), y), mixed(row(0, 1), row(1, 1), y), z);
}

// Trilinear interpolation of voxels and of central differences. kGaps: voxels may be NaN. Equation (3).
template <bool kGaps>
class LinearCellField {
 public:
  LinearCellField(const SampleLattice& lattice, const CellInput& in, CellSamples& samples)
      : l_(lattice), in_(in), s_(samples) {}

  // Unknown with intervals, which reach beyond the eight voxels around a sample.
  HWY_INLINE std::optional<Spaces> shown() const {
    if (kGaps || l_.integral != nullptr) return std::nullopt;
    return l_.surfaces > 0 ? crossedSpaces<0>(l_, in_.values) : visibleSpaces<0>(l_, in_.values);
  }

  // Stores the values before and after each sample along x, for two samples at a time if a vector holds both.
  void interpolate(std::size_t count) {
    const D4 d;
    for (std::size_t n = 0; n < count; n += kInterpolated) {
      const float* const first = in_.values + s_.offset[n];
      const float* const last = in_.values + s_.offset[n + kInterpolated - 1];
      const auto y = ofPairs(s_.fraction[1] + n), z = ofPairs(s_.fraction[2] + n);
      for (std::size_t i = 0; i < 2; i += hn::Lanes(d)) {
        const auto row = [&](int dy, int dz) {
          const std::size_t at = static_cast<std::size_t>(dz * kPlane + dy * kPatchStride) + i;
          return pairsFrom(first + at, last + at);
        };
        const auto near = mix(d, row(0, 0), row(1, 0), y), far = mix(d, row(0, 1), row(1, 1), y);
        hn::Store(mix(d, near, far, z), d, s_.pair + 2 * n + i);
      }
    }
  }

  HWY_INLINE V values(std::size_t n) const {
    const D d;
    V before, after;
    hn::LoadInterleaved2(d, s_.pair + 2 * n, before, after);
    return mix(d, before, after, hn::Load(d, s_.fraction[0] + n));
  }

  // Interpolates along y and z, for four voxels along x at a time, and for two samples if a vector holds both.
  HWY_INLINE void findSlopes(std::size_t n, std::size_t count) {
    const DRows d;
    constexpr std::size_t kSamples = (hn::MaxLanes(DRows()) + 3) / 4;
    for (std::size_t lane = 0; lane < count; lane += kSamples) {
      const auto first = static_cast<std::size_t>(s_.index[n + lane]);
      const auto last = static_cast<std::size_t>(s_.index[n + std::min(lane + kSamples, count) - 1]);
      s_.fraction_x[lane] = s_.fraction[0][first], s_.fraction_x[lane + kSamples - 1] = s_.fraction[0][last];
      const float* const of_first = in_.values + s_.offset[first] - 1;
      const float* const of_last = in_.values + s_.offset[last] - 1;
      const auto y = bothOf(s_.fraction[1][first], s_.fraction[1][last]);
      const auto z = bothOf(s_.fraction[2][first], s_.fraction[2][last]);
      for (std::size_t i = 0; i < 4; i += hn::Lanes(d)) {
        const auto row = [&](int dy, int dz) {
          const int at = dz * kPlane + dy * kPatchStride + static_cast<int>(i);
          return bothFrom(of_first + at, of_last + at);
        };
        const auto of_row = [&](int dy) { return mix(d, row(dy, 0), row(dy, 1), z); };
        const auto along_z = [&](int dy) { return twiceSlope(d, row(dy, -1), row(dy, 0), row(dy, 1), row(dy, 2), z); };
        const auto before = of_row(-1), here = of_row(0), next = of_row(1), after = of_row(2);
        hn::Store(mix(d, here, next, y), d, s_.rows[1] + 4 * lane + i);
        hn::Store(twiceSlope(d, before, here, next, after, y), d, s_.rows[2] + 4 * lane + i);
        hn::Store(mix(d, along_z(0), along_z(1), y), d, s_.rows[3] + 4 * lane + i);
      }
    }
  }

  // Interpolates along x.
  HWY_INLINE Vector slopes(std::size_t i) const {
    const D d;
    const V x = hn::Load(d, s_.fraction_x + i), half = hn::Set(d, 0.5f);
    V before, here, next, after, y_here, y_next, z_here, z_next, unused, other;
    hn::LoadInterleaved4(d, s_.rows[1] + 4 * i, before, here, next, after);
    hn::LoadInterleaved4(d, s_.rows[2] + 4 * i, unused, y_here, y_next, other);
    hn::LoadInterleaved4(d, s_.rows[3] + 4 * i, unused, z_here, z_next, other);
    return {hn::Mul(half, twiceSlope(d, before, here, next, after, x)), hn::Mul(half, mix(d, y_here, y_next, x)),
            hn::Mul(half, mix(d, z_here, z_next, x))};
  }

  // a + t (b - a), exactly a if t is 0: a voxel without weight may be NaN.
  template <class Tag, class Vec>
  static HWY_INLINE Vec mix(Tag d, Vec a, Vec b, Vec t) {
    const Vec out = between(a, b, t);
    if constexpr (kGaps) return hn::IfThenElse(hn::Eq(t, hn::Zero(d)), a, out);
    return out;
  }

 private:
  static constexpr int kPlane = CellInput::kPlane;

  // Interpolates central differences. Beside a gap, where one of them is NaN, the difference of the voxels around the
  // sample takes their place: a surface is lit up to the gap.
  template <class Tag, class Vec>
  static HWY_INLINE Vec twiceSlope(Tag d, Vec before, Vec here, Vec next, Vec after, Vec t) {
    const Vec out = mix(d, hn::Sub(next, before), hn::Sub(after, here), t);
    if constexpr (!kGaps) return out;
    const Vec within = hn::Sub(next, here);
    return hn::IfThenElse(hn::Eq(out, out), out, hn::Add(within, within));
  }

#if HWY_MAX_BYTES < 16  // a vector holds one value
  static constexpr std::size_t kInterpolated = 1;
  static HWY_INLINE hn::Vec<D4> ofPairs(const float* of) { return hn::Set(D4(), *of); }
  static HWY_INLINE hn::Vec<D4> pairsFrom(const float* first, const float*) { return hn::LoadU(D4(), first); }
#else
  static constexpr std::size_t kInterpolated = 2;
  static HWY_INLINE hn::Vec<D4> ofPairs(const float* of) {
    const auto both = hn::LoadU(D4(), of);
    return hn::InterleaveLower(D4(), both, both);
  }
  static HWY_INLINE hn::Vec<D4> pairsFrom(const float* first, const float* last) {
    return hn::Combine(D4(), hn::LoadU(D2(), last), hn::LoadU(D2(), first));
  }
#endif

#if HWY_MAX_BYTES < 32  // a vector holds one row of slopes
  using DRows = D4;
  static HWY_INLINE hn::Vec<DRows> bothOf(float first, float) { return hn::Set(DRows(), first); }
  static HWY_INLINE hn::Vec<DRows> bothFrom(const float* first, const float*) { return hn::LoadU(DRows(), first); }
#else
  using DRows = hn::CappedTag<float, 8>;
  static HWY_INLINE hn::Vec<DRows> bothOf(float first, float last) {
    return hn::Combine(DRows(), hn::Set(D4(), last), hn::Set(D4(), first));
  }
  static HWY_INLINE hn::Vec<DRows> bothFrom(const float* first, const float* last) {
    return hn::Combine(DRows(), hn::LoadU(D4(), last), hn::LoadU(D4(), first));
  }
#endif

  const SampleLattice& l_;
  const CellInput& in_;
  CellSamples& s_;
};

// Cubic B-spline or Catmull-Rom spline over 4³ voxels; gradients are always the B-spline's. Values are clamped to the
// range of the 4³ voxels, so that the range of a cell bounds all samples. Source: Catmull and Rom 1974.
class CubicCellField {
  using Rows = CubicSums::Rows;
  using Columns = CubicSums::Columns;

 public:
  CubicCellField(const SampleLattice& lattice, const CellInput& in, CellSamples& samples)
      : CubicCellField(lattice, in.values, samples) {}
  CubicCellField(const SampleLattice& lattice, const float* values, CellSamples& samples)
      : l_(lattice), values_(values), s_(samples) {}

  // Unknown with intervals, whose ends another interpolation rounds. NaN counts for nothing: a sample of it is
  // invisible.
  HWY_INLINE std::optional<Spaces> shown() const {
    if (l_.integral != nullptr) return std::nullopt;
    return l_.surfaces > 0 ? crossedSpaces<1>(l_, values_) : visibleSpaces<1>(l_, values_);
  }

  void interpolate(std::size_t count) {
    const D d;
    for (std::size_t n = 0; n < count; n += hn::Lanes(d)) {
      const auto weights = [&](int axis) { return valueWeights(hn::Load(d, s_.fraction[axis] + n)); };
      const Columns x(weights(0));
      const Rows rows(weights(1), weights(2));
      alignas(64) float sums[kVoxels], least[kVoxels], most[kVoxels];
      CubicSums(values_, s_.offset + n).forEachVector([&](std::size_t e, const auto& forEachRow) {
        const V above = hn::Set(d, 3e38f), below = hn::Set(d, -3e38f), none = hn::Zero(d);
        V total = none, lo = above, hi = below;
        forEachRow([&](std::size_t row, V voxels) {
          const V weight = CubicSums::weightsOf(rows, row, e);
          const M counts = hn::Ne(weight, none);
          total = hn::Add(total, CubicSums::weighted(weight, voxels));
          lo = hn::IfThenElse(counts, hn::Min(lo, voxels), lo);
          hi = hn::IfThenElse(counts, hn::Max(hi, voxels), hi);
        });
        const M counts = hn::Ne(hn::Load(d, x.weight + e), none);
        hn::Store(total, d, sums + e);
        hn::Store(hn::IfThenElse(counts, lo, above), d, least + e);
        hn::Store(hn::IfThenElse(counts, hi, below), d, most + e);
      });
      const V value = CubicSums::along(x, sums);
      V lo[4], hi[4];
      hn::LoadInterleaved4(d, least, lo[0], lo[1], lo[2], lo[3]);
      hn::LoadInterleaved4(d, most, hi[0], hi[1], hi[2], hi[3]);
      const V lower = hn::Min(hn::Min(lo[0], lo[1]), hn::Min(lo[2], lo[3]));
      const V upper = hn::Max(hn::Max(hi[0], hi[1]), hn::Max(hi[2], hi[3]));
      const M number = hn::Eq(value, value);
      hn::Store(hn::IfThenElse(number, hn::Min(hn::Max(value, lower), upper), value), d, s_.pair + n);
    }
  }

  HWY_INLINE V values(std::size_t n) const { return hn::LoadU(D(), s_.pair + n); }

  void findSlopes(std::size_t n, std::size_t count) {
    const D d;
    const DI di;
    for (std::size_t lane = 0; lane < count; lane += hn::Lanes(d)) {
      const M within = lanesBefore(lane, count);
      const VI index = hn::IfThenElseZero(hn::RebindMask(di, within), hn::LoadU(di, s_.index + n + lane));
      alignas(64) std::int32_t offset[CellSamples::kLanes];
      hn::Store(hn::GatherIndex(di, s_.offset, index), di, offset);
      const auto fraction = [&](int axis) { return Lanes(hn::GatherIndex(d, s_.fraction[axis], index)); };
      const auto smooth = [&](int axis) { return bSplineWeights(fraction(axis)); };
      const auto slope = [&](int axis) { return bSplineSlopeWeights(fraction(axis)); };
      const Columns columns[] = {Columns(slope(0)), Columns(smooth(0))};
      const Rows rows[] = {Rows(smooth(1), smooth(2)), Rows(slope(1), smooth(2)), Rows(smooth(1), slope(2))};
      alignas(64) float sums[3][kVoxels];
      CubicSums(values_, offset).forEachVector([&](std::size_t e, const auto& forEachRow) {
        V total[3] = {hn::Zero(d), hn::Zero(d), hn::Zero(d)};
        forEachRow([&](std::size_t row, V voxels) {
          for (int a = 0; a < 3; ++a)
            total[a] = hn::Add(total[a], CubicSums::weighted(CubicSums::weightsOf(rows[a], row, e), voxels));
        });
        for (int a = 0; a < 3; ++a) hn::Store(total[a], d, sums[a] + e);
      });
      for (int a = 0; a < 3; ++a)
        hn::Store(CubicSums::along(columns[a == 0 ? 0 : 1], sums[a]), d, s_.rows[1 + a] + lane);
    }
  }

  HWY_INLINE Vector slopes(std::size_t i) const {
    const D d;
    return {hn::LoadU(d, s_.rows[1] + i), hn::LoadU(d, s_.rows[2] + i), hn::LoadU(d, s_.rows[3] + i)};
  }

 private:
  static constexpr std::size_t kVoxels = CubicSums::kVoxels;

  CubicWeights<Lanes> valueWeights(Lanes t) const {
    return l_.interpolation == Interpolation::kCubic ? bSplineWeights(t) : catmullRomWeights(t);
  }

  const SampleLattice& l_;
  const float* values_;
  CellSamples& s_;
};

// Table positions of labels (engine/pixel/voxels/label_voxels.h), each interpolated by itself. Gradients are the
// B-spline's, of opacities that were smoothed before.
class LabelCellField {
 public:
  LabelCellField(const SampleLattice& lattice, const CellInput& in, CellSamples& samples)
      : in_(in),
        s_(samples),
        opacities_(lattice, in, samples),
        cubic_(lattice.interpolation == Interpolation::kCubic) {}

  HWY_INLINE std::optional<Spaces> shown() const {
    if (in_.one_label) return std::nullopt;
    return cubic_ ? labelledSpaces<1>(in_.labels) : labelledSpaces<0>(in_.labels);
  }

  void interpolate(std::size_t count) {
    if (in_.one_label) return;
    if (cubic_) {
      for (std::size_t n = 0; n < count; ++n) s_.pair[n] = placeBySpline(n);
    } else {
      for (std::size_t n = 0; n < count; n += hn::Lanes(D())) placeLinearly(n);
    }
  }

  HWY_INLINE V values(std::size_t n) const {
    const D d;
    return in_.one_label ? hn::Set(d, SampleTable::placeOf(in_.labels[0], 1)) : hn::LoadU(d, s_.pair + n);
  }

  void findSlopes(std::size_t n, std::size_t count) {
    if (!in_.one_label) opacities_.findSlopes(n, count);
  }
  HWY_INLINE Vector slopes(std::size_t i) const {
    const D d;
    return in_.one_label ? Vector{hn::Zero(d), hn::Zero(d), hn::Zero(d)} : opacities_.slopes(i);
  }

 private:
  static constexpr int kPlane = CellInput::kPlane;

  // Selects for each sample of a vector the label with the largest share among the eight voxels around it.
  HWY_INLINE void placeLinearly(std::size_t n) {
    const D d;
    const DI di;
    const VI offset = hn::Load(di, s_.offset + n);
    V after[3], before[3];
    for (int a = 0; a < 3; ++a) {
      after[a] = hn::Load(d, s_.fraction[a] + n);
      before[a] = hn::Sub(hn::Set(d, 1.0f), after[a]);
    }
    constexpr int kCorners = 8;
    VI rank[kCorners];
    V weight[kCorners];
    for (int i = 0; i < kCorners; ++i) {
      const int x = i & 1, y = i >> 1 & 1, z = i >> 2;
      rank[i] = hn::GatherIndex(di, in_.labels + z * kPlane + y * kPatchStride + x, offset);
      const V across = hn::Mul(y != 0 ? after[1] : before[1], z != 0 ? after[2] : before[2]);
      weight[i] = hn::Mul(x != 0 ? after[0] : before[0], across);
    }
    const auto sumWhere = [&](auto test) {
      V sum = hn::Zero(d);
      for (int i = 0; i < kCorners; ++i)
        sum = hn::Add(sum, hn::IfThenElseZero(hn::RebindMask(d, test(rank[i])), weight[i]));
      return sum;
    };
    const V shown = sumWhere([&](VI other) { return hn::Gt(other, hn::Set(di, -1)); });
    V most = hn::Zero(d);
    VI best = hn::Zero(di);
    for (const VI& own : rank) {
      const V share = sumWhere([&](VI other) { return hn::Eq(other, own); });
      const M first = hn::And(hn::Eq(share, most), hn::RebindMask(d, hn::Lt(own, best)));
      const M more = hn::And(hn::Or(hn::Gt(share, most), first), hn::RebindMask(d, hn::Gt(own, hn::Set(di, -1))));
      most = hn::IfThenElse(more, share, most);
      best = hn::IfThenElse(hn::RebindMask(di, more), own, best);
    }
    alignas(64) float shares[CellSamples::kLanes];
    alignas(64) std::int32_t ranks[CellSamples::kLanes];
    hn::Store(shown, d, shares);
    hn::Store(best, di, ranks);
    for (std::size_t i = 0; i < hn::Lanes(d); ++i) s_.pair[n + i] = labelPlace(shares[i], ranks[i]);
  }

  // Selects the label with the largest share among the 64 voxels around a sample.
  float placeBySpline(std::size_t n) const {
    const D4 d4;
    const hn::RebindToSigned<D4> di4;
    constexpr int kEdge = 4;
    const std::int32_t* const first = in_.labels + s_.offset[n] - (kPlane + kPatchStride + 1);
    const auto row = [&](int y, int z) { return first + z * kPlane + y * kPatchStride; };
    // Distinct ranks among the 64 voxels.
    std::int32_t ranks[kEdge * kEdge * kEdge], last = -1;
    int count = 0;
    for (int z = 0; z < kEdge; ++z) {
      for (int y = 0; y < kEdge; ++y) {
        for (int x = 0; x < kEdge; ++x) {
          const std::int32_t own = row(y, z)[x];
          if (own == last) continue;
          last = own;
          if (own >= 0 && std::find(ranks, ranks + count, own) == ranks + count) ranks[count++] = own;
        }
      }
    }
    CubicWeights<float> w[3];
    for (std::size_t a = 0; a < 3; ++a) w[a] = bSplineWeights(s_.fraction[a][n]);
    float shown = 0, most = 0;
    std::int32_t best = 0;
    for (int i = 0; i < count; ++i) {
      alignas(16) float sum[kEdge];
      for (std::size_t x = 0; x < kEdge; x += hn::Lanes(d4)) {
        auto total = hn::Zero(d4);
        for (int z = 0; z < kEdge; ++z) {
          for (int y = 0; y < kEdge; ++y) {
            const auto is = hn::Eq(hn::LoadU(di4, row(y, z) + x), hn::Set(di4, ranks[i]));
            const float weight = w[1][static_cast<std::size_t>(y)] * w[2][static_cast<std::size_t>(z)];
            total = hn::Add(total, hn::IfThenElseZero(hn::RebindMask(d4, is), hn::Set(d4, weight)));
          }
        }
        hn::Store(total, d4, sum + x);
      }
      const float share = (w[0][0] * sum[0] + w[0][1] * sum[1]) + (w[0][2] * sum[2] + w[0][3] * sum[3]);
      shown += share;
      if (share > most || (share == most && ranks[i] < best)) most = share, best = ranks[i];
    }
    return labelPlace(shown, best);
  }

  const CellInput& in_;
  CellSamples& s_;
  CubicCellField opacities_;
  const bool cubic_;
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#endif
