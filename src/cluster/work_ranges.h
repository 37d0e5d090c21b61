// Work that ranks share without a master: a row of units, of which each rank has a range, so that units that belong
// together are drawn by one rank; who has finished its own takes from the other end of the range with most left. A
// range is one shared number: how many units went from its front in the lower half, from its back in the upper half, so
// that one addition hands out one unit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "cluster/ranks.h"

namespace kiln {

class WorkRanges {
 public:
  /// The units of the i-th rank are [bounds[i], bounds[i + 1]); its number is the counter `first_counter` + i.
  /// requires: `counters` outlives this; less than 2³¹ units.
  WorkRanges(SharedCounters& counters, std::size_t first_counter, std::vector<std::uint32_t> bounds, int rank)
      : counters_(counters), first_(first_counter), bounds_(std::move(bounds)), rank_(static_cast<std::size_t>(rank)) {}

  /// The next unit for this rank: each unit is handed out once. Nothing once all are.
  std::optional<std::uint32_t> take() {
    if (const auto own = takeFrom(rank_, false)) return own;
    while (const auto victim = fullest()) {
      if (const auto stolen = takeFrom(*victim, true)) return stolen;
    }
    return std::nullopt;
  }

  /// Nobody takes any unit from here on.
  void drop() {
    for (std::size_t range = 0; range + 1 < bounds_.size(); ++range) counters_.add(first_ + range, size(range));
  }

 private:
  static constexpr std::uint64_t kFromBack = std::uint64_t{1} << 32;
  std::uint64_t size(std::size_t range) const { return bounds_[range + 1] - bounds_[range]; }
  static std::uint64_t taken(std::uint64_t counter) { return counter / kFromBack + counter % kFromBack; }

  std::optional<std::uint32_t> takeFrom(std::size_t range, bool back) {
    const std::uint64_t before = counters_.add(first_ + range, back ? kFromBack : 1);
    if (taken(before) >= size(range)) return std::nullopt;
    return back ? bounds_[range + 1] - 1 - static_cast<std::uint32_t>(before / kFromBack)
                : bounds_[range] + static_cast<std::uint32_t>(before % kFromBack);
  }

  std::optional<std::size_t> fullest() {
    std::optional<std::size_t> out;
    std::uint64_t most = 0;
    for (std::size_t range = 0; range + 1 < bounds_.size(); ++range) {
      const std::uint64_t gone = taken(counters_.add(first_ + range, 0));
      if (gone >= size(range) || size(range) - gone <= most) continue;
      most = size(range) - gone;
      out = range;
    }
    return out;
  }

  SharedCounters& counters_;
  const std::size_t first_;
  const std::vector<std::uint32_t> bounds_;
  const std::size_t rank_;
};

}  // namespace kiln
