#include "store/codec/shown_voxels.h"

#include <algorithm>

namespace kiln {
namespace {

// Calls each(word, bits) for the words that hold `count` bits from `offset` on, with the mask of these bits; stops if
// the result is true, and returns whether it was.
template <class Each>
bool anyWordOf(std::int64_t offset, std::int64_t count, const Each& each) {
  for (std::int64_t at = offset; at < offset + count;) {
    const std::int64_t first = at & 63, bits = std::min(64 - first, offset + count - at);
    const std::uint64_t mask = (bits == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << bits) - 1) << first;
    if (each(static_cast<std::size_t>(at >> 6), mask)) return true;
    at += bits;
  }
  return false;
}

}  // namespace

void ShownVoxels::show(std::int64_t offset, std::int64_t count) {
  anyWordOf(offset, count, [&](std::size_t word, std::uint64_t mask) {
    words_[word] |= mask;
    return false;
  });
}

// Returns whether the test holds for the words of some row of the part.
template <class Test>
bool ShownVoxels::anyWord(const VoxelBox& part, const Test& test) const {
  const std::int64_t count = part.hi.x - part.lo.x;
  if (part.empty()) return false;
  for (std::int64_t z = part.lo.z; z < part.hi.z; ++z) {
    for (std::int64_t y = part.lo.y; y < part.hi.y; ++y) {
      if (anyWordOf(offsetOf({part.lo.x, y, z}), count, test)) return true;
    }
  }
  return false;
}

bool ShownVoxels::any(const VoxelBox& part) const {
  return all() || anyWord(part, [&](std::size_t word, std::uint64_t mask) { return (words_[word] & mask) != 0; });
}

bool ShownVoxels::every(const VoxelBox& part) const {
  return all() || !anyWord(part, [&](std::size_t word, std::uint64_t mask) { return (~words_[word] & mask) != 0; });
}

}  // namespace kiln
