// Counts voxels by value in one pass, before anyone knows their range: exactly for 8 and 16 bits, else by the upper 16
// bits of the value's float (sign, exponent, 7 bits of mantissa), whose order is the order of the values. Bins of equal
// width over the range, which is what people look at, are cut from that at the end. Labels of wider types are counted
// exactly from 0 to 65534; what is no such label counts as 65535.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "grid/coords.h"
#include "grid/value_range.h"
#include "grid/voxel_type.h"
#include "store/manifest.h"

namespace kiln {

/// The counts of some voxels, without the keys that none has.
struct ValueCounts {
  std::vector<std::pair<std::uint32_t, std::uint64_t>> keys;
  std::uint64_t nan_count = 0;
};

/// Of a manifest's histogram, but for labels', which have a bin each.
inline constexpr std::size_t kHistogramBins = 256;

class ValueCounter {
 public:
  explicit ValueCounter(VoxelType type, bool labels = false);

  /// Counts the voxels of `region`. shape: `voxels` covers `box`, x fastest.
  void count(std::span<const std::byte> voxels, const VoxelBox& box, const VoxelBox& region);
  void add(const ValueCounts& counts);
  /// What was counted since the last call, which is then forgotten.
  ValueCounts take();

  std::uint64_t nanCount() const { return nan_count_; }
  /// Of `range`, the least and the greatest value counted, what people want to look at: all of it; but where a voxel in
  /// 100 000 at either end, or a single value far away from all others, makes it many times as wide, the rest. So what
  /// a file has where it knows nothing (-3.4e38, 65535) is left out, and so are infinities. Of labels all.
  ValueRange commonRange(const ValueRange& range) const;
  /// The counts in equal bins over `range`; voxels of a wide key are spread evenly over it, and those beyond the range
  /// are in the first and the last bin.
  ValueHistogram histogram(const ValueRange& range, std::size_t bins = kHistogramBins) const;

 private:
  VoxelType type_;
  bool labels_;
  std::vector<std::uint64_t> counts_;  // by key
  std::uint64_t nan_count_ = 0;
};

}  // namespace kiln
