#include "image/srgb.h"

#include <limits>
#include <numeric>

namespace kiln {
namespace {

long stepOf(double linear) { return std::lround(255 * srgbFromLinear(linear)); }

// Returns the least number that encodes to `byte`. requires: byte > 0.
double beginOf(long byte) {
  const auto linearAt = [&](double offset) { return linearFromSrgb((static_cast<double>(byte) + offset) / 255); };
  double below = linearAt(-0.51), begin = linearAt(-0.49);
  for (double middle = std::midpoint(below, begin); below < middle && middle < begin;
       middle = std::midpoint(below, begin))
    (stepOf(middle) < byte ? below : begin) = middle;
  return begin;
}

}  // namespace

SrgbBytes::SrgbBytes() {
  next_.back() = std::numeric_limits<double>::infinity();
  for (std::size_t byte = 0; byte < 255; ++byte) next_[byte] = beginOf(static_cast<long>(byte) + 1);
  for (std::size_t byte = 0; byte < 256; ++byte) light_[byte] = linearFromSrgb(static_cast<double>(byte) / 255);
  for (std::size_t byte = 0; byte < 255; ++byte) bytes_per_light_[byte] = 1 / (light_[byte + 1] - light_[byte]);
  for (std::size_t cell = 0; cell < kCells; ++cell)
    at_cell_[cell] = static_cast<std::uint8_t>(stepOf(static_cast<double>(cell) / kCells));
}

const SrgbBytes& SrgbBytes::all() {
  static const SrgbBytes bytes;
  return bytes;
}

}  // namespace kiln
