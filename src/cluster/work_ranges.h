// Distributes work among ranks without a master.
// Method. The units of work form a sequence, and each rank starts with a contiguous range, so related units go to a
// single rank. A rank without work steals from the back of the range with most units left. A range is a shared counter:
// units taken from the front in the lower 32 bits, from the back in the upper 32 bits. An atomic addition therefore
// hands out units.
// Invariant. Every unit is handed out once.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "cluster/ranks.h"

namespace kiln {

class WorkRanges {
 public:
  struct Units {
    std::uint32_t begin, end;
  };

  /// The bounds of ranges of equal length (up to one unit).
  static std::vector<std::uint32_t> evenBounds(std::size_t units, std::size_t ranges) {
    std::vector<std::uint32_t> out;
    for (std::size_t i = 0; i <= ranges; ++i) out.push_back(static_cast<std::uint32_t>(i * units / ranges));
    return out;
  }

  /// Range i holds the units [bounds[i], bounds[i + 1]) and uses the counter `first_counter` + i.
  /// `own` is the range of this rank. The last `spared` units of a foreign range are left to the owner. requires:
  /// `counters` outlives this object; less than 2³¹ units.
  WorkRanges(SharedCounters& counters, std::size_t first_counter, std::vector<std::uint32_t> bounds, std::size_t own,
             std::uint32_t spared = 0)
      : counters_(counters),
        first_(first_counter),
        bounds_(std::move(bounds)),
        spared_(spared),
        range_(own),
        own_(own) {}

  /// Takes up to `most` units for this rank; returns nothing when no units are left.
  std::optional<Units> take(std::uint32_t most) {
    while (true) {
      if (const auto units = range_ == own_ || left(range_) > spared_ ? takeFrom(range_, most) : std::nullopt)
        return units;
      const auto next = fullest();
      if (!next) return std::nullopt;
      range_ = *next;
    }
  }

  /// Number of units handed out to all ranks together. cost: one access to each counter.
  std::uint64_t handedOut() {
    std::uint64_t out = 0;
    for (std::size_t range = 0; range + 1 < bounds_.size(); ++range) out += size(range) - left(range);
    return out;
  }

  /// Marks all units as handed out, so no rank takes more.
  void drop() {
    for (std::size_t range = 0; range + 1 < bounds_.size(); ++range) counters_.add(first_ + range, size(range));
  }

 private:
  static constexpr std::uint64_t kFromBack = std::uint64_t{1} << 32;
  std::uint32_t size(std::size_t range) const { return bounds_[range + 1] - bounds_[range]; }
  std::uint64_t left(std::size_t range) {
    const std::uint64_t gone = taken(counters_.add(first_ + range, 0));
    return gone < size(range) ? size(range) - gone : 0;
  }
  static std::uint64_t taken(std::uint64_t counter) { return counter / kFromBack + counter % kFromBack; }

  std::optional<Units> takeFrom(std::size_t range, std::uint32_t most) {
    const bool back = range != own_;
    const std::uint64_t before = counters_.add(first_ + range, back ? kFromBack * most : most);
    if (taken(before) >= size(range)) return std::nullopt;
    const auto count = static_cast<std::uint32_t>(std::min<std::uint64_t>(most, size(range) - taken(before)));
    const auto gone = static_cast<std::uint32_t>(back ? before / kFromBack : before % kFromBack);
    const std::uint32_t begin = back ? bounds_[range + 1] - gone - count : bounds_[range] + gone;
    return Units{begin, begin + count};
  }

  std::optional<std::size_t> fullest() {
    std::optional<std::size_t> out;
    std::uint64_t most = spared_;
    for (std::size_t range = 0; range + 1 < bounds_.size(); ++range) {
      const std::uint64_t there = left(range);
      if (there <= most) continue;
      most = there;
      out = range;
    }
    return out;
  }

  SharedCounters& counters_;
  const std::size_t first_;
  const std::vector<std::uint32_t> bounds_;
  const std::uint32_t spared_;
  std::size_t range_;  // the range in use
  const std::size_t own_;
};

}  // namespace kiln
