#include "engine/pixel/voxels/wide_opacities.h"

#include <algorithm>
#include <array>
#include <utility>

namespace kiln {
namespace {

constexpr int kRow = WideOpacities::kWide;

// Binomial weights, by reach; sums of the weights are exact in floats.
constexpr float kSmoothing[kMostLabelSmoothing + 1][kMostLabelSmoothing + 1] = {
    {1}, {0.5f, 0.25f}, {0.375f, 0.25f, 0.0625f}, {0.3125f, 0.234375f, 0.09375f, 0.015625f}};

void smoothRow(const float* from, float* to, int reach, int row, int count, int stride) {
  const float* const weights = kSmoothing[reach];
  for (int i = row; i < row + count; ++i) {
    const float* const middle = from + i + reach * stride;
    float sum = weights[0] * middle[0];
    for (int n = 1; n <= reach; ++n) sum += weights[n] * (middle[-n * stride] + middle[n * stride]);
    to[i] = sum;
  }
}

}  // namespace

// Along x, y and z in turn; each pass leaves fewer voxels along the axis.
void WideOpacities::smooth(int reach, float* out) {
  float *from = values[0], *to = values[1];
  const int stride[3] = {1, kRow, kRow * kRow};
  std::array<int, 3> size;
  size.fill(kEdge + 2 * reach);
  for (std::size_t a = 0; a < 3 && reach > 0; ++a) {
    size[a] = kEdge;
    for (int k = 0; k < size[2]; ++k) {
      for (int j = 0; j < size[1]; ++j) smoothRow(from, to, reach, (k * kRow + j) * kRow, size[0], stride[a]);
    }
    std::swap(from, to);
  }
  for (int k = 0; k < kEdge; ++k) {
    for (int j = 0; j < kEdge; ++j)
      std::copy_n(from + (k * kRow + j) * kRow, kEdge, out + (k * kEdge + j) * kPatchStride);
  }
}

}  // namespace kiln
