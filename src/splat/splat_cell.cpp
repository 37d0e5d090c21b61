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

// Which voxels of a row are found, in which order: a row is one look-up. By the voxel that is first from front to back
// (from it those below it descend, then those above it ascend) and by the bits of those that show something.
struct RowOrders {
  std::int32_t codes[kSplatCellSize][1 << kSplatCellSize][kSplatCellSize];  // then anything
  std::uint8_t count[1 << kSplatCellSize];
};
constexpr RowOrders kRowOrders = [] {
  RowOrders out{};
  for (unsigned shown = 0; shown < 1 << kSplatCellSize; ++shown) {
    out.count[shown] = static_cast<std::uint8_t>(std::popcount(shown));
    for (int first = 0; first < kSplatCellSize; ++first) {
      std::int32_t* to = out.codes[first][shown];
      const auto find = [&](int x) {
        if ((shown >> x & 1) != 0) *to++ = voxelCode(x, 0, 0);
      };
      for (int x = first; x >= 0; --x) find(x);
      for (int x = first + 1; x < kSplatCellSize; ++x) find(x);
    }
  }
  return out;
}();

// The voxels of a cell that are not transparent are found first, front to back, and then go through the kernels batch
// by batch. Between the kernels each of them is asked about, so that what is hidden costs neither gradient nor light;
// what a batch's own voxels close of each other is asked of the next one.
template <class T>
class CellSplatter {
 public:
  CellSplatter(const SplatFrame& frame, const BrickBlock& block, TilePlanes& planes, SplatCounts& counts)
      : frame_(frame), block_(block), voxels_(block.data<T>()), planes_(planes), counts_(counts) {}

  void cell(const VoxelBox& box) {
    lo_ = box.lo;
    first_ = voxels_ + block_.offsetOf(lo_);
    cut_ = frame_.clip->classify(box) == ClipRegion::Overlap::kCut;
    ends_ = frame_.ends.any() && endsIn(box);
    more_ = cut_ || ends_ || !frame_.light_is_plain || frame_.gradient_opacity.active() || planes_.aovs().any();
    find(box);
    for (std::size_t n = 0; n < found_count_; n += kVoxelBatch) batch(n);
  }

 private:
  static constexpr std::size_t kMost = std::size_t{kSplatCellSize} * kSplatCellSize * kSplatCellSize;

  bool endsIn(const VoxelBox& box) const {
    const VoxelCoord& last = frame_.ends.last;
    return last.x < box.hi.x || last.y < box.hi.y || last.z < box.hi.z;
  }

  void find(const VoxelBox& box) {
    std::uint8_t order[3][kSplatCellSize];
    int count[3] = {};
    for (int axis = 0; axis < 3; ++axis) {
      count[axis] = static_cast<int>(box.hi[axis] - box.lo[axis]);
      frame_.projector->order().axisOrder(axis, box.lo[axis], count[axis], order[axis]);
    }
    const auto shows = frame_.classifier->shows<T>();
    const auto shownOf = [&](const T* values, int voxels) {
      unsigned bits = 0;
      for (int x = 0; x < voxels; ++x) bits |= static_cast<unsigned>(shows(values[x])) << x;
      return bits;
    };
    const auto& packed = kRowOrders.codes[order[0][0]];
    std::int32_t* to = codes_;
    for (int k = 0; k < count[2]; ++k) {
      for (int j = 0; j < count[1]; ++j) {
        const std::int32_t row = voxelCode(0, order[1][j], order[2][k]);
        const T* const values = first_ + offsetOf(row);
        const unsigned shown = count[0] == kSplatCellSize ? shownOf(values, kSplatCellSize) : shownOf(values, count[0]);
        for (int i = 0; i < kSplatCellSize; ++i) to[i] = row + packed[shown][i];
        to += kRowOrders.count[shown];
      }
    }
    found_count_ = static_cast<std::size_t>(to - codes_);
  }

  void batch(std::size_t first) {
    const auto count = static_cast<int>(std::min<std::size_t>(found_count_ - first, kVoxelBatch));
    ProjectedVoxels projected;
    projectVoxels(frame_.view, lo_, codes_ + first, count, planes_.rect(), projected);
    std::uint32_t drawn = projected.touching;
    if (cut_) {
      forEach(projected.touching, [&](std::size_t n) {
        if (!frame_.clip->contains(indexOf(codes_[first + n]))) drawn &= ~(1u << n);
      });
    }
    counts_.visited += static_cast<std::uint64_t>(std::popcount(drawn & projected.inside));
    if (frame_.test_samples && drawn != 0) drawn = openOf(projected, drawn);
    counts_.splats += static_cast<std::uint64_t>(std::popcount(drawn & projected.inside));
    if (drawn == 0) return;
    counts_.changed = true;
    ShadedVoxels shaded;
    take(drawn, codes_ + first, shaded);
    layVoxels(frame_.view, projected, shaded, drawn, planes_, frame_.opaque_at, *frame_.visibility);
  }

  // Those of `asked` that have an open pixel. All of a batch are nearly as large, and where that is large, the
  // structure knows it in fewer words.
  std::uint32_t openOf(const ProjectedVoxels& projected, std::uint32_t asked) const {
    constexpr std::uint64_t kLarge = 1024;  // unit: pixels
    if (projected.rect(static_cast<std::size_t>(std::countr_zero(asked))).count() <= kLarge)
      return planes_.open(projected, asked);
    std::uint32_t out = 0;
    forEach(asked, [&](std::size_t n) {
      const bool hidden = frame_.visibility->hidden(intersection(projected.rect(n), planes_.rect()));
      out |= (hidden ? 0u : 1u) << n;
    });
    return out;
  }

  template <class F>
  static void forEach(std::uint32_t drawn, F f) {
    for (; drawn != 0; drawn &= drawn - 1) f(static_cast<std::size_t>(std::countr_zero(drawn)));
  }

  // What the second kernel asks of the voxels that are drawn.
  void take(std::uint32_t drawn, const std::int32_t* codes, ShadedVoxels& shaded) const {
    forEach(drawn, [&](std::size_t n) {
      const Material material = frame_.classifier->at(first_[offsetOf(codes[n])]);
      std::memcpy(shaded.material + 4 * n, &material, sizeof material);
    });
    if (frame_.view.light.phong || more_) takeSlopes(drawn, codes, shaded);
    if (more_) forEach(drawn, [&](std::size_t n) { takeMore(codes[n], n, shaded); });
  }

  // Central differences at voxel scale, of labels those of their opacities. unit: value per voxel.
  void takeSlopes(std::uint32_t drawn, const std::int32_t* codes, ShadedVoxels& shaded) const {
    const Classifier& classifier = *frame_.classifier;
    const std::ptrdiff_t strides[3] = {1, block_.strideY(), block_.strideZ()};
    const auto take = [&](auto& to, auto of) {
      forEach(drawn, [&](std::size_t n) {
        const T* const at = first_ + offsetOf(codes[n]);
        for (int axis = 0; axis < 3; ++axis) to[axis][n] = of(at[strides[axis]], at[-strides[axis]]);
      });
    };
    if (classifier.ofLabels()) {
      const auto opacity = [&](T label) { return classifier.opacityOf(static_cast<double>(label)); };
      take(shaded.slope, [&](T hi, T lo) { return 0.5f * (opacity(hi) - opacity(lo)); });
    } else if constexpr (sizeof(T) <= 2) {
      take(shaded.slope, [](T hi, T lo) {
        return 0.5f * static_cast<float>(static_cast<std::int32_t>(hi) - static_cast<std::int32_t>(lo));
      });
    } else if constexpr (std::is_same_v<T, float>) {
      take(shaded.slope, [](T hi, T lo) { return 0.5f * (hi - lo); });
    } else {
      take(shaded.slope,
           [](T hi, T lo) { return static_cast<float>(0.5 * (static_cast<double>(hi) - static_cast<double>(lo))); });
    }
  }

  // What of voxel n is beyond the second kernel: colours of other lights and of cuts, opacity by gradient, AOVs, and
  // voxels that exist in part.
  void takeMore(std::int32_t code, std::size_t n, ShadedVoxels& shaded) const {
    const glm::vec3 measured(shaded.slope[0][n], shaded.slope[1][n], shaded.slope[2][n]);
    // Beside a NaN or an infinity there is no slope to shade by.
    const glm::vec3 slope = std::isfinite(measured.x + measured.y + measured.z) ? measured : glm::vec3(0);
    const Shader& shader = frame_.shader;
    const glm::dvec3 p = frame_.projector->viewOf(voxelAt(lo_, code));
    const float* const m = shaded.material + 4 * n;
    Material material = {m[0], m[1], m[2], m[3]};
    if (frame_.gradient_opacity.active()) material.tau = frame_.gradient_opacity(material.tau, slope);
    const glm::vec3* const face = cut_ ? frame_.clip->cutGradient(indexOf(code)) : nullptr;
    if (face != nullptr || !frame_.light_is_plain) {
      const Color color = face != nullptr ? shader.onCut(material, *face, p) : shader(material, slope, p);
      material = {color.r, color.g, color.b, material.tau};
      for (auto& axis : shaded.slope) axis[n] = 0;
    }
    if (planes_.aovs().any())
      shaded.aov[n] = {static_cast<float>(p.z),
                       face != nullptr ? shader.normalOnCut(*face, p) : shader.normal(slope, p)};
    if (ends_) material.tau *= static_cast<float>(frame_.ends.partOf(voxelAt(lo_, code)));
    std::memcpy(shaded.material + 4 * n, &material, sizeof material);
  }

  std::ptrdiff_t offsetOf(std::int32_t code) const {
    return (code & 15) + (code >> 4 & 15) * block_.strideY() + (code >> 8) * block_.strideZ();
  }
  glm::dvec3 indexOf(std::int32_t code) const {
    const VoxelCoord v = voxelAt(lo_, code);
    return {v.x, v.y, v.z};
  }

  const SplatFrame& frame_;
  const BrickBlock& block_;
  const T* voxels_;
  TilePlanes& planes_;
  SplatCounts& counts_;
  // The cell in turn.
  VoxelCoord lo_;
  const T* first_ = nullptr;
  bool cut_ = false;   // by the clip region
  bool ends_ = false;  // whether some of its voxels exist in part
  bool more_ = false;  // whether voxels need more than the kernels know
  std::size_t found_count_ = 0;
  std::int32_t codes_[kMost + kVoxelBatch];
};

}  // namespace

void splatCell(const SplatFrame& frame, const BrickBlock& block, const VoxelBox& cell, TilePlanes& planes,
               SplatCounts& counts) noexcept {
  withVoxelType(block.type,
                [&]<class T>(std::type_identity<T>) { CellSplatter<T>(frame, block, planes, counts).cell(cell); });
}

}  // namespace kiln
