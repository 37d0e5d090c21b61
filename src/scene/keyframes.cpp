#include "scene/keyframes.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace kiln {
namespace {

// Velocity at `key`, on its side towards the neighbour `other`; `change(i)` is the difference from key i to key i + 1.
template <class Change>
auto velocityAt(const KeyTimes& keys, std::size_t key, std::size_t other, const Change& change) {
  const auto length = [&](std::size_t i) { return keys.frames[i + 1] - keys.frames[i]; };
  const std::size_t here = std::min(key, other);
  if (keys.eases[key] == Ease::kStop) return 0.0 * change(here);
  const bool at_end = key == 0 || key + 1 == keys.frames.size();
  if (keys.eases[key] == Ease::kLinear || at_end) return (1 / length(here)) * change(here);
  return (1 / (length(key - 1) + length(key))) * (change(key - 1) + change(key));
}

template <class T>
T hermiteAt(const KeyTimes& keys, const std::vector<T>& values, double frame) {
  const auto [i, t] = spanAt(keys, frame);
  if (t == 0) return values[i];
  if (t == 1) return values[i + 1];
  const auto change = [&](std::size_t k) { return values[k + 1] - values[k]; };
  const double length = keys.frames[i + 1] - keys.frames[i];
  const T out = length * velocityAt(keys, i, i + 1, change), in = length * velocityAt(keys, i + 1, i, change);
  // The cubic that leaves values[i] with velocity `out` and reaches values[i + 1] with velocity `in`.
  const double u = 1 - t;
  return values[i] + (t * t * (3 - 2 * t)) * change(i) + (t * u * u) * out - (t * t * u) * in;
}

// Converts the rotation to axis times angle, the shorter way round.
glm::dvec3 rotationVector(glm::dquat q) {
  if (q.w < 0) q = -q;
  const glm::dvec3 axis(q.x, q.y, q.z);
  const double sine = glm::length(axis);
  return sine > 0 ? 2 * std::atan2(sine, q.w) / sine * axis : glm::dvec3(0);
}

glm::dquat rotationBy(const glm::dvec3& vector) {
  const double angle = glm::length(vector);
  return angle > 0 ? glm::angleAxis(angle, vector / angle) : glm::dquat(1, 0, 0, 0);
}

}  // namespace

KeySpan spanAt(const KeyTimes& keys, double frame) {
  const std::size_t last = keys.frames.size() - 1;
  if (last == 0 || frame <= keys.frames.front()) return {};
  if (frame >= keys.frames.back()) return {last - 1, 1};
  const auto after = std::upper_bound(keys.frames.begin(), keys.frames.end(), frame);
  const auto from = static_cast<std::size_t>(after - keys.frames.begin()) - 1;
  return {from, (frame - keys.frames[from]) / (keys.frames[from + 1] - keys.frames[from])};
}

KeySpan mixAt(const KeyTimes& keys, double frame) {
  const KeySpan span = spanAt(keys, frame);
  if (span.t == 0 || span.t == 1) return span;
  std::vector<double> places(keys.frames.size());
  for (std::size_t i = 0; i < places.size(); ++i) places[i] = static_cast<double>(i);
  // Monotonic: the velocity at a key is at most three times the mean velocity on either side.
  return {span.from, std::clamp(splineAt(keys, places, frame) - places[span.from], 0.0, 1.0)};
}

double splineAt(const KeyTimes& keys, const std::vector<double>& values, double frame) {
  return hermiteAt(keys, values, frame);
}

glm::dvec3 splineAt(const KeyTimes& keys, const std::vector<glm::dvec3>& values, double frame) {
  return hermiteAt(keys, values, frame);
}

glm::dquat splineAt(const KeyTimes& keys, const std::vector<glm::dquat>& values, double frame) {
  const auto [i, t] = spanAt(keys, frame);
  if (t == 0) return values[i];
  if (t == 1) return values[i + 1];
  // In the frame of the key: a rotation's axis is equal in the frames before and after it.
  const auto change = [&](std::size_t k) { return rotationVector(glm::conjugate(values[k]) * values[k + 1]); };
  const double third = (keys.frames[i + 1] - keys.frames[i]) / 3;
  const glm::dvec3 out = third * velocityAt(keys, i, i + 1, change), in = third * velocityAt(keys, i + 1, i, change);
  const glm::dquat across = rotationBy(-out) * rotationBy(change(i)) * rotationBy(-in);
  // Cumulative Bernstein polynomials.
  const double u = 1 - t;
  return glm::normalize(values[i] * rotationBy((1 - u * u * u) * out) *
                        rotationBy((t * t * (3 - 2 * t)) * rotationVector(across)) * rotationBy((t * t * t) * in));
}

}  // namespace kiln
