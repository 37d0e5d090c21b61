// Share of each pixel that an outline covers.
//
// Method. Each row of pixels has kLines lines, on which the outline's inside is a list of intervals in whole 256ths of
// a pixel. Coverage is a sum of whole numbers. Invariant: a pixel's coverage does not depend on which other pixels are
// computed, so that crops and tiles equal the whole picture to the bit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "annotate/outline.h"

namespace kiln {

class Coverage {
 public:
  explicit Coverage(const Outline& outline);

  /// The rows that the outline may touch, half-open. unit: pixels.
  int firstRow() const { return first_row_; }
  int endRow() const { return end_row_; }

  /// Adds the coverage of the pixels from `first_column` on of one row. unit: kFull is a whole pixel. thread: safe.
  void addRow(int row, int first_column, std::span<std::int32_t> sums) const;

  static constexpr int kLines = 16, kSteps = 256, kFull = kLines * kSteps;

 private:
  struct Edge {
    double top_x, top_y, bottom_x, bottom_y;  // top_y < bottom_y
    int winding;
  };
  std::vector<Edge> edges_;
  int first_row_ = 0, end_row_ = 0;
  std::vector<std::vector<std::uint32_t>> in_rows_;  // edges of each row from first_row_ on
};

}  // namespace kiln
