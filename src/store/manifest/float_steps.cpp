#include "store/manifest/float_steps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace kiln {

std::string mergedValuesText(const Manifest& manifest) {
  // Number of shades that a transfer function needs.
  constexpr double kEnough = 1024;
  constexpr int kFloatBits = 23;
  if (manifest.volume_class == VolumeClass::kLabels || sizeOf(manifest.type) < 4 || manifest.type == VoxelType::f32 ||
      manifest.range.empty())
    return {};
  // The range of the histogram excludes a distant fill value.
  const ValueHistogram& histogram = manifest.histogram;
  const ValueRange values = histogram.hi > histogram.lo ? ValueRange{histogram.lo, histogram.hi} : manifest.range;
  const double span = values.hi - values.lo, largest = std::max(std::abs(values.lo), std::abs(values.hi));
  if (!(span > 0) || !std::isfinite(span)) return {};
  const double step = std::exp2(std::ilogb(largest) - kFloatBits), apart = std::floor(span / step) + 1;
  if (apart >= kEnough || (!isFloating(manifest.type) && step <= 1)) return {};
  return fmt::format(
      "its values from {:.12g} to {:.12g} are stored exactly, but pictures compute with 32-bit floats, which step by "
      "{:.3g} there and make {:.0f} value{} of them; subtract {:.6g} from the source's values",
      values.lo, values.hi, step, apart, apart == 1 ? "" : "s", values.lo);
}

}  // namespace kiln
