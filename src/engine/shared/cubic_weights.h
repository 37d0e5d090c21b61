// Weights of cubic filters for the four voxels at -1, 0, 1 and 2 around a position t, 0 <= t < 1. Source: Catmull and
// Rom 1974.
#pragma once

#include <array>

namespace kiln {

template <class T>
using CubicWeights = std::array<T, 4>;

template <class T>
CubicWeights<T> bSplineWeights(T t) {
  const T s = 1 - t;
  return {s * s * s / 6, (4 + t * t * (3 * t - 6)) / 6, (4 + s * s * (3 * s - 6)) / 6, t * t * t / 6};
}

/// Derivatives of `bSplineWeights`. unit: 1 / voxel.
template <class T>
CubicWeights<T> bSplineSlopeWeights(T t) {
  const T s = 1 - t;
  return {-s * s / 2, t * (3 * t - 4) / 2, s * (4 - 3 * s) / 2, t * t / 2};
}

template <class T>
CubicWeights<T> catmullRomWeights(T t) {
  const T s = 1 - t;
  return {-t * s * s / 2, (2 + t * t * (3 * t - 5)) / 2, (2 + s * s * (3 * s - 5)) / 2, -s * t * t / 2};
}

}  // namespace kiln
