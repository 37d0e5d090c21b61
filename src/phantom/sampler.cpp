// Method. The requested box is cut into regions and blocks at fixed positions. A region without a near shape is air and
// needs only noise; in all further regions the painter computes block by block. A row of blocks of a region is painted,
// then noise is added to the whole row, vectorised.
#include "phantom/sampler.h"

#include <algorithm>
#include <array>
#include <vector>

#include "base/vectors.h"
#include "phantom/noise.h"
#include "phantom/painter.h"

namespace kiln::phantom {
namespace {

constexpr int kRegionEdge = 32;  // blocks of a region share the first selection of shapes

// Converts a value without noise to a voxel, with one rounding.
struct Finish {
  float scale, highest;
  template <class T>
  T operator()(float clean, const NoiseRow& row, std::uint32_t x) const noexcept {
    const float noise = (static_cast<float>(static_cast<std::int32_t>(noiseSum(row, x))) - kNoiseMean) * scale;
    return static_cast<T>(static_cast<std::int32_t>(std::min(std::max(clean + noise, 0.f), highest) + 0.5f));
  }
};

// Rows that begin at x = first, and the strides between rows.
template <class T>
struct Rows {
  std::int64_t count;
  std::uint32_t first;
  const NoiseRow* noise;
  const float* clean;
  std::int64_t clean_step;
  T* to;
  std::int64_t step;
};
template <int kWidth, class T>
void finishRows(Finish finish, const Rows<T>& rows) noexcept {
  for (std::int64_t row = 0; row < rows.count; ++row) {
    const float* const clean = rows.clean + row * rows.clean_step;
    const NoiseRow noise = rows.noise[row];
    T* const to = rows.to + row * rows.step;
    for (std::uint32_t i = 0; i < kWidth; ++i) to[i] = finish.operator()<T>(clean[i], noise, rows.first + i);
  }
}
// Rows of a whole region, and of a block.
KILN_VECTORS void finishWide(Finish how, const Rows<std::uint8_t>& rows) noexcept {
  finishRows<kRegionEdge>(how, rows);
}
KILN_VECTORS void finishWide(Finish how, const Rows<std::uint16_t>& rows) noexcept {
  finishRows<kRegionEdge>(how, rows);
}
KILN_VECTORS void finishNarrow(Finish how, const Rows<std::uint8_t>& rows) noexcept { finishRows<kEdge>(how, rows); }
KILN_VECTORS void finishNarrow(Finish how, const Rows<std::uint16_t>& rows) noexcept { finishRows<kEdge>(how, rows); }

// The box of all regions that meet the box.
VoxelBox regionsAround(const VoxelBox& box) {
  VoxelBox out = box;
  for (int axis = 0; axis < 3; ++axis) {
    out.lo[axis] = box.lo[axis] / kRegionEdge * kRegionEdge;
    out.hi[axis] = (box.hi[axis] + kRegionEdge - 1) / kRegionEdge * kRegionEdge;
  }
  return out;
}

// Calls f for each box of size `edges`, aligned to multiples of `edges`, that meets the box.
template <class F>
void forBoxes(const VoxelBox& box, const Extent3& edges, F&& f) {
  const auto down = [&](int axis) { return box.lo[axis] / edges[axis] * edges[axis]; };
  for (std::int64_t z = down(2); z < box.hi.z; z += edges.z) {
    for (std::int64_t y = down(1); y < box.hi.y; y += edges.y) {
      for (std::int64_t x = down(0); x < box.hi.x; x += edges.x) {
        f(VoxelBox{{x, y, z}, {x + edges.x, y + edges.y, z + edges.z}});
      }
    }
  }
}

// Values without noise of a row of blocks in a region; a block has kEdge³ voxels.
struct Strip {
  static constexpr std::int64_t kSlice = kEdge * kRegionEdge;
  alignas(64) std::array<float, kEdge * kSlice> clean;
};

// The requested box, filled part by part.
template <class T>
class Canvas {
 public:
  Canvas(const VoxelBox& box, T* out, const ValueTable& values, std::uint64_t seed)
      : box_(box), n_(box.extent()), out_(out), finish_{values.noise_sigma / kNoiseDeviation, values.highest} {
    noise_.reserve(static_cast<std::size_t>(n_.y * n_.z));
    for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
      for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) noise_.push_back(noiseRow(seed, y, z));
    }
    air_.fill(values.of(Tissue::kAir));
  }

  // requires for both functions: `part` lies within a region.
  void finishAir(const VoxelBox& part) const { finishPart(part, air_.data(), 0, 0); }
  void finishStrip(const VoxelBox& part, const Strip& strip) const {
    finishPart(part, strip.clean.data() + (part.lo.z % kEdge) * Strip::kSlice + (part.lo.y % kEdge) * kRegionEdge,
               kRegionEdge, Strip::kSlice);
  }

 private:
  // Fills a part of a region. `clean` starts at the region's first x and the part's first y and z.
  void finishPart(const VoxelBox& part, const float* clean, std::int64_t row, std::int64_t slice) const;
  void finishBlocks(const VoxelBox& part, Rows<T> rows) const;

  VoxelBox box_;
  Extent3 n_;
  T* out_;
  Finish finish_;
  std::vector<NoiseRow> noise_;  // for the rows of the box
  alignas(64) std::array<float, kRegionEdge> air_;
};

template <class T>
void Canvas<T>::finishPart(const VoxelBox& part, const float* clean, std::int64_t row, std::int64_t slice) const {
  const Extent3 n = part.extent();
  for (std::int64_t z = 0; z < n.z; ++z) {
    const std::int64_t at = (part.lo.z + z - box_.lo.z) * n_.y + (part.lo.y - box_.lo.y);
    const Rows<T> rows = {n.y,
                          static_cast<std::uint32_t>(part.lo.x / kRegionEdge * kRegionEdge),
                          noise_.data() + at,
                          clean + z * slice,
                          row,
                          out_ + at * n_.x + (part.lo.x - box_.lo.x),
                          n_.x};
    if (n.x == kRegionEdge)
      finishWide(finish_, rows);
    else
      finishBlocks(part, rows);
  }
}

// Fills a part whose rows are shorter than a region: computes the rows of all blocks that meet the part and copies the
// requested voxels.
template <class T>
void Canvas<T>::finishBlocks(const VoxelBox& part, Rows<T> rows) const {
  const std::int64_t region = rows.first;
  T* const to = rows.to;
  std::array<T, kRegionEdge * kEdge> voxels;
  rows.to = voxels.data();
  rows.step = kEdge;
  for (std::int64_t x = part.lo.x / kEdge * kEdge; x < part.hi.x; x += kEdge) {
    const std::int64_t lo = std::max(x, part.lo.x), hi = std::min(x + kEdge, part.hi.x);
    Rows<T> block = rows;
    block.first = static_cast<std::uint32_t>(x);
    block.clean += x - region;
    finishNarrow(finish_, block);
    for (std::int64_t row = 0; row < rows.count; ++row)
      std::copy_n(voxels.data() + row * kEdge + (lo - x), hi - lo, to + row * n_.x + (lo - part.lo.x));
  }
}

// Computes the rows of a block without noise into the strip of its region.
void paintBlock(const VoxelBox& block, const VoxelBox& part, const Lattice& lattice, const Painter& painter,
                const NearShapes& near, Work& work, Strip& strip) {
  for (int i = 0; i < kEdge; ++i) {
    const glm::vec3 p = lattice.centreOf({block.lo.x + i, block.lo.y + i, block.lo.z + i});
    work.x[i] = p.x, work.y[i] = p.y, work.z[i] = p.z;
  }
  work.lo_y = static_cast<int>(part.lo.y - block.lo.y), work.hi_y = static_cast<int>(part.hi.y - block.lo.y);
  work.lo_z = static_cast<int>(part.lo.z - block.lo.z), work.hi_z = static_cast<int>(part.hi.z - block.lo.z);
  const std::optional<float> even = painter.paint(near, work);
  float* const to = strip.clean.data() + block.lo.x % kRegionEdge;
  work.rows([&](int at) {
    float* const row = to + at / kEdge * kRegionEdge;
    if (even)
      std::fill_n(row, kEdge, *even);
    else
      std::copy_n(work.value + at, kEdge, row);
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
  const Canvas<T> canvas(box, out, values_, seed_);
  const Painter painter(figure_, lattice_, values_);
  NearShapes of_box, of_region, of_block;
  Work work;
  Strip strip;
  painter.choose(regionsAround(box), of_box);
  forBoxes(box, {kRegionEdge, kRegionEdge, kRegionEdge}, [&](const VoxelBox& region) {
    const VoxelBox in_region = intersection(region, box);
    painter.choose(region, of_box, of_region);
    if (of_region.parts.empty()) return canvas.finishAir(in_region);
    forBoxes(in_region, {kRegionEdge, kEdge, kEdge}, [&](const VoxelBox& row) {
      const VoxelBox part = intersection(row, in_region);
      forBoxes(part, {kEdge, kEdge, kEdge}, [&](const VoxelBox& block) {
        painter.choose(block, of_region, of_block);
        paintBlock(block, intersection(block, part), lattice_, painter, of_block, work, strip);
      });
      canvas.finishStrip(part, strip);
    });
  });
}

template void Sampler::sample(const VoxelBox&, std::uint8_t*) const;
template void Sampler::sample(const VoxelBox&, std::uint16_t*) const;

}  // namespace kiln::phantom
