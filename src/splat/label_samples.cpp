#include "splat/label_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "scene/label_looks.h"

namespace kiln {
namespace {

constexpr int kWide = LabelSamples::kWide;

// Binomial, by how far they reach: sums of them are exact halves.
constexpr float kSmoothing[kMostLabelSmoothing + 1][kMostLabelSmoothing + 1] = {
    {1}, {0.5f, 0.25f}, {0.375f, 0.25f, 0.0625f}, {0.3125f, 0.234375f, 0.09375f, 0.015625f}};

// The voxels along an axis that a sample takes, and their weights.
struct LabelTaps {
  int count = 0;
  std::array<int, 4> at{};
  std::array<float, 4> weight{};
};

// Counted from the first voxel that is read, `reach` before the one that the axis counts from.
LabelTaps labelTapsOf(const UnitAxis& axis, std::size_t sample, int reach, bool cubic) {
  LabelTaps out;
  if (cubic) {
    out.count = 4;
    for (std::size_t n = 0; n < 4; ++n)
      out.at[n] = axis.value.at[n][sample] + reach, out.weight[n] = axis.value.weight[n][sample];
    return out;
  }
  const float t = axis.fraction[sample];
  const int base = axis.base[sample] + reach;
  out.count = t == 0 ? 1 : 2;
  out.at = {base, base + 1};
  out.weight = {1 - t, t};
  return out;
}

// The place of a sample of which so much is shown, of that label the most. In whole steps, which a place keeps for
// every rank: which others there are changes no bit.
float placeFor(float shown, int rank) {
  constexpr float kSteps = 128;
  const float rise = std::clamp(0.5f + kLabelRise * (shown - 0.5f), 0.0f, 1.0f);
  const float solid = std::floor(rise * kSteps + 0.5f) / kSteps;
  return solid > 0 ? SampleTable::placeOf(rank, solid) : 0.0f;
}

class LabelUnit {
 public:
  LabelUnit(const BrickBlock& block, const UnitLattice& lattice, const UnitInput& unit, const SampleTable& table,
            LabelSamples& out)
      : block_(block),
        l_(lattice),
        u_(unit),
        table_(table),
        out_(out),
        reach_(lattice.label_smoothing),
        cubic_(lattice.interpolation == Interpolation::kCubic) {
    for (std::size_t a = 0; a < 3; ++a) {
      inner_[a] = lattice.voxels[a] + 2 * kUnitMargin;
      wide_[a] = inner_[a] + 2 * reach_;
    }
  }

  bool run(const VoxelCoord& lo) {
    withVoxelType(block_.type, [&]<class T>(std::type_identity<T>) { load<T>(lo); });
    if (one_ && first_ < 0) return false;
    if (one_)
      fill();
    else
      sample();
    return true;
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
    int rank = first_ = rankOf(last);
    one_ = true;
    for (std::size_t k = 0; k < static_cast<std::size_t>(wide_[2]); ++k) {
      for (std::size_t j = 0; j < static_cast<std::size_t>(wide_[1]); ++j) {
        const T* const row = voxels + at[1][j] + at[2][k];
        int* const to = out_.ranks + (k * kWide + j) * kWide;
        for (std::size_t i = 0; i < static_cast<std::size_t>(wide_[0]); ++i) {
          const T value = row[at[0][i]];
          if (value != last) last = value, rank = rankOf(value), one_ = one_ && rank == first_;
          to[i] = rank;
        }
      }
    }
  }

  template <class T>
  int rankOf(T value) const {
    return table_.rankOf(static_cast<float>(static_cast<double>(value) - table_.offset()));
  }

  template <class To>
  void forEachRow(const To& to) const {
    for (int k = u_.first[2]; k < u_.end[2]; ++k) {
      for (int j = u_.first[1]; j < u_.end[1]; ++j) to(j, k, out_.places + (k * kUnitSamples + j) * kUnitSamples);
    }
  }

  // One label and no surface near.
  void fill() {
    forEachRow([&](int, int, float* places) {
      std::fill(places + u_.first[0], places + u_.end[0], SampleTable::placeOf(first_, 1));
    });
    for (int row = 0; row < inner_[1] * inner_[2]; ++row)
      std::fill_n(out_.opacities + row * kUnitSamples, inner_[0], 0.0f);
  }

  void sample() {
    smooth();
    columns_ = {wide_[0], 0};
    for (int i = u_.first[0]; i < u_.end[0]; ++i) {
      const LabelTaps& taps = along_x_[static_cast<std::size_t>(i)] =
          labelTapsOf(*u_.axis[0], static_cast<std::size_t>(i), reach_, cubic_);
      for (std::size_t n = 0; n < static_cast<std::size_t>(taps.count); ++n)
        columns_ = {std::min(columns_.first, taps.at[n]), std::max(columns_.second, taps.at[n] + 1)};
    }
    forEachRow([&](int j, int k, float* places) {
      setRows(labelTapsOf(*u_.axis[1], static_cast<std::size_t>(j), reach_, cubic_),
              labelTapsOf(*u_.axis[2], static_cast<std::size_t>(k), reach_, cubic_));
      setPlaces(places);
    });
  }

  // Along one axis after the other, each of which then has fewer voxels.
  void smooth() {
    float *from = out_.smoothed[0], *to = out_.smoothed[1];
    for (int k = 0; k < wide_[2]; ++k) {
      for (int j = 0; j < wide_[1]; ++j) {
        const int row = (k * kWide + j) * kWide;
        for (int i = row; i < row + wide_[0]; ++i) from[i] = table_.opacityOf(out_.ranks[i]);
      }
    }
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

  void setRows(const LabelTaps& y, const LabelTaps& z) {
    rows_count_ = 0;
    for (std::size_t c = 0; c < static_cast<std::size_t>(z.count); ++c) {
      for (std::size_t b = 0; b < static_cast<std::size_t>(y.count); ++b, ++rows_count_) {
        rows_[rows_count_] = out_.ranks + (z.at[c] * kWide + y.at[b]) * kWide;
        weights_[rows_count_] = y.weight[b] * z.weight[c];
      }
    }
  }

  // The ranks of the voxels that the row of samples takes, each once, in order.
  void findRanks() {
    ranks_.clear();
    int last = rows_[0][columns_.first];
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
    std::array<int, kUnitSamples> best{};
    for (const int rank : ranks_) {
      if (rank < 0) continue;
      std::array<float, kWide> column{};
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
      places[i] = placeFor(shown[i], best[i]);
  }

  const BrickBlock& block_;
  const UnitLattice& l_;
  const UnitInput& u_;
  const SampleTable& table_;
  LabelSamples& out_;
  const int reach_;
  const bool cubic_;
  std::array<int, 3> inner_{}, wide_{};
  bool one_ = false;  // whether all voxels are one label, or none that is shown
  int first_ = -1;
  std::array<LabelTaps, kUnitSamples> along_x_;
  std::size_t rows_count_ = 0;  // of voxels that the row of samples in turn takes
  std::array<const int*, 16> rows_;
  std::array<float, 16> weights_;
  std::pair<int, int> columns_;  // that samples take, half-open
  std::vector<int> ranks_;
};

}  // namespace

bool sampleLabels(const BrickBlock& block, const UnitLattice& lattice, const UnitInput& unit, const VoxelCoord& lo,
                  const SampleTable& table, LabelSamples& out) {
  return LabelUnit(block, lattice, unit, table, out).run(lo);
}

}  // namespace kiln
