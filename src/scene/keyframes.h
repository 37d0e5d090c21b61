// Interpolates keyframes by cubic splines through numbers, points and orientations. Source for orientations: Kim et al.
// 1995 (cumulative Hermite form).
#pragma once

#include <cstddef>
#include <glm/gtc/quaternion.hpp>
#include <vector>

namespace kiln {

/// Passage through a key: smooth, with a corner (constant speed on both sides), or with a stop.
enum class Ease { kSmooth, kLinear, kStop };

template <class T>
struct Key {
  double frame = 0;
  Ease ease = Ease::kLinear;
  T value{};
};

/// Frames and eases of the keys; frames are strictly rising.
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

/// Interval between keys `from` and from + 1, with `t` from 0 to 1. The first and last key extend outside. A single key
/// has t = 0.
struct KeySpan {
  std::size_t from = 0;
  double t = 0;
};

/// Returns the interval with `t` linear in time. requires: at least one key.
KeySpan spanAt(const KeyTimes& keys, double frame);

/// Returns the interval with `t` bent by the eases: the weight for mixing the values of two neighbouring keys.
KeySpan mixAt(const KeyTimes& keys, double frame);

/// Evaluates the spline through `values`, one value per key. requires: as many values as keys, at least one.
double splineAt(const KeyTimes& keys, const std::vector<double>& values, double frame);
glm::dvec3 splineAt(const KeyTimes& keys, const std::vector<glm::dvec3>& values, double frame);
/// Takes the shorter way round between keys; two keys alone have constant speed. requires: unit quaternions.
glm::dquat splineAt(const KeyTimes& keys, const std::vector<glm::dquat>& values, double frame);

}  // namespace kiln
