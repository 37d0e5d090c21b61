#include "support/reference/scalar_voxels.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

namespace kiln::test {
namespace {

constexpr float kRadius = static_cast<float>(kFootprintRadius);
constexpr float kHalfLog = -0.72134752f;  // half the logarithm of e, to base 2

// 2^x = whole + whole · rest.
struct Power {
  float whole, rest;
};
Power powerOf(float x) {
  const float n = std::nearbyint(x), f = x - n;
  float p = 0.00133336f;
  for (const float next : {0.00961813f, 0.05550411f, 0.24022651f, 0.69314718f}) p = std::fma(p, f, next);
  return {std::ldexp(1.0f, static_cast<int>(n)), p * f};
}
float exp2Of(float x) {
  const Power p = powerOf(x);
  return std::fma(p.whole, p.rest, p.whole);
}
float opacityOf(float x) {
  const Power p = powerOf(std::max(x * -1.44269504f, -120.0f));
  return std::fma(-p.whole, p.rest, 1 - p.whole);
}
// A footprint whose depth is small everywhere (`thin`) uses a series.
float opacityOf(float x, bool thin) {
  if (!thin) return opacityOf(x);
  float p = -1.0f / 720;
  for (const float next : {1.0f / 120, -1.0f / 24, 1.0f / 6, -0.5f, 1.0f}) p = std::fma(p, x, next);
  return x * p;
}
float log2Of(float x) {
  const auto bits = std::bit_cast<std::int32_t>(x);
  const std::int32_t e = (bits - 0x3f3504f3) >> 23;
  const float m = std::bit_cast<float>(bits - (e << 23)), s = (m - 1) / (m + 1), s2 = s * s;
  float p = 0.41219858f;
  for (const float next : {0.57707801f, 0.96179669f, 2.88539008f}) p = std::fma(p, s2, next);
  return std::fma(s, p, static_cast<float>(e));
}

float squared(float a, float b, float c) { return std::fma(a, a, std::fma(b, b, c * c)); }

// Returns the colour of a voxel as seen from the eye.
glm::vec3 colorOf(const VoxelView& view, const float* material, const glm::vec3& measured, float u, float v,
                  float oblique) {
  const glm::vec3 color(material[0], material[1], material[2]);
  const PlainLight& light = view.light;
  const glm::vec3 slope = light.gradient.factor * measured;
  const float length_squared = squared(slope.x, slope.y, slope.z);
  if (!light.phong || !(length_squared > light.gradient.least_squared && length_squared < 1e38f)) return color;
  const glm::mat3& m = light.view_from_index_gradient;
  const auto line = [&](int c) { return std::fma(m[0][c], slope.x, std::fma(m[1][c], slope.y, m[2][c] * slope.z)); };
  const glm::vec3 n(line(0), line(1), line(2));
  float along = n.z, length = std::sqrt(squared(n.x, n.y, n.z));
  if (view.perspective) {
    along = std::fma(u, n.x, std::fma(v, n.y, n.z));
    length *= oblique;
  }
  const float cosine = std::min(std::abs(along) / length, 1.0f);
  const float matte = std::fma(light.diffuse, cosine, light.ambient);
  float gloss = 0;
  if (light.specular > 0) {
    const float log = log2Of(std::max(cosine, 1e-30f)) * light.power;
    gloss = light.specular * exp2Of(std::min(std::max(log, -120.0f), 0.0f));
  }
  return {std::fma(color.r, matte, gloss), std::fma(color.g, matte, gloss), std::fma(color.b, matte, gloss)};
}

// The logarithm of a weight, to base 2, is xx dx² + xy dx dy + yy dy².
struct Form {
  float xx, xy, yy, area;
};
Form formOf(const VoxelView& view, const ProjectedVoxels& p, std::size_t n) {
  Form out;
  if (!view.perspective) {
    out = {kHalfLog * view.ellipse.a, 2 * kHalfLog * view.ellipse.b, kHalfLog * view.ellipse.c, 0};
  } else {
    const float* const c = view.covariance;
    const float u = p.u[n], v = p.v[n], near = p.r[n] * p.r[n];
    const float xy = near * (c[1] + (u * v * c[5] - (v * c[3] + u * c[4])));
    const float scale = kHalfLog / (p.xx[n] * p.yy[n] - xy * xy);
    out = {scale * p.yy[n], -2 * (scale * xy), scale * p.xx[n], 0};
  }
  const float a = out.xx / kHalfLog, b = out.xy / (2 * kHalfLog), c = out.yy / kHalfLog;
  out.area = 6.21338519f / std::sqrt(a * c - b * b);
  return out;
}

// shape: the footprint's rows, concatenated.
std::vector<float> weightsOf(const Form& form, const ProjectedVoxels& p, std::size_t n) {
  std::vector<float> out;
  for (int j = 0; j < p.y1[n] - p.y0[n]; ++j) {
    for (int i = 0; i < p.x1[n] - p.x0[n]; ++i) {
      const float dx = p.dx[n] + static_cast<float>(i), dy = p.dy[n] + static_cast<float>(j);
      const float across = std::fma(dx, form.xx, dy * form.xy), log = std::fma(dx, across, dy * dy * form.yy);
      out.push_back(log >= kHalfLog * (kRadius * kRadius) ? exp2Of(std::min(log, 0.0f)) : 0.0f);
    }
  }
  return out;
}

// Adds every sixteenth weight, counted over the whole footprint, or within each row of a wide footprint. The 16 sums
// are then added in halves.
float sumOf(const std::vector<float>& weights, std::size_t columns) {
  const std::size_t row = columns <= 8 && weights.size() <= 16 * columns ? weights.size() : columns;
  float sums[16] = {};
  for (std::size_t i = 0; i < weights.size(); ++i) sums[i % row % 16] += weights[i];
  for (std::size_t half = 8; half >= 1; half /= 2) {
    for (std::size_t i = 0; i < half; ++i) sums[i] += sums[i + half];
  }
  return sums[0];
}

// Returns the opacity of a voxel over each pixel of its footprint; the optical depths sum to `depth`.
std::vector<float> opacitiesOf(const VoxelView& view, const ProjectedVoxels& p, std::size_t n, float depth) {
  const PixelRect rect = p.rect(n);
  const auto width = static_cast<std::size_t>(rect.width()), height = static_cast<std::size_t>(rect.height());
  if (view.footprint == nullptr) {
    const Form form = formOf(view, p, n);
    std::vector<float> out = weightsOf(form, p, n);
    const float sum = out.size() <= 256 ? sumOf(out, width) : form.area;
    const float most = sum > 0 ? depth / sum : 0.0f;
    for (float& weight : out) weight = opacityOf(weight * most, most <= 0.35f);
    return out;
  }
  const float* const columns = view.footprint->columns(VoxelFootprint::phaseOf(p.dx[n], view.ellipse.half_x));
  const float* const rows = view.footprint->rows(VoxelFootprint::phaseOf(p.dy[n], view.ellipse.half_y));
  std::vector<float> out;
  for (std::size_t j = 0; j < height; ++j) {
    for (std::size_t i = 0; i < width; ++i)
      out.push_back(opacityOf(columns[i] * (depth * rows[j]), depth * view.footprint->most() <= 0.35f));
  }
  return out;
}

void addAovs(const AovPixels& aovs, std::ptrdiff_t at, const VoxelAov& voxel, float before, float added, bool closes) {
  const float after = before + added;
  aovs.add(at, added * voxel.depth, added * voxel.normal, closes ? 1 / after : 1);
  if (aovs.first != nullptr && before < kHitAlpha && (after >= kHitAlpha || closes)) aovs.first[at] = voxel.depth;
}

}  // namespace

void projectVoxelsScalar(const VoxelView& view, const VoxelCoord& lo, const std::int32_t* codes, int count,
                         const PixelRect& tile, ProjectedVoxels& out) {
  out.touching = out.inside = 0;
  for (std::size_t n = 0; n < static_cast<std::size_t>(count); ++n) {
    const VoxelCoord v = voxelAt(lo, codes[n]);
    const glm::dvec3 p =
        ((view.origin + static_cast<double>(v.z) * view.step[2]) + static_cast<double>(v.y) * view.step[1]) +
        static_cast<double>(v.x) * view.step[0];
    double scale = view.focal, half_x = view.ellipse.half_x, half_y = view.ellipse.half_y;
    if (view.perspective) {
      if (!(p.z >= view.near_depth)) continue;
      const double r = 1 / p.z;
      scale *= r;
      out.u[n] = static_cast<float>(p.x * r), out.v[n] = static_cast<float>(p.y * r);
      out.r[n] = static_cast<float>(r);
      const auto variance = [&, near = out.r[n] * out.r[n]](float slope, float own, float mixed) {
        return near * (own + slope * (slope * view.covariance[5] - 2 * mixed)) +
               static_cast<float>(kPixelSigma * kPixelSigma);
      };
      out.xx[n] = variance(out.u[n], view.covariance[0], view.covariance[3]);
      out.yy[n] = variance(out.v[n], view.covariance[2], view.covariance[4]);
      half_x = kRadius * std::sqrt(out.xx[n]), half_y = kRadius * std::sqrt(out.yy[n]);
    }
    const glm::dvec2 at(view.centre.x + scale * p.x, view.centre.y + scale * p.y);
    if (!(std::abs(at.x) + half_x < 1e8) || !(std::abs(at.y) + half_y < 1e8)) continue;
    out.x0[n] = static_cast<int>(std::ceil(at.x - half_x - 0.5)),
    out.y0[n] = static_cast<int>(std::ceil(at.y - half_y - 0.5));
    out.x1[n] = static_cast<int>(std::floor(at.x + half_x - 0.5)) + 1;
    out.y1[n] = static_cast<int>(std::floor(at.y + half_y - 0.5)) + 1;
    out.dx[n] = static_cast<float>(out.x0[n] + 0.5 - at.x), out.dy[n] = static_cast<float>(out.y0[n] + 0.5 - at.y);
    if (!intersection(out.rect(n), tile).empty()) out.touching |= 1u << n;
    if (tile.contains(static_cast<int>(std::floor(at.x)), static_cast<int>(std::floor(at.y)))) out.inside |= 1u << n;
  }
}

void layVoxelsScalar(const VoxelView& view, const ProjectedVoxels& p, const ShadedVoxels& shaded, std::uint32_t drawn,
                     const TilePixels& tile, float opacity_threshold, Visibility& visibility) {
  for (std::size_t n = 0; n < kVoxelBatch; ++n) {
    if ((drawn >> n & 1) == 0) continue;
    const float oblique = view.perspective ? std::sqrt(1 + (p.u[n] * p.u[n] + p.v[n] * p.v[n])) : 1;
    const float length = view.perspective ? view.length * (p.r[n] * p.r[n]) * oblique : view.length;
    const float* const material = shaded.material + 4 * n;
    const glm::vec3 slope(shaded.slope[0][n], shaded.slope[1][n], shaded.slope[2][n]);
    const glm::vec3 color = colorOf(view, material, slope, p.u[n], p.v[n], oblique);
    const PixelRect rect = p.rect(n);
    const auto columns = static_cast<std::size_t>(rect.width());
    const std::vector<float> opacities = opacitiesOf(view, p, n, std::min(material[3] * length, 1e30f));
    const PixelRect within = intersection(rect, tile.rect);
    for (int y = within.y0; y < within.y1; ++y) {
      for (int x = within.x0; x < within.x1; ++x) {
        float* const pixel = tile.rgba + (y - tile.rect.y0) * tile.stride + 4 * (x - tile.rect.x0);
        if (pixel[3] == 1) continue;
        const auto i = static_cast<std::size_t>(y - rect.y0) * columns + static_cast<std::size_t>(x - rect.x0);
        const float opacity = opacities[i], before = pixel[3], added = std::fma(-opacity, before, opacity);
        for (int c = 0; c < 3; ++c) pixel[c] = std::fma(added, color[c], pixel[c]);
        pixel[3] += added;
        const bool closes = pixel[3] >= opacity_threshold;
        if (tile.aovs.any()) addAovs(tile.aovs, tile.placeOf(x, y), shaded.aov[n], before, added, closes);
        if (!closes) continue;
        const float full = 1 / pixel[3];
        for (int c = 0; c < 3; ++c) pixel[c] *= full;
        pixel[3] = 1;
        visibility.close(x, y);
      }
    }
  }
}

}  // namespace kiln::test
