#include "support/scalar_kernels.h"

#include <hwy/targets.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

namespace kiln::test {

void onEveryInstructionSet(const std::function<void(std::int64_t target)>& f) {
  // The lowest bit is the best. For one that there are no kernels for, another one's are taken.
  std::vector<std::int64_t> targets;
  for (std::int64_t rest = hwy::SupportedTargets(); rest != 0; rest &= rest - 1) targets.push_back(rest & -rest);
  std::set<std::string> done;
  for (auto target = targets.rbegin(); target != targets.rend(); ++target) {
    hwy::SetSupportedTargetsForTest(*target);
    if (done.insert(instructionSet()).second) f(*target);
  }
  hwy::SetSupportedTargetsForTest(0);
}

UnitRanges loadUnitScalar(const BrickBlock& block, const UnitLattice& lattice, double offset, const VoxelCoord& lo,
                          float* values) {
  UnitRanges out;
  const auto& n = lattice.voxels;
  const int rim = lattice.interpolation == Interpolation::kLinear ? kUnitMargin - 1 : 0;
  const auto include = [](SampledRange& range, double value) {
    range.values.include(value);
    range.gaps = range.gaps || std::isnan(value);
  };
  const auto inner = [&](int i, int first, int end) {
    return i >= first + rim - kUnitMargin && i < end + kUnitMargin - rim;
  };
  withVoxelType(block.type, [&]<class T>(std::type_identity<T>) {
    const T* const voxels = reinterpret_cast<const T*>(block.voxels.data());
    for (int z = -kUnitMargin; z < n[2] + kUnitMargin; ++z) {
      for (int y = -kUnitMargin; y < n[1] + kUnitMargin; ++y, values += kUnitSamples) {
        for (int x = -kUnitMargin; x < n[0] + kUnitMargin; ++x) {
          VoxelCoord at = {lo.x + x, lo.y + y, lo.z + z};
          for (int a = 0; a < 3; ++a) at[a] = std::clamp(at[a], block.extent.lo[a], block.extent.hi[a] - 1);
          const auto value = static_cast<double>(voxels[block.offsetOf(at)]);
          values[x + kUnitMargin] = static_cast<float>(value - offset);
          if (std::abs(value - offset) > 1e37) values[x + kUnitMargin] = std::copysign(1e37f, values[x + kUnitMargin]);
          if (!inner(y, 0, n[1]) || !inner(z, 0, n[2])) continue;
          if (inner(x, 0, n[0])) include(out.whole, value);
          for (int half = 0; half < lattice.blocks && lattice.blocks > 1; ++half) {
            const int first = half * n[0] / 2;
            if (inner(x, first, first + n[0] / 2)) include(out.blocks[static_cast<std::size_t>(half)], value);
          }
        }
      }
    }
  });
  return out;
}

void addSamplesScalar(std::span<const SlabSample* const> samples, const FootprintTable& footprint, Sheet& here,
                      Sheet& next) {
  const auto rounded = [](float v) { return static_cast<std::int32_t>(std::lrint(v)); };
  const auto add = [&](const SlabSample& s, float amount, Sheet& sheet) {
    const float fill = amount * Sheet::kOne, scale = fill * s.opacity;
    const float of_color = fill * s.opacity * (1 / sheet.colorUnit());
    const float light[4] = {of_color * s.r, of_color * s.g, of_color * s.b, scale};
    const float* const across = footprint.row(s.place.phaseX());
    const float* const down = footprint.row(s.place.phaseY());
    // The window of the tile's first pixel begins all but one of its pixels before it.
    const PixelRect& tile = sheet.rect();
    const int x0 = tile.x0 + s.place.x() - (footprint.taps() - 1), y0 = tile.y0 + s.place.y() - (footprint.taps() - 1);
    for (int y = std::max(y0, tile.y0); y < std::min(y0 + footprint.taps(), tile.y1); ++y) {
      for (int x = std::max(x0, tile.x0); x < std::min(x0 + footprint.taps(), tile.x1); ++x) {
        for (int c = 0; c < 4; ++c) sheet.at(x, y)[c] += rounded(across[x - x0] * light[c] * down[y - y0]);
        *sheet.filledAt(x, y) += rounded(across[x - x0] * fill * down[y - y0]);
      }
    }
  };
  for (const SlabSample* s : samples) {
    if (s->front > 0) add(*s, s->front, here);
    if (s->back > 0) add(*s, s->back, next);
  }
}

bool layPixelScalar(float* pixel, const std::int32_t* sum, std::int32_t filled, float erosion, float color_unit,
                    CoveredPixel& covered) {
  if (sum[3] == 0) return false;
  const auto full = static_cast<float>(filled);
  const float opacity = static_cast<float>(sum[3]) / full, less = erosionOf(opacity, erosion);
  const float f = std::max(1 - (1 - std::min(full / Sheet::kOne, 1.0f)) * (1 + less), 0.0f);
  const float steep = 3 - (f + f), flat = f * (f * (6 * f - 15) + 10);
  const float part = f * f * (flat + solidOf(opacity) * (steep - flat));
  const float in_front = static_cast<float>(covered) * (1.0f / 255);
  const float density = std::min(pixel[3] / std::max(in_front, 1.0f / 255), 1.0f);
  const float share = (part - std::min(part, in_front) * density) / full;
  covered = std::max(covered, static_cast<CoveredPixel>(std::ceil(part * 255)));
  for (int c = 0; c < 4; ++c) pixel[c] += (c < 3 ? share * color_unit : share) * static_cast<float>(sum[c]);
  return true;
}

LaidBlock laySheetScalar(const SheetBlock& block) {
  LaidBlock out;
  for (int y = 0; y < block.height; ++y) {
    const auto row = static_cast<std::size_t>(y);
    for (int x = 0; x < kBlockEdge; ++x) {
      const bool takes = x < block.width && (block.takes[row] >> x & 1) != 0;
      float* const pixel = block.pixels + y * block.stride + 4 * x;
      std::int32_t* const sum = block.sums + 4 * (y * block.columns + x);
      std::int32_t& filled = block.filled[y * block.columns + x];
      if (takes && layPixelScalar(pixel, sum, filled, block.erosion, block.color_unit,
                                  block.covered[y * (block.stride / 4) + x])) {
        out.changed[row] = static_cast<std::uint8_t>(out.changed[row] | 1u << x);
        if (pixel[3] >= block.opaque_at) out.opaque[row] = static_cast<std::uint8_t>(out.opaque[row] | 1u << x);
      }
      std::fill_n(sum, 4, 0);
      filled = 0;
    }
  }
  return out;
}

}  // namespace kiln::test
