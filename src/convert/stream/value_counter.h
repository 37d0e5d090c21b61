// Counts voxels by value in a single pass, before the range is known: exactly for 8 and 16 bits, else by the value's
// float in bins made for the values found. Bins of equal width over the range, for histograms, are cut from the counts
// at the end. Labels of wider types are counted exactly from 0 to 65534; any larger label counts as 65535.
//
// Method, floats: floats are ordered as the integers of equal bits, with all bits of negative floats flipped. The upper
// 16 bits (sign, exponent, 7 bits of mantissa) choose a block, and each block is cut into equal bins, 8192 in all
// blocks together. Values of many magnitudes have a bin a block, 1/128 of the value wide. Values with a large offset
// and small differences (a pressure of 101325 Pa, give or take 20) lie in few blocks: the bins are up to 8192 times
// finer. Invariant: the width depends on the set of occupied blocks, not on the order of counting: ranks, lanes and
// resumed conversions find equal histograms.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "grid/coords.h"
#include "grid/value_range.h"
#include "grid/voxel_type.h"
#include "store/manifest/manifest.h"

namespace kiln {

/// Counts of some voxels; keys without voxels are omitted. A key of floats is the upper bits of the ordered float, then
/// a set bit, then zeros: the position of the last set bit gives the width of the bin.
struct ValueCounts {
  std::vector<std::pair<std::uint32_t, std::uint64_t>> keys;
  std::uint64_t nan_count = 0;
};

/// Bins of a manifest's histogram; histograms of labels have a bin for each label.
inline constexpr std::size_t kHistogramBins = 256;

class ValueCounter {
 public:
  explicit ValueCounter(VoxelType type, bool labels = false);

  /// Counts the voxels of `region`. shape: `voxels` covers `box`, x fastest.
  void count(std::span<const std::byte> voxels, const VoxelBox& box, const VoxelBox& region);
  void add(const ValueCounts& counts);
  /// Returns the counts since the last call, and clears the counter.
  ValueCounts take();

  std::uint64_t nanCount() const { return nan_count_; }
  /// Returns the part of `range`, the range of all counted values, that is worth showing. Outliers are left out if they
  /// widen the range many times: up to one voxel in 100 000 at either end, and a single value far from the rest.
  /// Examples are fill values (-3.4e38, 65535) and infinities. For labels, returns `range`.
  ValueRange commonRange(const ValueRange& range) const;
  /// Returns the counts in equal bins over `range`. Voxels of a wide key are spread evenly over the key's values;
  /// voxels beyond the range are in the first or the last bin.
  ValueHistogram histogram(const ValueRange& range, std::size_t bins = kHistogramBins) const;

 private:
  /// Calls each(values, count) for every key with voxels, in ascending order.
  template <class Each>
  void forEachKey(const Each& each) const;

  // Counts of floats: each block of 2^16 ordered floats has 2^fine_bits bins.
  struct FloatCounts {
    static constexpr unsigned kMostFineBits = 15;

    std::vector<std::uint32_t> blocks;  // by the upper 16 bits: 1 + the block's place, or 0
    std::vector<std::uint32_t> uppers;  // a block's upper 16 bits
    std::vector<std::uint64_t> counts;  // by block and lower bits
    unsigned fine_bits = kMostFineBits;

    void add(std::uint32_t ordered, std::uint64_t count);
    void coarsenTo(unsigned bits);
    std::uint32_t newBlock(std::uint32_t upper);
    /// Keeps the memory. cost: that of the occupied blocks.
    void clear();
  };

  VoxelType type_;
  bool labels_;
  bool exact_;                         // a key is a value
  std::vector<std::uint64_t> counts_;  // by key, if exact_
  FloatCounts floats_;                 // if not exact_
  std::uint64_t nan_count_ = 0;
};

/// Returns the histogram of a manifest: a bin for each label, if the labels are few enough, else the common range in
/// equal bins. requires: `range` is the range of all counted values.
ValueHistogram histogramOf(const Manifest& manifest, const ValueCounter& counter, const ValueRange& range);

}  // namespace kiln
