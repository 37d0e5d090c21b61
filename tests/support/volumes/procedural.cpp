#include "procedural.h"

#include <cassert>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>

#include "base/thread/parallel.h"

namespace kiln::test {
namespace {

template <class T>
T rounded(double value) {
  if constexpr (std::is_floating_point_v<T>) {
    return static_cast<T>(value);
  } else {
    if (std::isnan(value)) return 0;
    const double lo = std::numeric_limits<T>::lowest();
    const double hi = std::numeric_limits<T>::max();
    return static_cast<T>(std::clamp(std::round(value), lo, hi));
  }
}

double mixed(const ValueRange& range, double fraction) { return range.lo + (range.hi - range.lo) * fraction; }

std::uint64_t counterOf(const Extent3& n, std::int64_t i, std::int64_t j, std::int64_t k) {
  return static_cast<std::uint64_t>((k * n.y + j) * n.x + i);
}

/// The centre of each voxel, from -1 to 1 across the volume.
glm::dvec3 normalised(const Extent3& n, std::int64_t i, std::int64_t j, std::int64_t k) {
  const glm::dvec3 size(n.x, n.y, n.z);
  return (2.0 * glm::dvec3(i, j, k) + 1.0) / size - 1.0;
}

double ballCoverage(const glm::dvec3& voxel, const glm::dvec3& centre, double radius) {
  constexpr int kSubSamples = 8;
  const double half_diagonal = std::sqrt(0.75);
  const double distance = glm::length(voxel - centre);
  if (distance + half_diagonal <= radius) return 1;
  if (distance - half_diagonal >= radius) return 0;
  int inside = 0;
  for (int s = 0; s < kSubSamples * kSubSamples * kSubSamples; ++s) {
    const glm::dvec3 sub(s % kSubSamples, s / kSubSamples % kSubSamples, s / kSubSamples / kSubSamples);
    inside += glm::length(voxel + (sub + 0.5) / double(kSubSamples) - 0.5 - centre) < radius;
  }
  return inside / double(kSubSamples * kSubSamples * kSubSamples);
}

}  // namespace

double DenseVolume::valueAt(std::int64_t i, std::int64_t j, std::int64_t k) const {
  return withVoxelType(type, [&]<class T>(std::type_identity<T>) { return static_cast<double>(at<T>(i, j, k)); });
}

void DenseVolume::set(std::int64_t i, std::int64_t j, std::int64_t k, double value) {
  assert(boxOf(geometry.dims).contains({i, j, k}));
  withVoxelType(type, [&]<class T>(std::type_identity<T>) {
    const T stored = rounded<T>(value);
    std::memcpy(voxels.data() + clampedOffset(i, j, k) * sizeof(T), &stored, sizeof(T));
  });
}

ValueRange DenseVolume::range() const {
  ValueRange out;
  const Extent3& n = geometry.dims;
  for (std::int64_t k = 0; k < n.z; ++k) {
    for (std::int64_t j = 0; j < n.y; ++j) {
      for (std::int64_t i = 0; i < n.x; ++i) {
        const double value = valueAt(i, j, k);
        if (std::isfinite(value)) out.include(value);
      }
    }
  }
  return out;
}

glm::dmat4 spacingAffine(const glm::dvec3& spacing, const glm::dvec3& origin) {
  return glm::scale(glm::translate(glm::dmat4(1.0), origin), spacing);
}

glm::dmat4 anisotropicAffine() { return spacingAffine({0.7, 0.9, 2.1}, {-3, 5, 11}); }

glm::dmat4 obliqueAffine() {
  glm::dmat4 shear(1.0);
  shear[1][0] = 0.25;  // y leans towards x,
  shear[2][1] = -0.3;  // z away from y
  const glm::dmat4 turned =
      glm::rotate(glm::translate(glm::dmat4(1.0), glm::dvec3(7, -4, 2)), 0.7, glm::normalize(glm::dvec3(1, 2, 3)));
  return turned * shear * spacingAffine({0.8, 1.0, 1.3});
}

glm::dmat4 turnedAffine(double angle, const glm::dvec3& spacing, const glm::dvec3& origin) {
  const glm::dmat4 moved = glm::translate(glm::dmat4(1), origin);
  return glm::scale(glm::rotate(moved, angle, glm::normalize(glm::dvec3(1, 2, 0.5))), spacing);
}

glm::dmat4 mirroredAffine(const glm::dmat4& world_from_index, int axis, const Extent3& dims) {
  glm::dvec3 scale(1), origin(0);
  scale[axis] = -1;
  origin[axis] = static_cast<double>(dims[axis] - 1);
  return world_from_index * spacingAffine(scale, origin);
}

ValueRange usualRange(VoxelType type) {
  switch (type) {
    case VoxelType::u8:
      return {0, 255};
    case VoxelType::i8:
      return {-128, 127};
    case VoxelType::u16:
      return {0, 65535};
    case VoxelType::i16:
      return {-1024, 3071};
    case VoxelType::u32:
      return {0, 4'000'000'001.0};
    case VoxelType::i32:
      return {-2'000'000'001.0, 2'000'000'001.0};
    case VoxelType::f32:
      return {0, 1};
    case VoxelType::f64:
      return {-1, 1};
  }
  return {0, 1};
}

DenseVolume fill(const VolumeShape& shape,
                 const std::function<double(std::int64_t, std::int64_t, std::int64_t)>& value) {
  DenseVolume out;
  out.geometry.dims = shape.dims;
  out.geometry.world_from_index = shape.world_from_index;
  out.type = shape.type;
  out.voxels.resize(static_cast<std::size_t>(shape.dims.count()) * sizeOf(shape.type));
  parallelFor(static_cast<std::size_t>(shape.dims.z), [&](std::size_t slice) {
    const auto k = static_cast<std::int64_t>(slice);
    for (std::int64_t j = 0; j < shape.dims.y; ++j) {
      for (std::int64_t i = 0; i < shape.dims.x; ++i) out.set(i, j, k, value(i, j, k));
    }
  });
  return out;
}

DenseVolume slab(const VolumeShape& shape, int axis, std::int64_t lo, std::int64_t hi, double value) {
  return fill(shape, [=](std::int64_t i, std::int64_t j, std::int64_t k) {
    const std::int64_t place = VoxelCoord{i, j, k}[axis];
    return place >= lo && place < hi ? value : 0.0;
  });
}

DenseVolume ball(const VolumeShape& shape, const glm::dvec3& centre, double radius, double value) {
  return fill(shape, [=](std::int64_t i, std::int64_t j, std::int64_t k) {
    return value * ballCoverage(glm::dvec3(i, j, k), centre, radius);
  });
}

DenseVolume ramp(const VolumeShape& shape, double first, double slope) {
  return fill(shape,
              [=](std::int64_t i, std::int64_t, std::int64_t) { return first + slope * static_cast<double>(i); });
}

DenseVolume noise(const VolumeShape& shape, std::uint64_t seed, const ValueRange& range) {
  return fill(shape, [=, n = shape.dims](std::int64_t i, std::int64_t j, std::int64_t k) {
    return mixed(range, hashUnit(seed, counterOf(n, i, j, k)));
  });
}

DenseVolume specks() {
  return fill({{44, 39, 41}, VoxelType::u8}, [](auto i, auto j, auto k) {
    const double chance = hashUnit(5, static_cast<std::uint64_t>((k * 39 + j) * 44 + i));
    return chance < 0.002 ? 0 : chance > 0.998 ? 255 : 128;
  });
}

DenseVolume cheese(const VolumeShape& shape, std::uint64_t seed, const ValueRange& range) {
  const glm::dvec3 phase = 6.283185307179586 * glm::dvec3(hashUnit(seed, 0), hashUnit(seed, 1), hashUnit(seed, 2));
  const std::uint64_t noise_seed = hashBits(seed, 3);
  return fill(shape, [=, n = shape.dims](std::int64_t i, std::int64_t j, std::int64_t k) {
    // Two wavelengths, 13 and 41 voxels, coprime to the sizes of bricks and cells.
    const glm::dvec3 p = glm::dvec3(i, j, k) * (6.283185307179586 / 13) + phase;
    const glm::dvec3 q = glm::dvec3(j, k, i) * (6.283185307179586 / 41) - phase;
    const double walls = std::sin(p.x) * std::cos(p.y) + std::sin(p.y) * std::cos(p.z) + std::sin(p.z) * std::cos(p.x);
    const double slow = std::sin(q.x) + std::sin(q.y) + std::sin(q.z);
    const glm::dvec3 u = normalised(n, i, j, k);
    const double speckle = hashUnit(noise_seed, counterOf(n, i, j, k)) - 0.5;
    const double fraction = 0.5 + 0.2 * walls + 0.1 * slow + 0.08 * speckle + 0.25 - 0.35 * glm::dot(u, u);
    return mixed(range, std::clamp(fraction, 0.0, 1.0));
  });
}

DenseVolume head(const VolumeShape& shape, const ValueRange& range) {
  struct Layer {
    glm::dvec3 centre, radius;
    double fraction;
  };
  // Later layers lie inside earlier layers, or cut into them.
  static constexpr int kLayers = 8;
  static const Layer kHead[kLayers] = {
      {{0, 0, 0}, {0.80, 0.92, 0.90}, 0.35},            // skin
      {{0, 0.02, 0.02}, {0.72, 0.82, 0.81}, 0.90},      // skull
      {{0, 0.04, 0.04}, {0.64, 0.73, 0.72}, 0.45},      // brain
      {{-0.16, 0, 0.05}, {0.10, 0.30, 0.14}, 0.28},     // ventricles
      {{0.16, 0, 0.05}, {0.10, 0.30, 0.14}, 0.28},      //
      {{-0.32, -0.80, 0.05}, {0.17, 0.22, 0.15}, 0.0},  // eye sockets
      {{0.32, -0.80, 0.05}, {0.17, 0.22, 0.15}, 0.0},   //
      {{0, -0.86, -0.20}, {0.10, 0.12, 0.16}, 0.50},    // nose
  };
  return fill(shape, [=, n = shape.dims](std::int64_t i, std::int64_t j, std::int64_t k) {
    const glm::dvec3 u = normalised(n, i, j, k);
    const glm::dvec3 half(0.5 * glm::dvec3(n.x, n.y, n.z));
    double fraction = 0;
    for (const Layer& layer : kHead) {
      const glm::dvec3 radius_voxels = layer.radius * half;
      const double smallest = std::min({radius_voxels.x, radius_voxels.y, radius_voxels.z});
      // A boundary about a voxel wide, as in scans.
      const double outside_voxels = (glm::length((u - layer.centre) / layer.radius) - 1) * smallest;
      fraction = glm::mix(fraction, layer.fraction, std::clamp(0.5 - outside_voxels, 0.0, 1.0));
    }
    return mixed(range, fraction);
  });
}

DenseVolume smallHead(VoxelType type) {
  DenseVolume out = head({{38, 45, 33}, type, anisotropicAffine()}, usualRange(type));
  if (type != VoxelType::f32) return out;
  for (std::int64_t i = 0; i < 200; ++i)
    out.set(2 + 7 * i % 33, 3 + 11 * i % 39, 2 + 5 * i % 28, std::numeric_limits<float>::quiet_NaN());
  return out;
}

std::uint64_t hashBits(std::uint64_t seed, std::uint64_t counter) {
  const auto mix = [](std::uint64_t z) {
    z += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  };
  return mix(mix(seed) ^ counter);
}

double hashUnit(std::uint64_t seed, std::uint64_t counter) {
  return static_cast<double>(hashBits(seed, counter) >> 11) * 0x1p-53;
}

DenseSource::DenseSource(const DenseVolume& volume) : volume_(volume) {
  info_.format = "dense";
  info_.geometry = volume.geometry;
  info_.type = volume.type;
}

void DenseSource::read(const VoxelBox& box, std::span<std::byte> out) {
  const Extent3& n = volume_.geometry.dims;
  const std::size_t voxel_bytes = sizeOf(volume_.type);
  const std::size_t row_bytes = static_cast<std::size_t>(box.extent().x) * voxel_bytes;
  assert(intersection(box, boxOf(n)) == box);
  assert(out.size() == static_cast<std::size_t>(box.count()) * voxel_bytes);
  std::byte* to = out.data();
  for (std::int64_t k = box.lo.z; k < box.hi.z; ++k) {
    for (std::int64_t j = box.lo.y; j < box.hi.y; ++j, to += row_bytes) {
      const std::int64_t first = (k * n.y + j) * n.x + box.lo.x;
      std::memcpy(to, volume_.voxels.data() + static_cast<std::size_t>(first) * voxel_bytes, row_bytes);
    }
  }
}

}  // namespace kiln::test
