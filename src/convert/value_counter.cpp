#include "convert/value_counter.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace kiln {
namespace {

constexpr std::size_t kKeys = kMostLabels;

template <class T>
constexpr bool kExact = sizeof(T) <= 2;

// Negative floats order backwards by their bits: flip them all, and set the sign of the others.
std::uint32_t orderedBits(float value) {
  const std::uint32_t bits = std::bit_cast<std::uint32_t>(value);
  return (bits & 0x80000000u) != 0 ? ~bits : bits | 0x80000000u;
}

float fromOrderedBits(std::uint32_t ordered) {
  return std::bit_cast<float>((ordered & 0x80000000u) != 0 ? ordered & 0x7fffffffu : ~ordered);
}

template <class T>
std::size_t keyOf(T value, bool labels) {
  if constexpr (kExact<T>) {
    return static_cast<std::size_t>(static_cast<int>(value) - static_cast<int>(std::numeric_limits<T>::min()));
  } else {
    if (!labels) return orderedBits(static_cast<float>(value)) >> 16;
    return value >= 0 && value < static_cast<T>(kKeys - 1) ? static_cast<std::size_t>(value) : kKeys - 1;
  }
}

// The values [lo, hi) that share a key.
template <class T>
ValueRange valuesOf(std::size_t key, bool labels) {
  if constexpr (kExact<T>) {
    const double value = static_cast<double>(key) + static_cast<double>(std::numeric_limits<T>::min());
    return {value, value};
  } else {
    if (labels) return {static_cast<double>(key), static_cast<double>(key)};
    const double lo = fromOrderedBits(static_cast<std::uint32_t>(key) << 16);
    const double hi = fromOrderedBits((static_cast<std::uint32_t>(key) << 16) | 0xffffu);
    // An infinity shares its key with NaNs, which are not counted.
    return {std::isnan(lo) ? hi : lo, std::isnan(hi) ? lo : hi};
  }
}

// Values that were counted, from the least on, and how many there are of each key.
struct CountedKeys {
  std::vector<ValueRange> values;
  std::vector<std::uint64_t> counts;

  double width(std::size_t first, std::size_t last) const { return values[last].hi - values[first].lo; }
};

// How many keys at one end are left out: those of a few voxels, and one that is far from what is left.
std::size_t strayKeys(const CountedKeys& keys, std::uint64_t few, bool at_end) {
  // Fewer keys are names of things rather than measurements.
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

ValueCounter::ValueCounter(VoxelType type, bool labels) : type_(type), labels_(labels), counts_(kKeys) {}

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
          ++counts_[keyOf(row[x], labels_)];
        }
      }
    }
  });
}

void ValueCounter::add(const ValueCounts& counts) {
  for (const auto& [key, count] : counts.keys) counts_[key % kKeys] += count;
  nan_count_ += counts.nan_count;
}

ValueCounts ValueCounter::take() {
  ValueCounts out;
  for (std::size_t key = 0; key < kKeys; ++key) {
    if (counts_[key] > 0) out.keys.emplace_back(static_cast<std::uint32_t>(key), std::exchange(counts_[key], 0));
  }
  out.nan_count = std::exchange(nan_count_, 0);
  return out;
}

ValueRange ValueCounter::commonRange(const ValueRange& range) const {
  constexpr std::uint64_t kFewIn = 100'000;
  constexpr double kManyTimes = 64;
  if (labels_ || range.empty()) return range;
  CountedKeys keys;
  std::uint64_t voxels = 0;
  withVoxelType(type_, [&]<class T>(std::type_identity<T>) {
    for (std::size_t key = 0; key < kKeys; ++key) {
      if (counts_[key] == 0) continue;
      const ValueRange values = valuesOf<T>(key, labels_);
      if (!std::isfinite(values.lo) || !std::isfinite(values.hi)) continue;
      keys.values.push_back(values);
      keys.counts.push_back(counts_[key]);
      voxels += counts_[key];
    }
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
  // Infinite values are legal voxels; the bins cover what is finite.
  const double largest = std::numeric_limits<float>::max();
  out.lo = std::clamp(range.lo, -largest, largest);
  out.hi = std::clamp(range.hi, -largest, largest);
  const double width = (out.hi - out.lo) / static_cast<double>(bins);
  const auto binOf = [&](double value) {
    if (!(width > 0)) return std::size_t{0};
    const double bin = (value - out.lo) / width;
    return static_cast<std::size_t>(std::clamp(bin, 0.0, static_cast<double>(bins - 1)));
  };
  withVoxelType(type_, [&]<class T>(std::type_identity<T>) {
    for (std::size_t key = 0; key < kKeys; ++key) {
      if (counts_[key] == 0) continue;
      const ValueRange values = valuesOf<T>(key, labels_);
      const std::size_t first = binOf(values.lo);
      const std::size_t last = binOf(values.hi);
      const std::uint64_t share = counts_[key] / (last - first + 1);
      for (std::size_t bin = first; bin <= last; ++bin) out.counts[bin] += share;
      out.counts[first] += counts_[key] - share * (last - first + 1);
    }
  });
  return out;
}

}  // namespace kiln
