#include "job/animation.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>

#include "job/render_job.h"

namespace kiln {
namespace {

struct FrameRange {
  std::optional<double> first, last;
  void add(double frame) {
    first = std::min(first.value_or(frame), frame);
    last = std::max(last.value_or(frame), frame);
  }
  template <class T>
  void add(const std::vector<Key<T>>& keys) {
    for (const Key<T>& key : keys) add(key.frame);
  }
};

// Directions turn at their lengths' mean.
glm::dvec3 mixedDirections(const glm::dvec3& a, const glm::dvec3& b, double t) {
  if (a == b) return a;
  return glm::mix(glm::normalize(a), glm::normalize(b), t);
}

}  // namespace

std::vector<int> Animation::frames() const {
  FrameRange range;
  if (const auto* turntable = std::get_if<Turntable>(&camera)) {
    range.add(1);
    range.add(turntable->frames);
  } else if (const auto* matrices = std::get_if<CameraMatrices>(&camera)) {
    range.add(1);
    range.add(static_cast<double>(matrices->size()));
  } else if (const auto* keyframes = std::get_if<CameraKeyframes>(&camera)) {
    range.add(keyframes->keys);
  }
  range.add(functions);
  range.add(lights);
  range.add(clip);
  range.add(stereo);
  std::vector<int> out;
  for (int frame = static_cast<int>(std::ceil(range.first.value_or(1))); frame <= range.last.value_or(1); ++frame)
    out.push_back(frame);
  return out;
}

std::vector<Light> mixed(const std::vector<Light>& a, const std::vector<Light>& b, double t) {
  std::vector<Light> out = a;
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i].place =
        isFar(out[i].kind) ? mixedDirections(a[i].place, b[i].place, t) : glm::mix(a[i].place, b[i].place, t);
    out[i].color = glm::mix(a[i].color, b[i].color, t);
    out[i].intensity = std::lerp(a[i].intensity, b[i].intensity, t);
  }
  return out;
}

std::vector<ClipPlane> mixed(const std::vector<ClipPlane>& a, const std::vector<ClipPlane>& b, double t) {
  std::vector<ClipPlane> out = a;
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (a[i].normal == b[i].normal) {
      out[i].offset = std::lerp(a[i].offset, b[i].offset, t);
      continue;
    }
    // Interpolates planes whose normals have equal length; the length itself has no meaning.
    out[i].normal = mixedDirections(a[i].normal, b[i].normal, t);
    out[i].offset = std::lerp(a[i].offset / glm::length(a[i].normal), b[i].offset / glm::length(b[i].normal), t);
  }
  return out;
}

Stereo mixed(const Stereo& a, const Stereo& b, double t) {
  Stereo out = a;
  out.interocular = std::lerp(a.interocular, b.interocular, t);
  if (a.convergence) out.convergence = std::lerp(*a.convergence, *b.convergence, t);
  return out;
}

bool mayMix(const glm::dvec3& a, const glm::dvec3& b) {
  return glm::length(glm::normalize(a) + glm::normalize(b)) > 1e-6;
}

}  // namespace kiln
