#include "engine/voxel/gather_voxels.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <optional>
#include <type_traits>
#include <utility>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/voxel/gather_voxels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "engine/voxel/voxel_batch-inl.h"

#ifndef KILN_GATHER_VOXELS_ORDERS
#define KILN_GATHER_VOXELS_ORDERS
namespace kiln {
namespace {

// Look-up table that orders the visible voxels of a row. Indices: the frontmost voxel of the row, and a mask of visible
// voxels. From the frontmost voxel, lower positions come first in descending order, then higher positions in ascending
// order.
struct RowOrders {
  alignas(16) std::int32_t voxels[kSplatCellSize][1 << kSplatCellSize][kSplatCellSize];  // padded with zeros
};
constexpr RowOrders kRowOrders = [] {
  RowOrders out{};
  for (unsigned shown = 0; shown < 1 << kSplatCellSize; ++shown) {
    for (int first = 0; first < kSplatCellSize; ++first) {
      std::int32_t* to = out.voxels[first][shown];
      const auto find = [&](int x) {
        if ((shown >> x & 1) != 0) *to++ = x;
      };
      for (int x = first; x >= 0; --x) find(x);
      for (int x = first + 1; x < kSplatCellSize; ++x) find(x);
    }
  }
  return out;
}();

}  // namespace
}  // namespace kiln
#endif

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

constexpr std::size_t kRow = kSplatCellSize;
using DR = hn::CappedTag<std::int32_t, kRow>;
using DRF = hn::RebindToFloat<DR>;
// True if a row fits one vector: integers of up to 16 bits, on an instruction set with vectors of four.
template <class T>
constexpr bool kIsVector = sizeof(T) <= 2 && hn::MaxLanes(DR()) == kRow;

template <class T>
HWY_INLINE hn::Vec<DR> loadRow(const T* at) {
  const DR d;
  return hn::PromoteTo(d, hn::LoadU(hn::Rebind<T, DR>(), at));
}

// Returns a mask of the visible voxels in a row.
template <class T>
class RowTest {
 public:
  RowTest(const Classifier& classifier, int voxels)
      : shows_(classifier.shows<T>()), interval_(classifier.shownInterval()), voxels_(voxels) {}

  HWY_INLINE unsigned operator()(const T* row) const {
    if constexpr (kIsVector<T>) {
      if (voxels_ == kSplatCellSize && interval_) {
        const DR d;
        const auto v = loadRow(row);
        const auto beside = hn::Or(hn::Lt(v, hn::Set(d, interval_->lo)), hn::Gt(v, hn::Set(d, interval_->hi)));
        return bitsOf(d, beside) ^ ((1u << kSplatCellSize) - 1);
      }
    }
    unsigned bits = 0;
    for (int x = 0; x < voxels_; ++x) bits |= static_cast<unsigned>(shows_(row[x])) << x;
    return bits;
  }

 private:
  const decltype(std::declval<Classifier>().shows<T>()) shows_;
  const std::optional<Classifier::Interval> interval_;
  const int voxels_;
};

template <class T>
void findIn(const Classifier& classifier, const VisitingOrder& visiting, const BrickBlock& block, const VoxelBox& cell,
            FoundVoxels& out) {
  std::uint8_t order[3][kSplatCellSize];
  int count[3] = {};
  for (int axis = 0; axis < 3; ++axis) {
    count[axis] = std::min(static_cast<int>(cell.hi[axis] - cell.lo[axis]), kSplatCellSize);
    visiting.axisOrder(axis, cell.lo[axis], count[axis], order[axis]);
  }
  const RowTest<T> shownOf(classifier, count[0]);
  const auto& orders = kRowOrders.voxels[order[0][0]];
  const T* const voxels = block.data<T>();
  const std::ptrdiff_t cell_offset = block.offsetOf(cell.lo), stride_y = block.strideY(), stride_z = block.strideZ();
  FoundVoxels::Row* row = out.rows;
  int found = 0;
  for (int k = 0; k < count[2]; ++k) {
    for (int j = 0; j < count[1]; ++j) {
      const int y = order[1][j], z = order[2][k];
      const std::ptrdiff_t offset = cell_offset + y * stride_y + z * stride_z;
      const unsigned shown = shownOf(voxels + offset);
      if (shown == 0) continue;
      *row = {offset, orders[shown], found, std::popcount(shown)};
      for (int i = 0; i < kSplatCellSize; ++i) out.codes[found + i] = voxelCode(0, y, z) + row->order[i];
      found += row->count;
      ++row;
    }
  }
  out.row_count = static_cast<int>(row - out.rows);
  out.count = found;
}

void findVoxelsOn(const Classifier& classifier, const VisitingOrder& order, const BrickBlock& block,
                  const VoxelBox& cell, FoundVoxels& out) {
  withVoxelType(block.type, [&]<class T>(std::type_identity<T>) { findIn<T>(classifier, order, block, cell, out); });
}

// Gathers the voxels of one batch, row by row. The first and the last row may extend into neighbouring batches, so
// scratch arrays have room for a row before and after the batch.
template <class T>
class BatchTaker {
  static constexpr std::ptrdiff_t kBefore = 16;  // offset of the first number in a scratch array; a multiple of 16
                                                 // keeps the number aligned

 public:
  BatchTaker(const Classifier& classifier, const BrickBlock& block, const FoundVoxels& found, int first,
             std::uint32_t drawn, ShadedVoxels& out)
      : classifier_(classifier),
        voxels_(block.data<T>()),
        strides_{1, block.strideY(), block.strideZ()},
        found_(found),
        first_(first),
        drawn_(drawn),
        out_(out) {}

  void materials() {
    forEachRow([&](const FoundVoxels::Row& row, std::ptrdiff_t n, unsigned drawn) {
      forEachBit(drawn, [&](std::size_t i) {
        const Material material = classifier_.at(voxels_[row.offset + row.order[i]]);
        std::memcpy(out_.material + 4 * (n + static_cast<std::ptrdiff_t>(i)), &material, sizeof material);
      });
    });
  }

  void slopes() {
    if (classifier_.ofLabels()) {
      const auto opacity = [&](T label) { return classifier_.opacityOf(static_cast<double>(label)); };
      slopesOf([&](T hi, T lo) { return 0.5f * (opacity(hi) - opacity(lo)); });
    } else if constexpr (kIsVector<T>) {
      slopesOfRows();
    } else if constexpr (sizeof(T) <= 2) {
      slopesOf([](T hi, T lo) { return 0.5f * static_cast<float>(static_cast<int>(hi) - static_cast<int>(lo)); });
    } else if constexpr (std::is_same_v<T, float>) {
      slopesOf([](T hi, T lo) { return 0.5f * (hi - lo); });
    } else {
      slopesOf(
          [](T hi, T lo) { return static_cast<float>(0.5 * (static_cast<double>(hi) - static_cast<double>(lo))); });
    }
  }

 private:
  // Calls f(row, position of the row's first voxel in the batch, mask of the row's drawn voxels).
  template <class F>
  HWY_INLINE void forEachRow(F f) const {
    for (int r = 0; r < found_.row_count; ++r) {
      const FoundVoxels::Row& row = found_.rows[r];
      const int n = row.begin - first_;
      if (n <= -kSplatCellSize) continue;
      if (n >= kVoxelBatch) return;
      const unsigned drawn = (drawn_ << kSplatCellSize) >> (n + kSplatCellSize) & ((1u << row.count) - 1);
      if (drawn != 0) f(row, n, drawn);
    }
  }

  template <class F>
  void slopesOf(F of) {
    forEachRow([&](const FoundVoxels::Row& row, std::ptrdiff_t n, unsigned drawn) {
      forEachBit(drawn, [&](std::size_t i) {
        const T* const at = voxels_ + row.offset + row.order[i];
        const std::ptrdiff_t place = n + static_cast<std::ptrdiff_t>(i);
        for (int axis = 0; axis < 3; ++axis) out_.slope[axis][place] = of(at[strides_[axis]], at[-strides_[axis]]);
      });
    });
  }

  // Computes the gradients of a whole row at once, in the order of its voxels. If the brick ends inside the cell, the
  // row continues in the apron. Reads beyond the row are safe: another apron row follows.
  void slopesOfRows() {
    const DR d;
    const DRF df;
    alignas(64) float slopes[3][kBefore + kVoxelBatch + kBefore];
    const auto half = hn::Set(df, 0.5f);
    forEachRow([&](const FoundVoxels::Row& row, std::ptrdiff_t n, unsigned) {
      const auto order = hn::IndicesFromVec(df, hn::Load(d, row.order));
      const T* const at = voxels_ + row.offset;
      for (int axis = 0; axis < 3; ++axis) {
        const auto difference = hn::Sub(loadRow(at + strides_[axis]), loadRow(at - strides_[axis]));
        const auto slope = hn::Mul(hn::ConvertTo(df, difference), half);
        hn::StoreU(hn::TableLookupLanes(slope, order), df, slopes[axis] + kBefore + n);
      }
    });
    for (int axis = 0; axis < 3; ++axis) std::memcpy(out_.slope[axis], slopes[axis] + kBefore, sizeof out_.slope[axis]);
  }

  const Classifier& classifier_;
  const T* const voxels_;
  const std::ptrdiff_t strides_[3];
  const FoundVoxels& found_;
  const int first_;
  const std::uint32_t drawn_;
  ShadedVoxels& out_;
};

void takeVoxelsOn(const Classifier& classifier, const BrickBlock& block, const FoundVoxels& found, int first,
                  std::uint32_t drawn, bool with_slopes, ShadedVoxels& out) {
  withVoxelType(block.type, [&]<class T>(std::type_identity<T>) {
    BatchTaker<T> taker(classifier, block, found, first, drawn, out);
    taker.materials();
    if (with_slopes) taker.slopes();
  });
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kiln {

HWY_EXPORT(findVoxelsOn);
HWY_EXPORT(takeVoxelsOn);

void findVoxels(const Classifier& classifier, const VisitingOrder& order, const BrickBlock& block, const VoxelBox& cell,
                FoundVoxels& out) noexcept {
  HWY_DYNAMIC_DISPATCH(findVoxelsOn)(classifier, order, block, cell, out);
}

void takeVoxels(const Classifier& classifier, const BrickBlock& block, const FoundVoxels& found, int first,
                std::uint32_t drawn, bool with_slopes, ShadedVoxels& out) noexcept {
  HWY_DYNAMIC_DISPATCH(takeVoxelsOn)(classifier, block, found, first, drawn, with_slopes, out);
}

}  // namespace kiln
#endif
