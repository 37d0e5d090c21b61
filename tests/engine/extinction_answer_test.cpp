// Opacity is physical: -ln(1 - alpha) of a pixel equals the integral of extinction along its ray, for every direction,
// projection and density. Known in closed form, exp(-∫τ ds), for a slab, a ball and a linear ramp: the integral is a
// chord length, or a length times the value at its middle. Density is scaled until the picture's longest ray has the
// given optical depth.
// Pixels within 3 of the silhouette are left out, because their footprints straddle the edge. Coarser levels contain as
// much material and pass an equal test; the excluded border grows with their footprints.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <optional>

#include "store/store_reader.h"
#include "support/reference/drawing.h"
#include "support/reference/lattices.h"
#include "support/reference/reference_renderer.h"
#include "support/volumes/procedural.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

constexpr std::int64_t kSide = 64;
constexpr int kPixels = 110;  // about a pixel a voxel
constexpr int kViews = 20;
constexpr std::uint64_t kSeed = 20;
constexpr int kMargin = 3;

// Returns a function whose extinction is value * tau_per_value, to 1e-6: linear between 400 points.
TransferFunction linearExtinction(double largest_value, double tau_per_value) {
  TransferFunction out;
  out.unit = 1;
  constexpr int kPoints = 400;
  for (int i = 0; i <= kPoints; ++i) {
    const double value = largest_value * i / kPoints;
    out.points.push_back({value, glm::dvec3(1), -std::expm1(-value * tau_per_value)});
  }
  return out;
}

struct Segment {
  double begin, end;
};

// Returns the segment of a ray (index space) inside the box lo..hi.
std::optional<Segment> insideBox(const glm::dvec3& origin, const glm::dvec3& direction, const glm::dvec3& lo,
                                 const glm::dvec3& hi) {
  Segment out{-1e30, 1e30};
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(direction[axis]) < 1e-12) {
      if (origin[axis] < lo[axis] || origin[axis] > hi[axis]) return std::nullopt;
      continue;
    }
    const double a = (lo[axis] - origin[axis]) / direction[axis];
    const double b = (hi[axis] - origin[axis]) / direction[axis];
    out.begin = std::max(out.begin, std::min(a, b));
    out.end = std::min(out.end, std::max(a, b));
  }
  return out.begin < out.end ? std::optional(out) : std::nullopt;
}

// Optical depth of a ray for extinction `tau_per_value`; spacing is 1, so index space is the world.
using ClosedForm = std::function<double(const Ray&)>;

struct Agreement {
  double mean_error = 0, rms = 0;
  int pixels = 0;
};

// shape: kPixels² values, row 0 at the top.
std::vector<double> closedFormImage(const View& view, const ClosedForm& value_length) {
  std::vector<double> out;
  for (int y = 0; y < kPixels; ++y) {
    for (int x = 0; x < kPixels; ++x) out.push_back(value_length(rayThrough(view, {x + 0.5, y + 0.5})));
  }
  return out;
}

Agreement compareDepths(const Image& image, const std::vector<double>& expected, double tau_per_value, int margin) {
  double sum_expected = 0, sum_found = 0, squares = 0;
  Agreement out;
  for (int y = margin; y < image.height - margin; ++y) {
    for (int x = margin; x < image.width - margin; ++x) {
      bool inside = true;
      for (int dy = -margin; dy <= margin; ++dy) {
        for (int dx = -margin; dx <= margin; ++dx)
          inside = inside && expected[static_cast<std::size_t>((y + dy) * image.width + x + dx)] > 0;
      }
      if (!inside) continue;
      const double want = tau_per_value * expected[static_cast<std::size_t>(y * image.width + x)];
      const double found = -std::log1p(-static_cast<double>(image.pixel(x, y)[3]));
      sum_expected += want;
      sum_found += found;
      squares += (found - want) * (found - want);
      ++out.pixels;
    }
  }
  out.mean_error = sum_found / sum_expected - 1;
  out.rms = std::sqrt(squares / out.pixels) / (sum_expected / out.pixels);
  return out;
}

struct Shape {
  const char* name;
  DenseVolume volume;
  double largest_value;
  ClosedForm value_length;  // ∫ value ds
};

std::vector<Shape> shapes() {
  const VolumeShape cube{{kSide, kSide, kSide}, VoxelType::f32};
  const glm::dvec3 lo(-0.5), hi(kSide - 0.5);
  std::vector<Shape> out;
  out.push_back({"slab", slab(cube, 2, 20, 40, 100), 100, [=](const Ray& ray) {
                   const auto s = insideBox(ray.origin, ray.direction, {lo.x, lo.y, 19.5}, {hi.x, hi.y, 39.5});
                   return s ? 100 * (s->end - s->begin) : 0.0;
                 }});
  const glm::dvec3 centre(31.3, 31.8, 31.5);
  const double radius = 26;
  out.push_back({"ball", ball(cube, centre, radius, 100), 100, [=](const Ray& ray) {
                   const glm::dvec3 to = centre - ray.origin;
                   const double along = glm::dot(to, ray.direction);
                   const double d2 = glm::dot(to, to) - along * along;
                   return d2 < radius * radius ? 100 * 2 * std::sqrt(radius * radius - d2) : 0.0;
                 }});
  out.push_back({"ramp", ramp(cube, 10, 1.5), 10 + 1.5 * kSide, [=](const Ray& ray) {
                   const auto s = insideBox(ray.origin, ray.direction, lo, hi);
                   if (!s) return 0.0;
                   const double middle = ray.origin.x + ray.direction.x * (s->begin + s->end) / 2;
                   return (10 + 1.5 * middle) * (s->end - s->begin);
                 }});
  return out;
}

class Extinction : public ::testing::TestWithParam<std::tuple<int, Projection, Lattice>> {};

TEST_P(Extinction, HasItsClosedForm) {
  const auto [shape_index, projection, lattice] = GetParam();
  const Shape shape = std::move(shapes()[static_cast<std::size_t>(shape_index)]);
  const auto store =
      makeStore(shape.volume,
                std::string("extinction_") + shape.name + (projection == Projection::kPerspective ? "_p" : "_o"), 32);
  const StoreReader reader(store);
  BrickCache cache(reader, 1ull << 30);
  double worst_mean = 0, worst_rms = 0;
  for (int i = 0; i < kViews; ++i) {
    FrameRequest request;
    request.opacity_threshold = 1;
    request.shading.phong = false;
    request.level = 0;
    setLattice(request, lattice);
    request.filters_rays = false;  // the closed form holds for single rays and has a kink where the exit face changes
    const Camera camera =
        cameraFrom(shape.volume.geometry, randomDirection(kSeed, static_cast<std::uint64_t>(i)), projection);
    request.view = resolve(camera, {kPixels, kPixels});
    const std::vector<double> value_length = closedFormImage(request.view, shape.value_length);
    for (const double depth : {0.1, 1.0, 4.0}) {
      const double tau_per_value = depth / *std::max_element(value_length.begin(), value_length.end());
      request.transfer_function = linearExtinction(shape.largest_value, tau_per_value);
      // In every other view, a point beyond all values: an opaque function selects the sample distance of solids.
      if (i % 2 == 0) request.transfer_function.points.push_back({2 * shape.largest_value, glm::dvec3(1), 0.99});
      Progress silent;
      FrameStatistics statistics;
      const Image image = renderFrame(cache, request, silent, statistics);
      const Agreement agreement = compareDepths(image, value_length, tau_per_value, kMargin);
      EXPECT_GT(agreement.pixels, 500);
      EXPECT_LT(std::abs(agreement.mean_error), 0.005)
          << shape.name << " depth " << depth << " seed " << kSeed << " view " << i;
      EXPECT_LT(agreement.rms, 0.01) << shape.name << " depth " << depth << " seed " << kSeed << " view " << i;
      worst_mean = std::max(worst_mean, std::abs(agreement.mean_error));
      worst_rms = std::max(worst_rms, agreement.rms);
    }
  }
  std::printf("%s, %s lattice, %s: worst of %d views and 3 functions: mean %.3f %%, rms %.3f %%\n", shape.name,
              nameOf(lattice), projection == Projection::kPerspective ? "perspective" : "orthographic", kViews,
              100 * worst_mean, 100 * worst_rms);
}

TEST_P(Extinction, IsTheSameOnCoarserLevels) {
  const auto [shape_index, projection, lattice] = GetParam();
  const Shape shape = std::move(shapes()[static_cast<std::size_t>(shape_index)]);
  const auto store = makeStore(shape.volume, "levels", 16);
  const StoreReader reader(store);
  ASSERT_EQ(reader.index().levels(), 3);
  BrickCache cache(reader, 1ull << 30);
  for (int level = 0; level < 3; ++level) {
    double worst_mean = 0, worst_rms = 0;
    for (std::uint64_t i = 0; i < 4; ++i) {
      FrameRequest request;
      request.opacity_threshold = 1;
      request.shading.phong = false;
      request.level = level;
      setLattice(request, lattice);
      request.view =
          resolve(cameraFrom(shape.volume.geometry, randomDirection(kSeed, i), projection), {kPixels, kPixels});
      const std::vector<double> value_length = closedFormImage(request.view, shape.value_length);
      const double tau_per_value = 1 / *std::max_element(value_length.begin(), value_length.end());
      request.transfer_function = linearExtinction(shape.largest_value, tau_per_value);
      Progress silent;
      FrameStatistics statistics;
      const Image image = renderFrame(cache, request, silent, statistics);
      const Agreement agreement = compareDepths(image, value_length, tau_per_value, kMargin << level);
      EXPECT_GT(agreement.pixels, 100) << "level " << level << " view " << i;
      worst_mean = std::max(worst_mean, std::abs(agreement.mean_error));
      worst_rms = std::max(worst_rms, agreement.rms);
    }
    std::printf("%s, %s lattice, %s, level %d: worst of 4 views: mean %.3f %%, rms %.3f %%\n", shape.name,
                nameOf(lattice), projection == Projection::kPerspective ? "perspective" : "orthographic", level,
                100 * worst_mean, 100 * worst_rms);
    // A voxel of level 2 is 4 pixels wide, and the ball 13 such voxels: blur lowers the mean by a hundredth.
    EXPECT_LT(worst_mean, level < 2 ? 0.005 : 0.012) << shape.name << " level " << level;
    EXPECT_LT(worst_rms, level < 2 ? 0.01 : 0.015) << shape.name << " level " << level;
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, Extinction,
                         ::testing::Combine(::testing::Values(0, 1, 2),
                                            ::testing::Values(Projection::kOrthographic, Projection::kPerspective),
                                            ::testing::ValuesIn(kLattices)));

}  // namespace
}  // namespace kiln::test
