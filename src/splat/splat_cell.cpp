#include "splat/splat_cell.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "splat/lay_voxels.h"
#include "splat/project_voxels.h"

namespace kiln {
namespace {

// The voxels of a cell that are not transparent are found first, front to back, and then go through the kernels batch
// by batch. Between the kernels each of them is asked about, so that what is hidden costs neither gradient nor light;
// what a batch's own voxels close of each other is asked of the next one.
template <class T>
class CellSplatter {
 public:
  CellSplatter(const SplatFrame& frame, const BrickBlock& block, const TilePixels& tile, SplatCounts& counts)
      : frame_(frame), block_(block), voxels_(block.data<T>()), tile_(tile), counts_(counts), ends_(frame.ends.any()) {}

  void cell(const VoxelBox& box) {
    lo_ = box.lo;
    first_ = voxels_ + block_.offsetOf(lo_);
    cut_ = frame_.clip->classify(box) == ClipRegion::Overlap::kCut;
    more_ = cut_ || !frame_.light_is_plain || frame_.gradient_opacity.active() || tile_.aovs.any();
    find(box);
    for (std::size_t n = 0; n < found_count_; n += kVoxelBatch) batch(n);
  }

 private:
  static constexpr std::size_t kMost = std::size_t{kCellSize} * kCellSize * kCellSize;

  void find(const VoxelBox& box) {
    std::uint8_t order[3][kCellSize];
    int count[3] = {};
    for (int axis = 0; axis < 3; ++axis) {
      count[axis] = static_cast<int>(box.hi[axis] - box.lo[axis]);
      frame_.projector->order().axisOrder(axis, box.lo[axis], count[axis], order[axis]);
    }
    std::size_t n = 0;
    for (int k = 0; k < count[2]; ++k) {
      for (int j = 0; j < count[1]; ++j) {
        const std::int32_t row = voxelCode(0, order[1][j], order[2][k]);
        const T* const values = first_ + offsetOf(row);
        for (int i = 0; i < count[0]; ++i) {
          const int x = order[0][i];
          // Where it is transparent, the next one takes its place.
          codes_[n] = row + x;
          n += shows(values[x]) ? 1 : 0;
        }
      }
    }
    found_count_ = n;
  }

  bool shows(T value) const {
    if constexpr (std::is_floating_point_v<T>) {
      if (std::isnan(value)) return false;
    }
    return frame_.classifier->shows(value);
  }

  void batch(std::size_t first) {
    const auto count = static_cast<int>(std::min<std::size_t>(found_count_ - first, kVoxelBatch));
    ProjectedVoxels projected;
    projectVoxels(frame_.view, lo_, codes_ + first, count, tile_.rect, projected);
    ShadedVoxels shaded;
    std::uint32_t drawn = 0;
    for (std::uint32_t rest = projected.touching; rest != 0; rest &= rest - 1) {
      const auto n = static_cast<std::size_t>(std::countr_zero(rest));
      const std::int32_t code = codes_[first + n];
      if (cut_ && !frame_.clip->contains(indexOf(code))) continue;
      const std::uint32_t counted = projected.inside >> n & 1;
      counts_.visited += counted;
      if (frame_.test_samples && frame_.visibility->hidden(intersection(projected.rect(n), tile_.rect))) continue;
      counts_.splats += counted;
      drawn |= 1u << n;
      take(code, n, shaded);
    }
    if (drawn == 0) return;
    counts_.changed = true;
    layVoxels(frame_.view, projected, shaded, drawn, tile_, frame_.opaque_at, *frame_.visibility);
  }

  // What the second kernel asks of a voxel that is drawn, as the n-th of its batch.
  void take(std::int32_t code, std::size_t n, ShadedVoxels& shaded) const {
    const T* const at = first_ + offsetOf(code);
    const glm::vec3 slope = gradient(at);
    for (int axis = 0; axis < 3; ++axis) shaded.slope[axis][n] = slope[axis];
    Material material = frame_.classifier->at(*at);
    if (more_) takeMore(code, n, slope, material, shaded);
    if (ends_) material.tau *= static_cast<float>(frame_.ends.partOf(voxelAt(lo_, code)));
    std::memcpy(shaded.material + 4 * n, &material, sizeof material);
  }

  // The same beyond the second kernel: colours of other lights and of cuts, opacity by gradient, and AOVs.
  void takeMore(std::int32_t code, std::size_t n, const glm::vec3& measured, Material& material,
                ShadedVoxels& shaded) const {
    // Beside a NaN or an infinity there is no slope to shade by.
    const glm::vec3 slope = std::isfinite(measured.x + measured.y + measured.z) ? measured : glm::vec3(0);
    const Shader& shader = frame_.shader;
    const glm::dvec3 p = frame_.projector->viewOf(voxelAt(lo_, code));
    if (frame_.gradient_opacity.active()) material.tau = frame_.gradient_opacity(material.tau, slope);
    const glm::vec3* const face = cut_ ? frame_.clip->cutGradient(indexOf(code)) : nullptr;
    if (face != nullptr || !frame_.light_is_plain) {
      const Color color = face != nullptr ? shader.onCut(material, *face, p) : shader(material, slope, p);
      material = {color.r, color.g, color.b, material.tau};
      for (auto& axis : shaded.slope) axis[n] = 0;
    }
    if (tile_.aovs.any())
      shaded.aov[n] = {static_cast<float>(p.z),
                       face != nullptr ? shader.normalOnCut(*face, p) : shader.normal(slope, p)};
  }

  std::ptrdiff_t offsetOf(std::int32_t code) const {
    return (code & 15) + (code >> 4 & 15) * block_.strideY() + (code >> 8) * block_.strideZ();
  }
  glm::dvec3 indexOf(std::int32_t code) const {
    const VoxelCoord v = voxelAt(lo_, code);
    return {v.x, v.y, v.z};
  }

  // Central differences at voxel scale, of labels those of their opacities. unit: value per voxel.
  glm::vec3 gradient(const T* at) const {
    const Classifier& classifier = *frame_.classifier;
    const auto half = [&](T hi, T lo) {
      if (classifier.ofLabels())
        return 0.5f * (classifier.opacityOf(static_cast<double>(hi)) - classifier.opacityOf(static_cast<double>(lo)));
      if constexpr (sizeof(T) >= 4 && !std::is_same_v<T, float>) {
        return static_cast<float>(0.5 * (static_cast<double>(hi) - static_cast<double>(lo)));
      } else {
        return 0.5f * (static_cast<float>(hi) - static_cast<float>(lo));
      }
    };
    const std::ptrdiff_t y = block_.strideY();
    const std::ptrdiff_t z = block_.strideZ();
    return {half(at[1], at[-1]), half(at[y], at[-y]), half(at[z], at[-z])};
  }

  const SplatFrame& frame_;
  const BrickBlock& block_;
  const T* voxels_;
  const TilePixels& tile_;
  SplatCounts& counts_;
  const bool ends_;  // whether some voxels exist in part
  // The cell in turn.
  VoxelCoord lo_;
  const T* first_ = nullptr;
  bool cut_ = false;   // by the clip region
  bool more_ = false;  // whether voxels need more than the kernels know
  std::size_t found_count_ = 0;
  std::int32_t codes_[kMost + kVoxelBatch];
};

}  // namespace

void splatCell(const SplatFrame& frame, const BrickBlock& block, const VoxelBox& cell, const TilePixels& tile,
               SplatCounts& counts) noexcept {
  withVoxelType(block.type,
                [&]<class T>(std::type_identity<T>) { CellSplatter<T>(frame, block, tile, counts).cell(cell); });
}

}  // namespace kiln
