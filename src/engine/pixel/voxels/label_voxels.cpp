#include "engine/pixel/voxels/label_voxels.h"

#include <algorithm>
#include <array>

namespace kiln {
namespace {

constexpr int kWide = WideOpacities::kWide;

class LabelLoad {
 public:
  LabelLoad(const BrickBlock& block, const SampleLattice& lattice, const SampleTable& table, LabelVoxels& out)
      : block_(block),
        table_(table),
        out_(out),
        reach_(lattice.label_smoothing),
        wide_(LabelVoxels::kEdge + 2 * reach_) {}

  LabelsAround run(const VoxelCoord& lo) {
    withVoxelType(block_.type, [&]<class T>(std::type_identity<T>) { load<T>(lo); });
    if (one_) return first_ < 0 ? LabelsAround::kNone : LabelsAround::kOne;
    out_.wide.smooth(reach_, out_.opacities);
    return LabelsAround::kSeveral;
  }

 private:
  template <class T>
  void load(const VoxelCoord& lo) {
    std::array<std::int64_t, kWide> at[3];
    for (int a = 0; a < 3; ++a) voxelOffsets(block_, a, lo[a] - kPatchMargin - reach_, wide_, at[a].data());
    const T* const voxels = block_.data<T>();
    T last = voxels[at[0][0] + at[1][0] + at[2][0]];
    std::int32_t rank = rankOf(last);
    float opacity = table_.opacityOf(rank);
    const bool masked = !block_.shown.all();
    const auto hides = [&](std::int64_t offset) { return masked && !block_.shown.at(offset); };
    first_ = hides(at[0][0] + at[1][0] + at[2][0]) ? -1 : rank;
    one_ = true;
    const auto reach = static_cast<std::size_t>(reach_), wide = static_cast<std::size_t>(wide_);
    const std::size_t edge = LabelVoxels::kEdge;
    const auto inner = [&](std::size_t i) { return i >= reach && i < reach + edge; };
    for (std::size_t k = 0; k < wide; ++k) {
      for (std::size_t j = 0; j < wide; ++j) {
        const std::int64_t before = at[1][j] + at[2][k];
        const T* const row = voxels + before;
        float* const opacities = &out_.wide.at(0, j, k);
        std::array<std::int32_t, kWide> ranks;
        for (std::size_t i = 0; i < wide; ++i) {
          const T value = row[at[0][i]];
          if (value != last) last = value, rank = rankOf(value), opacity = table_.opacityOf(rank);
          const bool hidden = hides(before + at[0][i]);
          ranks[i] = hidden ? -1 : rank, opacities[i] = hidden ? 0 : opacity;
          one_ = one_ && ranks[i] == first_;
        }
        if (!inner(j) || !inner(k)) continue;
        const std::size_t row_of_patch = (k - reach) * edge + j - reach;
        std::copy_n(ranks.data() + reach, edge, out_.ranks + row_of_patch * kPatchStride);
      }
    }
  }

  template <class T>
  int rankOf(T value) const {
    return table_.rankOf(static_cast<float>(static_cast<double>(value) - table_.offset()));
  }

  const BrickBlock& block_;
  const SampleTable& table_;
  LabelVoxels& out_;
  const int reach_, wide_;
  bool one_ = false;  // all voxels have one label, or none has a label that is shown
  int first_ = -1;
};

}  // namespace

LabelsAround loadLabels(const BrickBlock& block, const SampleLattice& lattice, const VoxelCoord& lo,
                        const SampleTable& table, LabelVoxels& out) {
  return LabelLoad(block, lattice, table, out).run(lo);
}

}  // namespace kiln
