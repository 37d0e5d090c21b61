// Values at some frames and what lies between them: cubic splines through numbers, points and orientations. Source of
// the orientations' spline: M.-J. Kim, M.-S. Kim and S. Y. Shin, "A General Construction Scheme for Unit Quaternion
// Curves with Simple High Order Derivatives", 1995 (cumulative Hermite form).
#pragma once

#include <cstddef>
#include <glm/gtc/quaternion.hpp>
#include <vector>

namespace kiln {

/// How a key is passed: without a corner, at a corner (the way to and from it at constant speed), or by coming to rest.
enum class Ease { kSmooth, kLinear, kStop };

template <class T>
struct Key {
  double frame = 0;
  Ease ease = Ease::kLinear;
  T value{};
};

/// When keys are, and how they are passed: strictly rising frames.
struct KeyTimes {
  std::vector<double> frames;
  std::vector<Ease> eases;

  template <class T>
  explicit KeyTimes(const std::vector<Key<T>>& keys) {
    for (const Key<T>& key : keys) {
      frames.push_back(key.frame);
      eases.push_back(key.ease);
    }
  }
};

/// Between keys `from` and from + 1, at `t` of 0 to 1 of the way; the first and the last hold outside. A single key has
/// t = 0.
struct KeySpan {
  std::size_t from = 0;
  double t = 0;
};

/// By time alone. requires: at least one key.
KeySpan spanAt(const KeyTimes& keys, double frame);

/// By what is to be mixed of two neighbouring keys' values: time, bent by how keys are passed.
KeySpan mixAt(const KeyTimes& keys, double frame);

/// The spline through `values`, one a key. requires: as many values as keys, at least one.
double splineAt(const KeyTimes& keys, const std::vector<double>& values, double frame);
glm::dvec3 splineAt(const KeyTimes& keys, const std::vector<glm::dvec3>& values, double frame);
/// From key to key the shorter way round; constant speed where two keys are all there is. requires: unit quaternions.
glm::dquat splineAt(const KeyTimes& keys, const std::vector<glm::dquat>& values, double frame);

}  // namespace kiln
