// Transposes between OpenVDB's leaves (z fastest) and blocks of voxels (x fastest). Internal, not installed.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <iterator>

#include "store/codec/brick_file.h"

namespace kiln {

template <class T>
struct LeafRow {
  using type [[gnu::vector_size(kLeaf * sizeof(T))]] = T;
};

// Transposes 8×8 values; strides between rows in values. Three stages, each of which interleaves the first four rows
// with the last four.
template <class T>
void transposeSquare(const T* from, std::int64_t from_stride, T* to, std::int64_t to_stride) {
  static_assert(kLeaf == 8);
  using Row = typename LeafRow<T>::type;
  Row rows[kLeaf], turned[kLeaf];
  for (std::int64_t i = 0; i < kLeaf; ++i) std::memcpy(&rows[i], from + i * from_stride, sizeof(Row));
  for (int stage = 0; stage < 3; ++stage) {
    for (int i = 0; i < kLeaf / 2; ++i) {
      const Row first = rows[i], last = rows[i + kLeaf / 2];
      turned[2 * i] = __builtin_shufflevector(first, last, 0, 8, 1, 9, 2, 10, 3, 11);
      turned[2 * i + 1] = __builtin_shufflevector(first, last, 4, 12, 5, 13, 6, 14, 7, 15);
    }
    std::copy(std::begin(turned), std::end(turned), std::begin(rows));
  }
  for (std::int64_t i = 0; i < kLeaf; ++i) std::memcpy(to + i * to_stride, &rows[i], sizeof(Row));
}

}  // namespace kiln
