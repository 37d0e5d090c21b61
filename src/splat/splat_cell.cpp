#include "splat/splat_cell.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace kiln {
namespace {

constexpr float kCut = static_cast<float>(kFootprintRadius * kFootprintRadius);
// A footprint of up to this many pixels is normalised by the sum of its taps; beyond, the sum is its integral to
// within 1e-3.
constexpr int kSmallTaps = 256;

// exp(-q/2) for 0 <= q <= kCut in steps of 1/64, read with linear interpolation: error below 3e-5.
constexpr int kGaussianSteps = 64;
const std::array<float, static_cast<std::size_t>(kCut)* kGaussianSteps + 2> kGaussian = [] {
  std::array<float, static_cast<std::size_t>(kCut) * kGaussianSteps + 2> table{};
  for (std::size_t i = 0; i < table.size(); ++i)
    table[i] = static_cast<float>(std::exp(-0.5 * static_cast<double>(i) / kGaussianSteps));
  return table;
}();

float gaussian(float q) {
  const float at = q * kGaussianSteps;
  const int i = static_cast<int>(at);
  const float t = at - static_cast<float>(i);
  return kGaussian[static_cast<std::size_t>(i)] +
         t * (kGaussian[static_cast<std::size_t>(i) + 1] - kGaussian[static_cast<std::size_t>(i)]);
}

// 1 - exp(-x) for x >= 0, the opacity of optical depth x, to 2e-6 of its value. The same bits on every machine.
float opacityOf(float x) {
  if (x < 0.02f) return x * (1.0f - x * (0.5f - x * (1.0f / 6.0f)));
  if (x > 80.0f) return 1.0f;
  // exp(-x) = 2^n 2^f with f in [-1/2, 1/2].
  const float y = x * -1.44269504f;
  const float n = std::floor(y + 0.5f);
  const float f = y - n;
  const float p =
      1.0f + f * (0.69314718f + f * (0.24022651f + f * (0.05550411f + f * (0.00961813f + f * 0.00133336f))));
  return 1.0f - p * std::bit_cast<float>(static_cast<std::int32_t>(n + 127.0f) << 23);
}

// One sample, projected: everything of it that does not depend on its material.
struct Footprint {
  double x, y;  // centre. unit: pixels
  Ellipse ellipse;
  PixelRect rect;  // not cut off by the tile
};

PixelRect rectAround(double x, double y, const Ellipse& e) {
  // Pixel column c has its centre at c + 1/2.
  return {static_cast<int>(std::ceil(x - e.half_x - 0.5)), static_cast<int>(std::ceil(y - e.half_y - 0.5)),
          static_cast<int>(std::floor(x + e.half_x - 0.5)) + 1, static_cast<int>(std::floor(y + e.half_y - 0.5)) + 1};
}

// Weight times optical depth of a tap, for the whole footprint: the sum of taps is taken over all of them, tile or not.
class Taps {
 public:
  Taps(const Footprint& print) : print_(print), width_(print.rect.x1 - print.rect.x0) {
    const std::int64_t count = static_cast<std::int64_t>(width_) * (print.rect.y1 - print.rect.y0);
    small_ = count <= kSmallTaps;
    if (!small_) {
      sum_ = print.ellipse.area;
      return;
    }
    sum_ = 0;
    int i = 0;
    for (int y = print.rect.y0; y < print.rect.y1; ++y) {
      for (int x = print.rect.x0; x < print.rect.x1; ++x) sum_ += weights_[i++] = weightAt(x, y);
    }
  }
  float sum() const { return sum_; }
  float operator()(int x, int y) const {
    return small_ ? weights_[(y - print_.rect.y0) * width_ + (x - print_.rect.x0)] : weightAt(x, y);
  }

 private:
  float weightAt(int x, int y) const {
    const float dx = static_cast<float>(x + 0.5 - print_.x);
    const float dy = static_cast<float>(y + 0.5 - print_.y);
    const Ellipse& e = print_.ellipse;
    const float q = e.a * dx * dx + 2 * e.b * dx * dy + e.c * dy * dy;
    return q <= kCut ? gaussian(std::max(q, 0.0f)) : 0.0f;
  }
  const Footprint& print_;
  int width_;
  bool small_;
  float sum_;
  float weights_[kSmallTaps];
};

// What a sample tells beside its colour.
struct AovSplat {
  float depth;       // unit: world
  glm::vec3 normal;  // in view space, of unit length or 0
};

// A pixel's alpha was `before` and is more by `added`, not closed yet.
void addAovSplat(const AovPixels& aovs, std::ptrdiff_t at, const AovSplat& place, float before, float added,
                 bool closes) {
  const float after = before + added;
  aovs.add(at, added * place.depth, added * place.normal, closes ? 1 / after : 1);
  if (aovs.first != nullptr && before < kHitAlpha && (after >= kHitAlpha || closes)) aovs.first[at] = place.depth;
}

// Front to back over the pixels; a pixel that reaches the threshold is divided by its alpha and closed, so that its
// alpha of one lets nothing more in, whatever the visibility method. `place` is asked for where the tile has AOVs.
template <bool kAovs>
void accumulate(const SplatFrame& frame, const TilePixels& tile, const Footprint& print, float depth,
                const Color& color, const AovSplat& place) {
  const Taps taps(print);
  if (!(taps.sum() > 0)) return;
  const float scale = depth / taps.sum();
  const PixelRect rect = intersection(print.rect, tile.rect);
  for (int y = rect.y0; y < rect.y1; ++y) {
    float* pixel = tile.rgba + (y - tile.rect.y0) * tile.stride + std::ptrdiff_t{4} * (rect.x0 - tile.rect.x0);
    for (int x = rect.x0; x < rect.x1; ++x, pixel += 4) {
      if (pixel[3] == 1.0f) continue;
      const float before = pixel[3];
      const float alpha = opacityOf(scale * taps(x, y)) * (1.0f - before);
      pixel[0] += alpha * color.r;
      pixel[1] += alpha * color.g;
      pixel[2] += alpha * color.b;
      pixel[3] += alpha;
      const bool closes = pixel[3] >= frame.opaque_at;
      if constexpr (kAovs) addAovSplat(tile.aovs, tile.placeOf(x, y), place, before, alpha, closes);
      if (!closes) continue;
      const float full = 1.0f / pixel[3];
      for (int channel = 0; channel < 3; ++channel) pixel[channel] *= full;
      pixel[3] = 1.0f;
      frame.visibility->close(x, y);
    }
  }
}

template <class T>
class CellSplatter {
 public:
  CellSplatter(const SplatFrame& frame, const BrickBlock& block, const TilePixels& tile, SplatCounts& counts)
      : frame_(frame), block_(block), voxels_(block.data<T>()), tile_(tile), counts_(counts) {}

  void cell(const VoxelBox& box) {
    cut_ = frame_.clip->classify(box) == ClipRegion::Overlap::kCut;
    std::uint8_t order[3][kCellSize];
    int count[3] = {};
    for (int axis = 0; axis < 3; ++axis) {
      count[axis] = static_cast<int>(box.hi[axis] - box.lo[axis]);
      frame_.projector->order().axisOrder(axis, box.lo[axis], count[axis], order[axis]);
    }
    for (int k = 0; k < count[2]; ++k) {
      for (int j = 0; j < count[1]; ++j) {
        const VoxelCoord row = {box.lo.x, box.lo.y + order[1][j], box.lo.z + order[2][k]};
        const T* const values = voxels_ + block_.offsetOf(row);
        for (int i = 0; i < count[0]; ++i) {
          const int x = order[0][i];
          if constexpr (std::is_floating_point_v<T>) {
            if (std::isnan(values[x])) continue;
          }
          const Material material = frame_.classifier->at(values[x]);
          if (material.tau > 0) sample({row.x + x, row.y, row.z}, values + x, material);
        }
      }
    }
  }

 private:
  void sample(const VoxelCoord& v, const T* value, const Material& material) {
    const Projector& projector = *frame_.projector;
    const glm::dvec3 index(v.x, v.y, v.z);
    if (cut_ && !frame_.clip->contains(index)) return;
    const glm::dvec3 p = projector.viewOf(v);
    if (projector.perspective() && p.z < projector.nearDepth()) return;
    const glm::dvec2 at = projector.pixelOf(p);
    const Ellipse ellipse = projector.ellipseAt(p);
    // Far outside, where numbers of pixels would leave the range of int, nothing reaches an image.
    if (!(std::abs(at.x) + ellipse.half_x < 1e8) || !(std::abs(at.y) + ellipse.half_y < 1e8)) return;
    const Footprint print{at.x, at.y, ellipse, rectAround(at.x, at.y, ellipse)};
    const PixelRect touched = intersection(print.rect, tile_.rect);
    if (touched.empty()) return;
    const bool counted = tile_.rect.contains(static_cast<int>(std::floor(at.x)), static_cast<int>(std::floor(at.y)));
    counts_.visited += counted ? 1 : 0;
    if (frame_.test_samples && frame_.visibility->hidden(touched)) return;
    counts_.splats += counted ? 1 : 0;
    counts_.changed = true;
    const glm::vec3 slope = gradient(value);
    const float tau = frame_.gradient_opacity.active() ? frame_.gradient_opacity(material.tau, slope) : material.tau;
    const float depth = tau * static_cast<float>(projector.lengthAt(p) * frame_.ends.partOf(v));
    const glm::vec3* const face = cut_ ? frame_.clip->cutGradient(index) : nullptr;
    const Shader& shader = frame_.shader;
    const Color color = face != nullptr ? shader.onCut(material, *face, p) : shader(material, slope, p);
    if (!tile_.aovs.any()) {
      accumulate<false>(frame_, tile_, print, depth, color, {});
    } else {
      const glm::vec3 normal = face != nullptr ? shader.normalOnCut(*face, p) : shader.normal(slope, p);
      accumulate<true>(frame_, tile_, print, depth, color, {static_cast<float>(p.z), normal});
    }
  }

  // Central differences at voxel scale, of labels those of their opacities. unit: value per voxel.
  glm::vec3 gradient(const T* at) const {
    const Classifier& classifier = *frame_.classifier;
    const auto half = [&](T hi, T lo) {
      if (classifier.ofLabels())
        return 0.5f * (classifier.opacityOf(static_cast<double>(hi)) - classifier.opacityOf(static_cast<double>(lo)));
      if constexpr (sizeof(T) >= 4 && !std::is_same_v<T, float>) {
        return static_cast<float>(0.5 * (static_cast<double>(hi) - static_cast<double>(lo)));
      } else {
        return 0.5f * (static_cast<float>(hi) - static_cast<float>(lo));
      }
    };
    const std::ptrdiff_t y = block_.strideY();
    const std::ptrdiff_t z = block_.strideZ();
    const glm::vec3 g(half(at[1], at[-1]), half(at[y], at[-y]), half(at[z], at[-z]));
    // Beside a NaN or an infinity there is no slope to shade by.
    return std::isfinite(g.x + g.y + g.z) ? g : glm::vec3(0);
  }

  const SplatFrame& frame_;
  const BrickBlock& block_;
  const T* voxels_;
  const TilePixels& tile_;
  SplatCounts& counts_;
  bool cut_ = false;  // the cell in turn, by the clip region
};

}  // namespace

void splatCell(const SplatFrame& frame, const BrickBlock& block, const VoxelBox& cell, const TilePixels& tile,
               SplatCounts& counts) noexcept {
  withVoxelType(block.type,
                [&]<class T>(std::type_identity<T>) { CellSplatter<T>(frame, block, tile, counts).cell(cell); });
}

}  // namespace kiln
