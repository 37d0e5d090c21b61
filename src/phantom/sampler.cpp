// The box that is asked for, cut into regions and blocks at fixed places: a region without a shape near is air and
// costs its noise only, the others go to the painter block by block.
#include "phantom/sampler.h"

#include <algorithm>

#include "phantom/noise.h"
#include "phantom/painter.h"
#include "phantom/vectors.h"

namespace kiln::phantom {
namespace {

constexpr std::int64_t kRegionEdge = 32;  // blocks of a region share the first choice of shapes

// Clean value to voxel: one rounding, the same for a row of tissue and a row of air.
struct Finish {
  float scale, highest;
  template <class T>
  T operator()(float clean, const NoiseRow& row, std::uint32_t x) const noexcept {
    const float noise = (static_cast<float>(static_cast<std::int32_t>(noiseSum(row, x))) - kNoiseMean) * scale;
    return static_cast<T>(static_cast<std::int32_t>(std::min(std::max(clean + noise, 0.f), highest) + 0.5f));
  }
};

// A row of `count` voxels of one clean value, from x = first.
template <class T>
void finishEven(Finish finish, float clean, NoiseRow noise, std::uint32_t first, std::uint32_t count, T* to) noexcept {
  for (std::uint32_t i = 0; i < count; ++i) to[i] = finish.operator()<T>(clean, noise, first + i);
}
// A row of a block.
template <class T>
void finishRow(Finish finish, const float* clean, NoiseRow noise, std::uint32_t first, T* to) noexcept {
  for (std::uint32_t i = 0; i < kEdge; ++i) to[i] = finish.operator()<T>(clean[i], noise, first + i);
}
// The same by the vectors that there are.
KILN_VECTORS void finish(Finish how, float clean, NoiseRow noise, std::uint32_t first, std::uint32_t count,
                         std::uint8_t* to) noexcept {
  finishEven(how, clean, noise, first, count, to);
}
KILN_VECTORS void finish(Finish how, float clean, NoiseRow noise, std::uint32_t first, std::uint32_t count,
                         std::uint16_t* to) noexcept {
  finishEven(how, clean, noise, first, count, to);
}
KILN_VECTORS void finish(Finish how, const float* clean, NoiseRow noise, std::uint32_t first,
                         std::uint8_t* to) noexcept {
  finishRow(how, clean, noise, first, to);
}
KILN_VECTORS void finish(Finish how, const float* clean, NoiseRow noise, std::uint32_t first,
                         std::uint16_t* to) noexcept {
  finishRow(how, clean, noise, first, to);
}

// The regions that meet the box, as one box.
VoxelBox regionsAround(const VoxelBox& box) {
  VoxelBox out = box;
  for (int axis = 0; axis < 3; ++axis) {
    out.lo[axis] = box.lo[axis] / kRegionEdge * kRegionEdge;
    out.hi[axis] = (box.hi[axis] + kRegionEdge - 1) / kRegionEdge * kRegionEdge;
  }
  return out;
}

// Calls f for each cube of `edge`, aligned to multiples of it, that meets the box.
template <class F>
void forCubes(const VoxelBox& box, std::int64_t edge, F&& f) {
  const auto down = [&](std::int64_t v) { return v / edge * edge; };
  for (std::int64_t z = down(box.lo.z); z < box.hi.z; z += edge) {
    for (std::int64_t y = down(box.lo.y); y < box.hi.y; y += edge) {
      for (std::int64_t x = down(box.lo.x); x < box.hi.x; x += edge) {
        f(VoxelBox{{x, y, z}, {x + edge, y + edge, z + edge}});
      }
    }
  }
}

// The box that was asked for, filled part by part.
template <class T>
class Canvas {
 public:
  Canvas(const VoxelBox& box, T* out, const Lattice& lattice, const ValueTable& values, std::uint64_t seed)
      : box_(box),
        n_(box.extent()),
        out_(out),
        lattice_(lattice),
        finish_{values.noise_sigma / kNoiseDeviation, values.highest},
        air_(values.of(Tissue::kAir)),
        seed_(seed) {}

  void paintAir(const VoxelBox& part) const { paintEven(part, air_); }
  void paintEven(const VoxelBox& part, float clean) const;
  // The block's voxels that are in the box.
  void paintBlock(const VoxelBox& block, const Painter& painter, const NearShapes& near, Work& work) const;

 private:
  T* row(std::int64_t x, std::int64_t y, std::int64_t z) const {
    return out_ + ((z - box_.lo.z) * n_.y + (y - box_.lo.y)) * n_.x + (x - box_.lo.x);
  }

  VoxelBox box_;
  Extent3 n_;
  T* out_;
  const Lattice& lattice_;
  Finish finish_;
  float air_;
  std::uint64_t seed_;
};

template <class T>
void Canvas<T>::paintEven(const VoxelBox& part, float clean) const {
  const auto first = static_cast<std::uint32_t>(part.lo.x), count = static_cast<std::uint32_t>(part.extent().x);
  for (std::int64_t z = part.lo.z; z < part.hi.z; ++z) {
    for (std::int64_t y = part.lo.y; y < part.hi.y; ++y) {
      finish(finish_, clean, noiseRow(seed_, y, z), first, count, row(part.lo.x, y, z));
    }
  }
}

template <class T>
void Canvas<T>::paintBlock(const VoxelBox& block, const Painter& painter, const NearShapes& near, Work& work) const {
  const VoxelBox part = intersection(block, box_);
  for (int i = 0; i < kEdge; ++i) {
    const glm::vec3 p = lattice_.centreOf({block.lo.x + i, block.lo.y + i, block.lo.z + i});
    work.x[i] = p.x, work.y[i] = p.y, work.z[i] = p.z;
  }
  work.lo_y = static_cast<int>(part.lo.y - block.lo.y), work.hi_y = static_cast<int>(part.hi.y - block.lo.y);
  work.lo_z = static_cast<int>(part.lo.z - block.lo.z), work.hi_z = static_cast<int>(part.hi.z - block.lo.z);
  if (const std::optional<float> even = painter.paint(near, work)) return paintEven(part, *even);
  work.rows([&](int at) {
    const std::int64_t y = block.lo.y + at / kEdge % kEdge, z = block.lo.z + at / kEdge / kEdge;
    const auto first = static_cast<std::uint32_t>(block.lo.x);
    T* const to = row(part.lo.x, y, z);
    if (part.extent().x == kEdge) return finish(finish_, work.value + at, noiseRow(seed_, y, z), first, to);
    T voxels[kEdge];
    finish(finish_, work.value + at, noiseRow(seed_, y, z), first, voxels);
    std::copy(voxels + (part.lo.x - block.lo.x), voxels + (part.hi.x - block.lo.x), to);
  });
}

}  // namespace

glm::vec3 Lattice::centreOf(const VoxelCoord& v) const {
  glm::vec3 out;
  for (int i = 0; i < 3; ++i) {
    out[i] = static_cast<float>(corner_mm[i] + (static_cast<double>(v[i]) + 0.5) * spacing_mm[i]);
  }
  return out;
}

template <class T>
void Sampler::sample(const VoxelBox& box, T* out) const {
  if (box.empty()) return;
  const Canvas<T> canvas(box, out, lattice_, values_, seed_);
  const Painter painter(figure_, lattice_, values_);
  NearShapes of_box, of_region, of_block;
  Work work;
  painter.choose(regionsAround(box), of_box);
  forCubes(box, kRegionEdge, [&](const VoxelBox& region) {
    const VoxelBox part = intersection(region, box);
    painter.choose(region, of_box, of_region);
    if (of_region.parts.empty()) return canvas.paintAir(part);
    forCubes(part, kEdge, [&](const VoxelBox& block) {
      painter.choose(block, of_region, of_block);
      if (of_block.parts.empty()) return canvas.paintAir(intersection(block, box));
      canvas.paintBlock(block, painter, of_block, work);
    });
  });
}

template void Sampler::sample(const VoxelBox&, std::uint8_t*) const;
template void Sampler::sample(const VoxelBox&, std::uint16_t*) const;

}  // namespace kiln::phantom
