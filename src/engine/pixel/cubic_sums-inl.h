// Cubic filters of the four voxels along each axis around samples: weights, and weighted sums of 4³ voxels. Compiled
// once for each instruction set; hence no #pragma once. Source: Catmull and Rom 1974.
#if defined(KILN_CUBIC_SUMS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KILN_CUBIC_SUMS_INL_H
#undef KILN_CUBIC_SUMS_INL_H
#else
#define KILN_CUBIC_SUMS_INL_H
#endif

#include <hwy/highway.h>

#include <array>
#include <cstddef>
#include <cstdint>

#include "engine/pixel/cast_rays_in_cell.h"
#include "engine/shared/sample_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

// Weights of the four voxels at -1, 0, 1 and 2 around a position t, 0 <= t < 1.
template <class T>
using CubicWeights = std::array<T, 4>;

template <class T>
HWY_INLINE CubicWeights<T> bSplineWeights(T t) {
  const T s = 1 - t;
  return {s * s * s / 6, (4 + t * t * (3 * t - 6)) / 6, (4 + s * s * (3 * s - 6)) / 6, t * t * t / 6};
}

// Derivatives of `bSplineWeights`. unit: 1 / voxel.
template <class T>
HWY_INLINE CubicWeights<T> bSplineSlopeWeights(T t) {
  const T s = 1 - t;
  return {-s * s / 2, t * (3 * t - 4) / 2, s * (4 - 3 * s) / 2, t * t / 2};
}

template <class T>
HWY_INLINE CubicWeights<T> catmullRomWeights(T t) {
  const T s = 1 - t;
  return {-t * s * s / 2, (2 + t * t * (3 * t - 5)) / 2, (2 + s * s * (3 * s - 5)) / 2, -s * t * t / 2};
}

// A vector as a number of formulas that are written for floats.
struct Lanes {
  V v;
  Lanes(V lanes) : v(lanes) {}
  Lanes(float number) : v(hn::Set(D(), number)) {}
  friend HWY_INLINE Lanes operator+(Lanes a, Lanes b) { return hn::Add(a.v, b.v); }
  friend HWY_INLINE Lanes operator-(Lanes a, Lanes b) { return hn::Sub(a.v, b.v); }
  friend HWY_INLINE Lanes operator*(Lanes a, Lanes b) { return hn::Mul(a.v, b.v); }
  friend HWY_INLINE Lanes operator/(Lanes a, Lanes b) { return hn::Div(a.v, b.v); }
  friend HWY_INLINE Lanes operator-(Lanes a) { return hn::Neg(a.v); }
};

// Sums over the 4³ voxels around each sample of a vector of samples. A vector of voxels holds four neighbours along x
// for each of its samples, so that four vectors cover all samples. Voxels without weight are left out: they may be NaN.
class CubicSums {
 public:
  using Weights = CubicWeights<Lanes>;
  // Voxels along an axis, and most voxels of a row of a vector of samples.
  static constexpr std::size_t kTaps = 4, kVoxels = kTaps * CellSamples::kLanes;

  // Products of the weights along y and z.
  struct Rows {
    Rows(const Weights& y, const Weights& z) {
      for (std::size_t k = 0; k < kTaps; ++k) {
        for (std::size_t j = 0; j < kTaps; ++j) hn::Store(hn::Mul(y[j].v, z[k].v), D(), weight[k * kTaps + j]);
      }
    }
    alignas(64) float weight[kTaps * kTaps][CellSamples::kLanes];
  };
  // Weights along x, in the order of the voxels.
  struct Columns {
    explicit Columns(const Weights& x) { hn::StoreInterleaved4(x[0].v, x[1].v, x[2].v, x[3].v, D(), weight); }
    alignas(64) float weight[kVoxels];
  };

  // `offsets`: voxels before the samples.
  CubicSums(const float* values, const std::int32_t* offsets) : values_(values), offsets_(offsets) {}

  // Calls f(e, forEachRow) for the voxels of a vector from the e-th on; forEachRow(g) calls g(row, voxels).
  template <class F>
  HWY_INLINE void forEachVector(F f) const {
    const D d;
    for (std::size_t e = 0; e < kTaps * hn::Lanes(d); e += hn::Lanes(d)) {
      f(e, [&](auto g) {
        for (std::size_t row = 0; row < kTaps * kTaps; ++row) {
          const int y = static_cast<int>(row % kTaps) - 1, z = static_cast<int>(row / kTaps) - 1;
          g(row, voxelsFrom(e, z * kPlane + y * kPatchStride - 1));
        }
      });
    }
  }

  // Weights of a row at the e-th voxels.
  static HWY_INLINE V weightsOf(const Rows& rows, std::size_t row, std::size_t e) {
    return forVoxels(rows.weight[row] + e / kTaps);
  }

  // Returns the weighted sums of the rows' sums. Pairs are added first, so that equal voxels give exactly their own
  // value.
  static HWY_INLINE V along(const Columns& x, const float* sums) {
    const D d;
    V term[kTaps], weight[kTaps];
    hn::LoadInterleaved4(d, sums, term[0], term[1], term[2], term[3]);
    hn::LoadInterleaved4(d, x.weight, weight[0], weight[1], weight[2], weight[3]);
    for (std::size_t i = 0; i < kTaps; ++i) term[i] = weighted(weight[i], term[i]);
    return hn::Add(hn::Add(term[0], term[1]), hn::Add(term[2], term[3]));
  }

  static HWY_INLINE V weighted(V weight, V voxels) {
    return hn::IfThenElseZero(hn::Ne(weight, hn::Zero(D())), hn::Mul(weight, voxels));
  }

 private:
  static constexpr int kPlane = CellInput::kPlane;

#if HWY_MAX_BYTES < 16  // a vector holds one voxel
  HWY_INLINE V voxelsFrom(std::size_t e, int at) const {
    return hn::LoadU(D(), values_ + offsets_[e / kTaps] + at + static_cast<int>(e % kTaps));
  }
  static HWY_INLINE V forVoxels(const float* of_samples) { return hn::Set(D(), *of_samples); }
#else
  HWY_INLINE V voxelsFrom(std::size_t e, int at) const { return samplesFrom(D(), offsets_ + e / kTaps, at); }
  // Voxels of as many samples as a vector has room for.
  template <class Tag>
  HWY_INLINE hn::Vec<Tag> samplesFrom(Tag d, const std::int32_t* of, int at) const {
    if constexpr (hn::MaxLanes(Tag()) == kTaps) {
      return hn::LoadU(d, values_ + *of + at);
    } else {
      const hn::Half<Tag> half;
      return hn::Combine(d, samplesFrom(half, of + hn::Lanes(d) / kTaps / 2, at), samplesFrom(half, of, at));
    }
  }
  // Repeats the number of each sample for its voxels.
  static HWY_INLINE V forVoxels(const float* of_samples) {
    const D d;
    const VI sample = hn::ShiftRight<2>(hn::Iota(DI(), 0));
    return hn::TableLookupLanes(hn::LoadDup128(d, of_samples), hn::IndicesFromVec(d, sample));
  }
#endif

  const float* values_;
  const std::int32_t* offsets_;
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#endif
