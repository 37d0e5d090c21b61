#include "convert/stream/value_counter.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace kiln {
namespace {

constexpr std::size_t kKeys = kMostLabels;
// Upper bound for the bins of all blocks, unless there are more blocks: 32 for each bin of a histogram. unit: bins.
constexpr std::size_t kFineBins = 32 * kHistogramBins;
constexpr unsigned kLowerBits = 16;

template <class T>
constexpr bool kExact = sizeof(T) <= 2;

// The bits of negative floats are in reverse order: flips all bits. Sets the sign bit of positive floats.
std::uint32_t orderedBits(float value) {
  const std::uint32_t bits = std::bit_cast<std::uint32_t>(value);
  return (bits & 0x80000000u) != 0 ? ~bits : bits | 0x80000000u;
}

float fromOrderedBits(std::uint32_t ordered) {
  return std::bit_cast<float>((ordered & 0x80000000u) != 0 ? ordered & 0x7fffffffu : ~ordered);
}

// The width of the bins of so many blocks, as bits of the lower half of a float that tell bins apart.
unsigned fineBitsFor(std::size_t blocks) {
  unsigned bits = kLowerBits - 1;
  while (bits > 0 && blocks << bits > kFineBins) --bits;
  return bits;
}

std::uint32_t keyOf(std::uint32_t upper, std::uint32_t bin, unsigned fine_bits) {
  return upper << kLowerBits | bin << (kLowerBits - fine_bits) | 1u << (kLowerBits - 1 - fine_bits);
}
unsigned fineBitsOf(std::uint32_t key) {
  const std::uint32_t lower = key & 0xffffu;
  return lower == 0 ? 0 : kLowerBits - 1 - static_cast<unsigned>(std::countr_zero(lower));
}

template <class T>
std::size_t exactKeyOf(T value) {
  if constexpr (kExact<T>)
    return static_cast<std::size_t>(static_cast<int>(value) - static_cast<int>(std::numeric_limits<T>::min()));
  else
    return value >= 0 && value < static_cast<T>(kKeys - 1) ? static_cast<std::size_t>(value) : kKeys - 1;
}

// The values [lo, hi) of a bin of floats.
ValueRange valuesOf(std::uint32_t upper, std::uint32_t bin, unsigned fine_bits) {
  const std::uint32_t first = upper << kLowerBits | bin << (kLowerBits - fine_bits);
  const double lo = fromOrderedBits(first), hi = fromOrderedBits(first | ((1u << (kLowerBits - fine_bits)) - 1));
  // An infinity shares a bin with NaNs, but no NaN is counted.
  return {std::isnan(lo) ? hi : lo, std::isnan(hi) ? lo : hi};
}

// Keys in ascending order, with the values and voxels of each key.
struct CountedKeys {
  std::vector<ValueRange> values;
  std::vector<std::uint64_t> counts;

  double width(std::size_t first, std::size_t last) const { return values[last].hi - values[first].lo; }
};

// Returns the number of keys to leave out at an end: keys of a few voxels, then a key far from all remaining keys.
std::size_t strayKeys(const CountedKeys& keys, std::uint64_t few, bool at_end) {
  // Fewer keys than this are names of things rather than measurements.
  constexpr std::size_t kFewestKeys = 16;
  constexpr double kFar = 1e4;
  const std::size_t all = keys.counts.size();
  const auto at = [&](std::size_t i) { return at_end ? all - 1 - i : i; };
  std::size_t out = 0;
  std::uint64_t voxels = 0;
  while (out + kFewestKeys < all && voxels + keys.counts[at(out)] <= few) voxels += keys.counts[at(out++)];
  if (out + kFewestKeys >= all) return out;
  const std::size_t first = at_end ? 0 : out + 1, last = at_end ? all - 2 - out : all - 1;
  const double gap =
      at_end ? keys.values[last + 1].lo - keys.values[last].hi : keys.values[first].lo - keys.values[first - 1].hi;
  return gap > kFar * keys.width(first, last) ? out + 1 : out;
}

}  // namespace

void ValueCounter::FloatCounts::add(std::uint32_t ordered, std::uint64_t count) {
  const std::uint32_t upper = ordered >> kLowerBits;
  const std::uint32_t block = blocks[upper] != 0 ? blocks[upper] - 1 : newBlock(upper);
  counts[(std::size_t{block} << fine_bits) + ((ordered & 0xffffu) >> (kLowerBits - fine_bits))] += count;
}

std::uint32_t ValueCounter::FloatCounts::newBlock(std::uint32_t upper) {
  uppers.push_back(upper);
  blocks[upper] = static_cast<std::uint32_t>(uppers.size());
  coarsenTo(fineBitsFor(uppers.size()));
  counts.resize(uppers.size() << fine_bits);
  return blocks[upper] - 1;
}

void ValueCounter::FloatCounts::coarsenTo(unsigned bits) {
  if (bits >= fine_bits) return;
  const unsigned shift = fine_bits - bits;
  for (std::size_t i = 0; i < counts.size(); ++i) counts[i >> shift] += std::exchange(counts[i], 0);
  counts.resize(counts.size() >> shift);
  fine_bits = bits;
}

void ValueCounter::FloatCounts::clear() {
  for (const std::uint32_t upper : uppers) blocks[upper] = 0;
  uppers.clear();
  counts.clear();
  fine_bits = kMostFineBits;
}

ValueCounter::ValueCounter(VoxelType type, bool labels)
    : type_(type), labels_(labels), exact_(labels || sizeOf(type) <= 2) {
  if (exact_)
    counts_.resize(sizeOf(type) == 1 ? 256 : kKeys);
  else
    floats_.blocks.resize(kKeys);
}

void ValueCounter::count(std::span<const std::byte> voxels, const VoxelBox& box, const VoxelBox& region) {
  const Extent3 size = box.extent();
  withVoxelType(type_, [&]<class T>(std::type_identity<T>) {
    const T* const data = reinterpret_cast<const T*>(voxels.data());
    for (std::int64_t z = region.lo.z; z < region.hi.z; ++z) {
      for (std::int64_t y = region.lo.y; y < region.hi.y; ++y) {
        const T* row = data + ((z - box.lo.z) * size.y + (y - box.lo.y)) * size.x - box.lo.x;
        for (std::int64_t x = region.lo.x; x < region.hi.x; ++x) {
          if constexpr (std::is_floating_point_v<T>) {
            if (std::isnan(row[x])) {
              ++nan_count_;
              continue;
            }
          }
          if (kExact<T> || exact_)
            ++counts_[exactKeyOf(row[x])];
          else
            floats_.add(orderedBits(static_cast<float>(row[x])), 1);
        }
      }
    }
  });
}

void ValueCounter::add(const ValueCounts& counts) {
  for (const auto& [key, count] : counts.keys) {
    if (exact_) {
      counts_[key % counts_.size()] += count;
    } else {
      floats_.coarsenTo(fineBitsOf(key));
      floats_.add(key, count);
    }
  }
  nan_count_ += counts.nan_count;
}

ValueCounts ValueCounter::take() {
  ValueCounts out;
  for (std::size_t key = 0; key < counts_.size(); ++key) {
    if (counts_[key] > 0) out.keys.emplace_back(static_cast<std::uint32_t>(key), std::exchange(counts_[key], 0));
  }
  for (std::size_t i = 0; i < floats_.counts.size(); ++i) {
    const std::uint32_t upper = floats_.uppers[i >> floats_.fine_bits];
    const auto bin = static_cast<std::uint32_t>(i & ((std::size_t{1} << floats_.fine_bits) - 1));
    if (floats_.counts[i] > 0) out.keys.emplace_back(keyOf(upper, bin, floats_.fine_bits), floats_.counts[i]);
  }
  floats_.clear();
  out.nan_count = std::exchange(nan_count_, 0);
  return out;
}

template <class Each>
void ValueCounter::forEachKey(const Each& each) const {
  withVoxelType(type_, [&]<class T>(std::type_identity<T>) {
    const double least = kExact<T> ? static_cast<double>(std::numeric_limits<T>::min()) : 0;
    for (std::size_t key = 0; key < counts_.size(); ++key) {
      const double value = static_cast<double>(key) + least;
      if (counts_[key] > 0) each(ValueRange{value, value}, counts_[key]);
    }
  });
  const unsigned bits = floats_.fine_bits;
  for (std::size_t upper = 0; upper < floats_.blocks.size(); ++upper) {
    if (floats_.blocks[upper] == 0) continue;
    const std::size_t first = std::size_t{floats_.blocks[upper] - 1} << bits;
    for (std::uint32_t bin = 0; bin < 1u << bits; ++bin) {
      const std::uint64_t count = floats_.counts[first + bin];
      if (count > 0) each(valuesOf(static_cast<std::uint32_t>(upper), bin, bits), count);
    }
  }
}

ValueRange ValueCounter::commonRange(const ValueRange& range) const {
  constexpr std::uint64_t kFewIn = 100'000;
  constexpr double kManyTimes = 64;
  if (labels_ || range.empty()) return range;
  CountedKeys keys;
  std::uint64_t voxels = 0;
  forEachKey([&](const ValueRange& values, std::uint64_t count) {
    if (!std::isfinite(values.lo) || !std::isfinite(values.hi)) return;
    keys.values.push_back(values);
    keys.counts.push_back(count);
    voxels += count;
  });
  const std::uint64_t few = std::max<std::uint64_t>(voxels / kFewIn, 1);
  const std::size_t below = strayKeys(keys, few, false), above = strayKeys(keys, few, true);
  if (below + above + 1 >= keys.counts.size()) return range;
  const ValueRange out{std::max(range.lo, keys.values[below].lo),
                       std::min(range.hi, keys.values[keys.values.size() - 1 - above].hi)};
  return out.hi > out.lo && kManyTimes * (out.hi - out.lo) < range.hi - range.lo ? out : range;
}

ValueHistogram ValueCounter::histogram(const ValueRange& range, std::size_t bins) const {
  ValueHistogram out;
  out.counts.assign(bins, 0);
  if (range.empty()) return out;
  // Infinite values are legal voxels; the bins cover finite values.
  const double largest = std::numeric_limits<float>::max();
  out.lo = std::clamp(range.lo, -largest, largest);
  out.hi = std::clamp(range.hi, -largest, largest);
  const double width = (out.hi - out.lo) / static_cast<double>(bins);
  const auto binOf = [&](double value) {
    if (!(width > 0)) return std::size_t{0};
    const double bin = (value - out.lo) / width;
    return static_cast<std::size_t>(std::clamp(bin, 0.0, static_cast<double>(bins - 1)));
  };
  forEachKey([&](const ValueRange& values, std::uint64_t count) {
    const std::size_t first = binOf(values.lo);
    const std::size_t last = binOf(values.hi);
    const std::uint64_t share = count / (last - first + 1);
    for (std::size_t bin = first; bin <= last; ++bin) out.counts[bin] += share;
    out.counts[first] += count - share * (last - first + 1);
  });
  return out;
}

ValueHistogram histogramOf(const Manifest& manifest, const ValueCounter& counter, const ValueRange& range) {
  if (!countsEachLabel(manifest.volume_class, manifest.type, range))
    return counter.histogram(counter.commonRange(range));
  return counter.histogram({range.lo - 0.5, range.hi + 0.5}, static_cast<std::size_t>(range.hi - range.lo) + 1);
}

}  // namespace kiln
