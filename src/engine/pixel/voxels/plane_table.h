// Factors of opacity, and colours, on a grid over values and gradient lengths, for kernels.
// Method. A function of gradients alone has one column, a table of the user's own nodes, and regions a fixed number of
// nodes. Colours of nodes are the regions' colours times their weight, and the weight of the value's own colour.
#pragma once

#include <glm/vec2.hpp>
#include <vector>

#include "scene/transfer/transfer_function.h"

namespace kiln {

class PlaneTable {
 public:
  /// Leaves opacities unchanged.
  PlaneTable() = default;
  /// requires: neither labels nor surfaces.
  explicit PlaneTable(const TransferFunction& function);

  bool any() const { return columns_ > 0; }
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  /// Nodes from a row to the next: a row and a column are repeated behind the last.
  int stride() const { return columns_ + 1; }
  double firstValue() const { return first_.x; }
  double firstGradient() const { return first_.y; }
  double columnsPerValue() const { return per_.x; }
  double rowsPerGradient() const { return per_.y; }
  /// shape: stride() × (rows() + 1).
  const float* factors() const { return factors_.data(); }
  /// shape: as factors, with r, g, b and the weight of the value's colour a node. Null: colours do not depend on
  /// gradients.
  const float* colors() const { return colors_.empty() ? nullptr : colors_.data(); }
  /// Returns false if no gradient shows a value in [lo, hi].
  bool shows(double lo, double hi) const;

 private:
  int columns_ = 0, rows_ = 0;
  glm::dvec2 first_{0}, per_{0};
  std::vector<float> factors_, colors_;
  std::vector<int> shown_before_;  // prefix sums: columns with a factor above zero
};

}  // namespace kiln
