#include "splat/label_samples.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace kiln {
namespace {

constexpr int kWide = LabelVoxels::kWide;

// Binomial, by how far they reach: sums of them are exact halves.
constexpr float kSmoothing[kMostLabelSmoothing + 1][kMostLabelSmoothing + 1] = {
    {1}, {0.5f, 0.25f}, {0.375f, 0.25f, 0.0625f}, {0.3125f, 0.234375f, 0.09375f, 0.015625f}};

class LabelLoad {
 public:
  LabelLoad(const BrickBlock& block, const UnitLattice& lattice, const SampleTable& table, LabelVoxels& out)
      : block_(block), table_(table), out_(out), reach_(lattice.label_smoothing) {
    for (std::size_t a = 0; a < 3; ++a) {
      inner_[a] = lattice.voxels[a] + 2 * kUnitMargin;
      wide_[a] = inner_[a] + 2 * reach_;
    }
  }

  LabelsAround run(const VoxelCoord& lo) {
    withVoxelType(block_.type, [&]<class T>(std::type_identity<T>) { load<T>(lo); });
    if (one_) return first_ < 0 ? LabelsAround::kNone : LabelsAround::kOne;
    smooth();
    return LabelsAround::kSeveral;
  }

 private:
  // Voxels that the brick has not, which no sample of its needs, repeat the nearest.
  template <class T>
  void load(const VoxelCoord& lo) {
    const VoxelBox& has = block_.extent;
    const Extent3 size = has.extent();
    std::array<std::int64_t, kWide> at[3];
    const std::int64_t stride[3] = {1, block_.strideY(), block_.strideZ()};
    for (int a = 0; a < 3; ++a) {
      for (int i = 0; i < wide_[static_cast<std::size_t>(a)]; ++i)
        at[a][static_cast<std::size_t>(i)] =
            std::clamp<std::int64_t>(lo[a] - kUnitMargin - reach_ + i - has.lo[a], 0, size[a] - 1) * stride[a];
    }
    const T* const voxels = block_.data<T>();
    T last = voxels[at[0][0] + at[1][0] + at[2][0]];
    std::int32_t rank = first_ = rankOf(last);
    float opacity = table_.opacityOf(rank);
    one_ = true;
    const auto reach = static_cast<std::size_t>(reach_);
    const auto inner = [&](std::size_t a, std::size_t i) {
      return i >= reach && i < reach + static_cast<std::size_t>(inner_[a]);
    };
    for (std::size_t k = 0; k < static_cast<std::size_t>(wide_[2]); ++k) {
      for (std::size_t j = 0; j < static_cast<std::size_t>(wide_[1]); ++j) {
        const T* const row = voxels + at[1][j] + at[2][k];
        float* const opacities = out_.smoothed[0] + (k * kWide + j) * kWide;
        std::array<std::int32_t, kWide> ranks;
        for (std::size_t i = 0; i < static_cast<std::size_t>(wide_[0]); ++i) {
          const T value = row[at[0][i]];
          if (value != last) {
            last = value, rank = rankOf(value), opacity = table_.opacityOf(rank);
            one_ = one_ && rank == first_;
          }
          ranks[i] = rank, opacities[i] = opacity;
        }
        if (!inner(1, j) || !inner(2, k)) continue;
        const std::size_t row_of_unit = (k - reach) * static_cast<std::size_t>(inner_[1]) + j - reach;
        std::copy_n(ranks.data() + reach, inner_[0], out_.ranks + row_of_unit * kUnitSamples);
      }
    }
  }

  template <class T>
  int rankOf(T value) const {
    return table_.rankOf(static_cast<float>(static_cast<double>(value) - table_.offset()));
  }

  // Along one axis after the other, each of which then has fewer voxels.
  void smooth() {
    float *from = out_.smoothed[0], *to = out_.smoothed[1];
    const int stride[3] = {1, kWide, kWide * kWide};
    std::array<int, 3> size = wide_;
    for (std::size_t a = 0; a < 3 && reach_ > 0; ++a) {
      size[a] = inner_[a];
      for (int k = 0; k < size[2]; ++k) {
        for (int j = 0; j < size[1]; ++j) smoothRow(from, to, (k * kWide + j) * kWide, size[0], stride[a]);
      }
      std::swap(from, to);
    }
    for (int k = 0; k < inner_[2]; ++k) {
      for (int j = 0; j < inner_[1]; ++j)
        std::copy_n(from + (k * kWide + j) * kWide, inner_[0], out_.opacities + (k * inner_[1] + j) * kUnitSamples);
    }
  }

  void smoothRow(const float* from, float* to, int row, int count, int stride) const {
    const float* const weights = kSmoothing[reach_];
    for (int i = row; i < row + count; ++i) {
      const float* const middle = from + i + reach_ * stride;
      float sum = weights[0] * middle[0];
      for (int n = 1; n <= reach_; ++n) sum += weights[n] * (middle[-n * stride] + middle[n * stride]);
      to[i] = sum;
    }
  }

  const BrickBlock& block_;
  const SampleTable& table_;
  LabelVoxels& out_;
  const int reach_;
  std::array<int, 3> inner_{}, wide_{};
  bool one_ = false;  // whether all voxels are one label, or none that is shown
  int first_ = -1;
};

// The voxels along an axis that a sample takes, counted from the first one that is read, and their weights.
struct LabelTaps {
  int count = 0;
  std::array<int, 4> at{};
  std::array<float, 4> weight{};
};

LabelTaps labelTapsOf(const UnitAxis& axis, std::size_t sample, bool cubic) {
  LabelTaps out;
  if (cubic) {
    out.count = 4;
    for (std::size_t n = 0; n < 4; ++n)
      out.at[n] = axis.value.at[n][sample], out.weight[n] = axis.value.weight[n][sample];
    return out;
  }
  const float t = axis.fraction[sample];
  const int base = axis.base[sample];
  out.count = t == 0 ? 1 : 2;
  out.at = {base, base + 1};
  out.weight = {1 - t, t};
  return out;
}

class LabelUnit {
 public:
  LabelUnit(const UnitLattice& lattice, const UnitInput& unit, LabelSamples& out)
      : u_(unit), out_(out), cubic_(lattice.interpolation == Interpolation::kCubic) {
    for (std::size_t a = 0; a < 3; ++a) inner_[a] = lattice.voxels[a] + 2 * kUnitMargin;
  }

  // One label and no surface near.
  void fill() {
    forEachRow([&](int, int, float* places) {
      std::fill(places + u_.first[0], places + u_.end[0], SampleTable::placeOf(out_.voxels.ranks[0], 1));
    });
    for (int row = 0; row < inner_[1] * inner_[2]; ++row)
      std::fill_n(out_.voxels.opacities + row * kUnitSamples, inner_[0], 0.0f);
  }

  void sample() {
    columns_ = {inner_[0], 0};
    for (int i = u_.first[0]; i < u_.end[0]; ++i) {
      const LabelTaps& taps = along_x_[static_cast<std::size_t>(i)] =
          labelTapsOf(*u_.axis[0], static_cast<std::size_t>(i), cubic_);
      for (std::size_t n = 0; n < static_cast<std::size_t>(taps.count); ++n)
        columns_ = {std::min(columns_.first, taps.at[n]), std::max(columns_.second, taps.at[n] + 1)};
    }
    forEachRow([&](int j, int k, float* places) {
      setRows(labelTapsOf(*u_.axis[1], static_cast<std::size_t>(j), cubic_),
              labelTapsOf(*u_.axis[2], static_cast<std::size_t>(k), cubic_));
      setPlaces(places);
    });
  }

 private:
  template <class To>
  void forEachRow(const To& to) const {
    for (int k = u_.first[2]; k < u_.end[2]; ++k) {
      for (int j = u_.first[1]; j < u_.end[1]; ++j) to(j, k, out_.places + (k * kUnitSamples + j) * kUnitSamples);
    }
  }

  void setRows(const LabelTaps& y, const LabelTaps& z) {
    rows_count_ = 0;
    for (std::size_t c = 0; c < static_cast<std::size_t>(z.count); ++c) {
      for (std::size_t b = 0; b < static_cast<std::size_t>(y.count); ++b, ++rows_count_) {
        rows_[rows_count_] = out_.voxels.ranks + (z.at[c] * inner_[1] + y.at[b]) * kUnitSamples;
        weights_[rows_count_] = y.weight[b] * z.weight[c];
      }
    }
  }

  // The ranks of the voxels that the row of samples takes, each once, in order.
  void findRanks() {
    ranks_.clear();
    std::int32_t last = rows_[0][columns_.first];
    ranks_.push_back(last);
    for (std::size_t r = 0; r < rows_count_; ++r) {
      for (int x = columns_.first; x < columns_.second; ++x) {
        if (rows_[r][x] == last) continue;
        last = rows_[r][x];
        if (std::find(ranks_.begin(), ranks_.end(), last) == ranks_.end()) ranks_.push_back(last);
      }
    }
    std::sort(ranks_.begin(), ranks_.end());
  }

  void setPlaces(float* places) {
    findRanks();
    if (ranks_.size() == 1) {
      std::fill(places + u_.first[0], places + u_.end[0], ranks_[0] < 0 ? 0.0f : SampleTable::placeOf(ranks_[0], 1));
      return;
    }
    std::array<float, kUnitSamples> shown{}, most{};
    std::array<std::int32_t, kUnitSamples> best{};
    for (const std::int32_t rank : ranks_) {
      if (rank < 0) continue;
      std::array<float, LabelVoxels::kEdge> column{};
      for (std::size_t r = 0; r < rows_count_; ++r) {
        for (int x = columns_.first; x < columns_.second; ++x)
          column[static_cast<std::size_t>(x)] += rows_[r][x] == rank ? weights_[r] : 0.0f;
      }
      for (auto i = static_cast<std::size_t>(u_.first[0]); i < static_cast<std::size_t>(u_.end[0]); ++i) {
        const LabelTaps& taps = along_x_[i];
        float share = 0;
        for (std::size_t n = 0; n < static_cast<std::size_t>(taps.count); ++n)
          share += taps.weight[n] * column[static_cast<std::size_t>(taps.at[n])];
        shown[i] += share;
        if (share > most[i]) most[i] = share, best[i] = rank;
      }
    }
    for (auto i = static_cast<std::size_t>(u_.first[0]); i < static_cast<std::size_t>(u_.end[0]); ++i)
      places[i] = labelPlace(shown[i], best[i]);
  }

  const UnitInput& u_;
  LabelSamples& out_;
  const bool cubic_;
  std::array<int, 3> inner_{};
  std::array<LabelTaps, kUnitSamples> along_x_;
  std::size_t rows_count_ = 0;  // of voxels that the row of samples in turn takes
  std::array<const std::int32_t*, 16> rows_;
  std::array<float, 16> weights_;
  std::pair<int, int> columns_;  // that samples take, half-open
  std::vector<std::int32_t> ranks_;
};

}  // namespace

LabelsAround loadLabels(const BrickBlock& block, const UnitLattice& lattice, const VoxelCoord& lo,
                        const SampleTable& table, LabelVoxels& out) {
  return LabelLoad(block, lattice, table, out).run(lo);
}

bool sampleLabels(const BrickBlock& block, const UnitLattice& lattice, const UnitInput& unit, const VoxelCoord& lo,
                  const SampleTable& table, LabelSamples& out) {
  const LabelsAround around = loadLabels(block, lattice, lo, table, out.voxels);
  if (around == LabelsAround::kNone) return false;
  LabelUnit places(lattice, unit, out);
  if (around == LabelsAround::kOne)
    places.fill();
  else
    places.sample();
  return true;
}

}  // namespace kiln
