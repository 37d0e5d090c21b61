// Sums of footprints at every phase and angle of the lattice against the pixels. In a box of a uniform medium a pixel's
// optical depth is extinction times the ray's chord; any ripple comes from the footprints. The silhouette of an opaque
// ball is a circle of known radius; a larger silhouette is fattening.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <numbers>
#include <optional>

#include "store/store_reader.h"
#include "support/reference/drawing.h"
#include "support/reference/lattices.h"
#include "support/reference/quality_scenes.h"
#include "support/reference/reference_renderer.h"
#include "support/volumes/procedural.h"
#include "support/volumes/random_scene.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

constexpr double kDistance = 120;  // distance of the eye, in perspective outside every volume. unit: world

class LatticeWeights : public ::testing::TestWithParam<std::tuple<Lattice, Projection>> {
 protected:
  void open(const DenseVolume& volume) {
    reader_.emplace(makeStore(volume, "volume", 32));
    cache_.emplace(*reader_, 1ull << 30);
  }

  FrameRequest request() const {
    FrameRequest out;
    setLattice(out, std::get<0>(GetParam()));
    out.shading.phong = false;
    out.opacity_threshold = 1;
    out.level = 0;
    return out;
  }

  // Returns a camera that sees `extent` world units in `pixels` pixels. The camera's target is a random point within a
  // voxel of `target`.
  Camera camera(Random& random, const glm::dvec3& target, const glm::dvec3& from, double extent) const {
    Camera out;
    out.projection = std::get<1>(GetParam());
    out.target = target + glm::dvec3(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5));
    out.eye = out.target + kDistance * from;
    out.fov_deg = 2 * std::atan(extent / 2 / kDistance) * 180 / std::numbers::pi;
    out.up = random.direction();
    out.height = extent;
    return out;
  }

  Image drawn(const FrameRequest& request) {
    Progress silent;
    FrameStatistics statistics;
    return renderFrame(*cache_, request, silent, statistics);
  }

  std::optional<StoreReader> reader_;
  std::optional<BrickCache> cache_;
};

constexpr std::int64_t kCubeSide = 36;  // unit: voxels, and with spacing 1 the world's

// Returns the length of a ray inside the box, 0 for rays beside the box.
double chord(const Ray& ray) {
  double begin = -1e30, end = 1e30;
  for (int axis = 0; axis < 3; ++axis) {
    const double a = (-0.5 - ray.origin[axis]) / ray.direction[axis];
    const double b = (kCubeSide - 0.5 - ray.origin[axis]) / ray.direction[axis];
    begin = std::max(begin, std::min(a, b));
    end = std::min(end, std::max(a, b));
  }
  return std::max(0.0, end - std::max(begin, ray.begin));
}

// Errors relative to the expected optical depth of a pixel.
struct Ripple {
  double squares = 0, sum = 0, worst = 0;
  int pixels = 0;
  void add(double deviation) {
    squares += deviation * deviation;
    sum += deviation;
    worst = std::max(worst, std::abs(deviation));
    ++pixels;
  }
  double rms() const { return std::sqrt(squares / pixels); }
  double mean() const { return sum / pixels; }
};

// Accumulates pixels at least `margin` px inside the silhouette and away from kinks of the chord length, which any
// footprint rounds off.
Ripple rippleOf(const Image& image, const View& view, double tau, int margin) {
  std::vector<double> chords;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) chords.push_back(chord(rayThrough(view, {x + 0.5, y + 0.5})));
  }
  const auto chordAt = [&](int x, int y) { return chords[static_cast<std::size_t>(y * image.width + x)]; };
  const auto smooth = [&](int x, int y) {
    constexpr double kLeast = 8, kMostBend = 1e-2;
    const double here = chordAt(x, y);
    for (const auto& [dx, dy] : {std::pair(1, 0), {0, 1}, {1, 1}, {1, -1}}) {
      const double before = chordAt(x - margin * dx, y - margin * dy),
                   after = chordAt(x + margin * dx, y + margin * dy);
      if (before < kLeast || after < kLeast || std::abs(before + after - 2 * here) > kMostBend * here) return false;
    }
    return true;
  };
  Ripple out;
  for (int y = margin; y < image.height - margin; ++y) {
    for (int x = margin; x < image.width - margin; ++x) {
      if (!smooth(x, y)) continue;
      const double found = -std::log1p(-static_cast<double>(image.pixel(x, y)[3]));
      out.add(found / (tau * chordAt(x, y)) - 1);
    }
  }
  return out;
}

// The first views run along the lattice's axes, where all layers have an equal phase: the worst case.
TEST_P(LatticeWeights, SumToOne) {
  open(fill({{kCubeSide, kCubeSide, kCubeSide}, VoxelType::u8}, [](auto...) { return 100.0; }));
  constexpr double kTau = 0.03;
  FrameRequest r = request();
  r.transfer_function = {1, {{100, glm::dvec3(1), -std::expm1(-kTau)}}};
  const auto [lattice, projection] = GetParam();
  for (const double px_per_voxel : {0.6, 1.0, 1.37, 2.0, 3.3, 5.0}) {
    double worst_rms = 0, worst = 0, worst_mean = 0;
    int pixels = 0;
    for (std::uint64_t view = 0; view < (px_per_voxel < 3 ? 20 : 6); ++view) {
      Random random(view);
      const glm::dvec3 along(view == 0, view == 1, view == 2);
      constexpr int kPixels = 64;
      r.view = resolve(camera(random, glm::dvec3((kCubeSide - 1) / 2.0), view < 3 ? along : random.direction(),
                              kPixels / px_per_voxel),
                       {kPixels, kPixels});
      // A footprint of the voxel lattice grows with the voxel.
      const int margin = lattice == Lattice::kVoxel ? 3 + static_cast<int>(1.65 * px_per_voxel) : 3;
      const Ripple ripple = rippleOf(drawn(r), r.view, kTau, margin);
      pixels += ripple.pixels;
      if (ripple.pixels == 0) continue;
      worst_rms = std::max(worst_rms, ripple.rms());
      worst = std::max(worst, ripple.worst);
      worst_mean = std::max(worst_mean, std::abs(ripple.mean()));
    }
    std::printf("%s lattice, %s, %.2f px/voxel: at worst mean %.2f %%, rms %.2f %%, a pixel %.2f %%\n", nameOf(lattice),
                nameOf(projection), px_per_voxel, 100 * worst_mean, 100 * worst_rms, 100 * worst);
    EXPECT_GT(pixels, 200) << px_per_voxel;
    EXPECT_LT(worst_rms, 0.01) << px_per_voxel;
    EXPECT_LT(worst, lattice == Lattice::kVoxel ? 0.025 : 0.02) << px_per_voxel;
  }
}

// Distance inwards from a sphere: linear along the radius. Interpolation rounds the curvature off and shrinks the
// sphere by 1/(4 radius) voxels on average.
constexpr double kRadius = 20;
constexpr double kInterpolatedRadius = kRadius - 1 / (4 * kRadius);

// Returns the mean radius of the closed line where alpha is a half, in 720 directions from the centre. unit: pixels.
double contourRadius(const Image& image, const glm::dvec2& centre, double largest) {
  const auto alphaAt = [&](const glm::dvec2& pixel) {  // bilinear between pixel centres
    const glm::dvec2 place = pixel - 0.5;
    const int x = static_cast<int>(std::floor(place.x)), y = static_cast<int>(std::floor(place.y));
    const double fx = place.x - x, fy = place.y - y;
    const auto a = [&](int i, int j) { return static_cast<double>(image.pixel(x + i, y + j)[3]); };
    return (1 - fy) * ((1 - fx) * a(0, 0) + fx * a(1, 0)) + fy * ((1 - fx) * a(0, 1) + fx * a(1, 1));
  };
  constexpr int kDirections = 720;
  double sum = 0;
  for (int n = 0; n < kDirections; ++n) {
    const double angle = 2 * std::numbers::pi * n / kDirections;
    const glm::dvec2 direction(std::cos(angle), std::sin(angle));
    constexpr double kStep = 0.02;
    double radius = largest;
    while (radius > 0 && alphaAt(centre + radius * direction) < 0.5) radius -= kStep;
    sum += radius + kStep / 2;
  }
  return sum / kDirections;
}

TEST_P(LatticeWeights, OpaqueSilhouettesAreNotFattened) {
  const glm::dvec3 centre(23.3, 23.8, 23.5);
  open(fill({{48, 48, 48}, VoxelType::f32},
            [&](auto... ijk) { return kRadius - glm::length(glm::dvec3(ijk...) - centre); }));
  FrameRequest r = request();
  r.transfer_function = {1, {{0, glm::dvec3(1), 0}, {0.05, glm::dvec3(1), 0.9999}}};
  const auto [lattice, projection] = GetParam();
  for (const double px_per_voxel : {1.0, 2.0, 4.0}) {
    double most = -1e9, least = 1e9, most_by_area = -1e9, least_by_area = 1e9;
    for (std::uint64_t view = 0; view < 6; ++view) {
      Random random(100 + view);
      const int pixels = static_cast<int>(2 * (kRadius + 5) * px_per_voxel);
      Camera c = camera(random, centre, view == 0 ? glm::dvec3(0, 0, 1) : random.direction(), pixels / px_per_voxel);
      // The phase against the pixels stays: the centre need not be a pixel's. On the axis the outline is a circle.
      c.eye += centre - c.target;
      c.target = centre;
      r.view = resolve(c, {pixels, pixels});
      r.view.centre_px += glm::dvec2(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5));
      const double distance = glm::length(c.eye - centre);
      const double exact =
          r.view.focal_px *
          (projection == Projection::kPerspective
               ? kInterpolatedRadius / std::sqrt(distance * distance - kInterpolatedRadius * kInterpolatedRadius)
               : kInterpolatedRadius);
      const Image image = drawn(r);
      const double growth = contourRadius(image, r.view.centre_px, pixels / 2.0 - 2) - exact;
      double area = 0;
      for (std::size_t i = 3; i < image.rgba.size(); i += 4) area += image.rgba[i];
      const double growth_by_area = std::sqrt(area / std::numbers::pi) - exact;
      most = std::max(most, growth);
      least = std::min(least, growth);
      most_by_area = std::max(most_by_area, growth_by_area);
      least_by_area = std::min(least_by_area, growth_by_area);
    }
    std::printf("%s lattice, %s, %.0f px/voxel: silhouette grows by %+.2f to %+.2f px, by its area %+.2f to %+.2f px\n",
                nameOf(lattice), nameOf(projection), px_per_voxel, least, most, least_by_area, most_by_area);
    // Compositing splat by splat fattens, by as much as footprints are wide.
    const double allowed = lattice == Lattice::kVoxel ? 0.4 + 1.1 * px_per_voxel : 0.15;
    EXPECT_LT(most, allowed) << px_per_voxel;
    EXPECT_LT(most_by_area, allowed) << px_per_voxel;
    EXPECT_GT(least, -0.15) << px_per_voxel;
    EXPECT_GT(least_by_area, -0.15) << px_per_voxel;
  }
}

INSTANTIATE_TEST_SUITE_P(Lattices, LatticeWeights,
                         ::testing::Combine(::testing::ValuesIn(kLattices),
                                            ::testing::Values(Projection::kOrthographic, Projection::kPerspective)));

}  // namespace
}  // namespace kiln::test
