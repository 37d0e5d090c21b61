#include "engine/projection/projected_values.h"

#include <cmath>
#include <limits>

namespace kiln {
namespace {

constexpr double kNothingHeld = -std::numeric_limits<double>::infinity();
constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();

}  // namespace

ProjectedValues::ProjectedValues(PixelValue held, const PixelRect& rect, const Attenuation& attenuation)
    : rect_(rect), blocks_(blocksOf(rect)), rule_(held), attenuation_(attenuation) {
  const std::size_t pixels = rect.count();
  held_.assign(pixels, mean() ? 0 : kNothingHeld);
  if (accumulates()) length_.assign(pixels, 0);
  if (!mean()) least_.assign(blocks_.count(), kNothingHeld);
}

PixelRect ProjectedValues::blocksOf(const PixelRect& rect) const {
  return {rect.x0 / kBlock, rect.y0 / kBlock, (rect.x1 - 1) / kBlock + 1, (rect.y1 - 1) / kBlock + 1};
}

// An attenuated pixel counts with its value less the greatest that a further sample may have: closed from 0 on. A NaN
// compares false: no value exceeds it, and update() never selects it as the least.
void ProjectedValues::leaveOut(int x, int y) {
  if (!mean()) *held(x, y) = kNoValue;
}

void ProjectedValues::update(const PixelRect& rect) {
  if (mean()) return;
  const PixelRect blocks = blocksOf(rect);
  for (int by = blocks.y0; by < blocks.y1; ++by) {
    for (int bx = blocks.x0; bx < blocks.x1; ++bx) {
      const PixelRect block = intersection({kBlock * bx, kBlock * by, kBlock * (bx + 1), kBlock * (by + 1)}, rect_);
      double least = std::numeric_limits<double>::infinity();
      for (int y = block.y0; y < block.y1; ++y) {
        const double* const row = held(block.x0, y);
        const double* const depth = attenuated() ? length(block.x0, y) : nullptr;
        for (int i = 0; i < block.width(); ++i) {
          const double bound = depth != nullptr ? row[i] - std::exp(-depth[i]) : row[i];
          least = bound < least ? bound : least;
        }
      }
      least_[blockAt(bx, by)] = least;
    }
  }
}

double ProjectedValues::least(const PixelRect& rect) const {
  const PixelRect blocks = blocksOf(rect);
  double out = std::numeric_limits<double>::infinity();
  for (int by = blocks.y0; by < blocks.y1; ++by) {
    for (int bx = blocks.x0; bx < blocks.x1; ++bx) out = std::min(out, least_[blockAt(bx, by)]);
  }
  return out;
}

double ProjectedValues::value(int x, int y) const {
  const double held = held_[placeOf(x, y)];
  if (mean()) {
    const double length = length_[placeOf(x, y)];
    return length > 0 ? held / length : kNoValue;
  }
  if (attenuated())
    return held > kNothingHeld ? attenuation_.lo + held * (attenuation_.hi - attenuation_.lo) : kNoValue;
  return held > kNothingHeld ? sign() * held : kNoValue;
}

}  // namespace kiln
