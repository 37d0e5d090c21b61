#include "support/reference/reference_field.h"

#include <algorithm>
#include <cmath>

#include "base/thread/parallel.h"

namespace kiln::test {
namespace {

// Weight of a voxel at distance x. unit: voxels.
double bSplineKernel(double x) {
  const double d = std::abs(x);
  return d < 1 ? 2.0 / 3 - d * d + d * d * d / 2 : d < 2 ? (2 - d) * (2 - d) * (2 - d) / 6 : 0;
}

double bSplineSlopeKernel(double x) {
  const double d = std::abs(x);
  const double slope = d < 1 ? -2 * d + 1.5 * d * d : d < 2 ? -(2 - d) * (2 - d) / 2 : 0;
  return x < 0 ? -slope : slope;
}

double catmullRomKernel(double x) {
  const double d = std::abs(x);
  return d < 1 ? 1 + d * d * (1.5 * d - 2.5) : d < 2 ? 2 + d * (-4 + d * (2.5 - 0.5 * d)) : 0;
}

// Weight of the n-th of the eight corners of a cell; bits of n: x, y, z.
double weightOf(int n, const double (&fraction)[3]) {
  return ((n & 1) != 0 ? fraction[0] : 1 - fraction[0]) * ((n & 2) != 0 ? fraction[1] : 1 - fraction[1]) *
         ((n & 4) != 0 ? fraction[2] : 1 - fraction[2]);
}

std::int64_t offsetOf(int n, const std::int64_t (&step)[3]) {
  return ((n & 1) != 0 ? step[0] : 0) + ((n & 2) != 0 ? step[1] : 0) + ((n & 4) != 0 ? step[2] : 0);
}

}  // namespace

ReferenceField::ReferenceField(const DenseVolume& volume, Interpolation interpolation)
    : dims_(volume.geometry.dims), interpolation_(interpolation) {
  values_.resize(static_cast<std::size_t>(dims_.count()));
  parallelFor(static_cast<std::size_t>(dims_.z), [&](std::size_t slice) {
    const auto k = static_cast<std::int64_t>(slice);
    std::size_t n = slice * static_cast<std::size_t>(dims_.x * dims_.y);
    for (std::int64_t j = 0; j < dims_.y; ++j) {
      for (std::int64_t i = 0; i < dims_.x; ++i) values_[n++] = volume.valueAt(i, j, k);
    }
  });
}

double ReferenceField::at(const glm::dvec3& index) const {
  if (interpolation_ == Interpolation::kLinear) return linearAt(index);
  const Kernel kernel = interpolation_ == Interpolation::kCubic ? bSplineKernel : catmullRomKernel;
  const Filtered f = filtered(index, {kernel, kernel, kernel});
  return std::isnan(f.sum) ? f.sum : std::clamp(f.sum, f.range.lo, f.range.hi);
}

glm::dvec3 ReferenceField::gradient(const glm::dvec3& index) const {
  glm::dvec3 out;
  for (int axis = 0; axis < 3; ++axis) {
    if (interpolation_ == Interpolation::kLinear) {
      glm::dvec3 one(0);
      one[axis] = 1;
      out[axis] = (linearAt(index + one) - linearAt(index - one)) / 2;
    } else {
      std::array<Kernel, 3> kernels = {bSplineKernel, bSplineKernel, bSplineKernel};
      kernels[static_cast<std::size_t>(axis)] = bSplineSlopeKernel;
      out[axis] = filtered(index, kernels).sum;
    }
  }
  return out;
}

// Edge-clamped.
double ReferenceField::linearAt(const glm::dvec3& index) const {
  std::int64_t offset[3], step[3];
  double fraction[3];
  const std::int64_t stride[3] = {1, dims_.x, dims_.x * dims_.y};
  for (int axis = 0; axis < 3; ++axis) {
    const double place = std::clamp(index[axis], 0.0, static_cast<double>(dims_[axis] - 1));
    const auto base = static_cast<std::int64_t>(place);
    fraction[axis] = place - static_cast<double>(base);
    offset[axis] = base * stride[axis];
    step[axis] = base + 1 < dims_[axis] ? stride[axis] : 0;  // otherwise the far corner has no weight
  }
  const double* const corner = values_.data() + offset[0] + offset[1] + offset[2];
  double sum = 0;
  for (int n = 0; n < 8; ++n) sum += weightOf(n, fraction) * corner[offsetOf(n, step)];
  if (!std::isnan(sum)) return sum;
  // 0 * NaN is NaN, too: corners without weight must not spoil the sum.
  sum = 0;
  for (int n = 0; n < 8; ++n) {
    if (weightOf(n, fraction) > 0) sum += weightOf(n, fraction) * corner[offsetOf(n, step)];
  }
  return sum;
}

ReferenceField::Filtered ReferenceField::filtered(const glm::dvec3& index, const std::array<Kernel, 3>& kernels) const {
  std::int64_t at[3][4];
  double weight[3][4];
  for (int axis = 0; axis < 3; ++axis) {
    for (int tap = 0; tap < 4; ++tap) {
      const double place = std::floor(index[axis]) - 1 + tap;
      at[axis][tap] = static_cast<std::int64_t>(std::clamp(place, 0.0, static_cast<double>(dims_[axis] - 1)));
      weight[axis][tap] = kernels[static_cast<std::size_t>(axis)](index[axis] - place);
    }
  }
  Filtered out;
  for (int z = 0; z < 4; ++z) {
    for (int y = 0; y < 4; ++y) {
      for (int x = 0; x < 4; ++x) {
        const double w = weight[0][x] * weight[1][y] * weight[2][z];
        if (w == 0) continue;
        const double value = voxel(at[0][x], at[1][y], at[2][z]);
        out.sum += w * value;
        out.range.include(value);
      }
    }
  }
  return out;
}

}  // namespace kiln::test
