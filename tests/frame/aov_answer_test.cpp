// Depth and normal planes against closed forms. Known, for three scenes:
// 1. A solid ball: a ray meets the surface at a root of a quadratic equation.
// 2. A uniform medium: light falls exponentially from the point where a ray enters.
// 3. A cut through the medium: the normal is the plane's normal.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <limits>
#include <optional>

#include "support/reference/drawing.h"
#include "support/reference/lattices.h"
#include "support/reference/reference_renderer.h"
#include "support/volumes/procedural.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

constexpr int kAovMargin = 3;  // pixels left out beside a silhouette

struct Crossing {
  double begin, end;  // along the ray. unit: world
};
using Solid = std::function<std::optional<Crossing>(const Ray&)>;

Solid ballOf(const glm::dvec3& centre, double radius) {
  return [=](const Ray& ray) -> std::optional<Crossing> {
    const glm::dvec3 to = centre - ray.origin;
    const double along = glm::dot(to, ray.direction);
    const double half2 = radius * radius - glm::dot(to, to) + along * along;
    if (half2 <= 0) return std::nullopt;
    return Crossing{along - std::sqrt(half2), along + std::sqrt(half2)};
  };
}

Solid boxOf(const glm::dvec3& lo, const glm::dvec3& hi) {
  return [=](const Ray& ray) -> std::optional<Crossing> {
    Crossing out{-1e30, 1e30};
    for (int axis = 0; axis < 3; ++axis) {
      const double a = (lo[axis] - ray.origin[axis]) / ray.direction[axis];
      const double b = (hi[axis] - ray.origin[axis]) / ray.direction[axis];
      out.begin = std::max(out.begin, std::min(a, b));
      out.end = std::min(out.end, std::max(a, b));
    }
    return out.begin < out.end ? std::optional(out) : std::nullopt;
  };
}

struct Pixel {
  int x, y;
  Ray ray;
  Crossing crossing;
};

// The pixels that see the solid together with all neighbours. The solid is convex, so testing the farthest corners
// suffices.
std::vector<Pixel> pixelsWellInside(const View& view, const Solid& solid) {
  const auto crossingAt = [&](int x, int y) { return solid(rayThrough(view, {x + 0.5, y + 0.5})); };
  std::vector<Pixel> out;
  for (int y = kAovMargin; y < view.size.height - kAovMargin; ++y) {
    for (int x = kAovMargin; x < view.size.width - kAovMargin; ++x) {
      bool inside = true;
      for (const int dy : {-kAovMargin, kAovMargin}) {
        for (const int dx : {-kAovMargin, kAovMargin}) inside = inside && crossingAt(x + dx, y + dy).has_value();
      }
      if (inside) out.push_back({x, y, rayThrough(view, {x + 0.5, y + 0.5}), *crossingAt(x, y)});
    }
  }
  return out;
}

struct Planes {
  const Image& image;
  float at(const char* name, const Pixel& pixel) const {
    for (const Plane& plane : image.planes)
      if (plane.name == name) return plane.values[static_cast<std::size_t>(pixel.y * image.width + pixel.x)];
    ADD_FAILURE() << "no plane " << name;
    return 0;
  }
  glm::dvec3 normalAt(const Pixel& pixel) const { return {at("N.X", pixel), at("N.Y", pixel), at("N.Z", pixel)}; }
};

// Errors against the known depth, accumulated over all pixels. unit: pixels.
struct Departure {
  double worst = 0, sum = 0, squares = 0;
  int count = 0;
  void add(double d) {
    worst = std::max(worst, std::abs(d));
    sum += d;
    squares += d * d;
    ++count;
  }
  double mean() const { return sum / count; }
  double rms() const { return std::sqrt(squares / count); }
};

// Errors of the depth and normal planes in a picture of a ball.
struct BallDeparture {
  Departure first, mean;     // errors of Z and depth.mean
  double largest_angle = 0;  // largest error of a normal. unit: degrees
};

// Light goes some hundredths of a voxel deep.
const TransferFunction kSolidAboveZero{0.1, {{0, glm::dvec3(1), 0}, {0, glm::dvec3(1), 1}}};

class AovValues : public ::testing::TestWithParam<std::tuple<Projection, Lattice>> {
 protected:
  AovValues() {
    request_.aovs = {true, true};
    request_.lattice = std::get<1>(GetParam());
    request_.level = 0;
  }
  void look(const DenseVolume& volume, const glm::dvec3& from, int pixels) {
    request_.view = resolve(cameraFrom(volume.geometry, from, std::get<0>(GetParam())), {pixels, pixels});
  }
  double depthOf(const glm::dvec3& world) const { return (request_.view.view_from_world * glm::dvec4(world, 1)).z; }
  double depthOf(const Pixel& pixel, double along) const {
    return depthOf(pixel.ray.origin + along * pixel.ray.direction);
  }
  // Returns the width of a pixel at a depth. unit: world.
  double pixelAt(double depth) const {
    return (request_.view.projection == Projection::kPerspective ? depth : 1) / request_.view.focal_px;
  }
  bool voxels() const { return request_.lattice == Lattice::kVoxel; }
  BallDeparture departureFromBall(const Image& image, const glm::dvec3& centre, double radius) const {
    const Planes planes{image};
    BallDeparture off;
    for (const Pixel& pixel : pixelsWellInside(request_.view, ballOf(centre, radius))) {
      const double depth = depthOf(pixel, pixel.crossing.begin);
      off.first.add((planes.at("Z", pixel) - depth) / pixelAt(depth));
      off.mean.add((planes.at("depth.mean", pixel) - depth) / pixelAt(depth));
      const glm::dvec3 normal = glm::normalize(pixel.ray.origin + pixel.crossing.begin * pixel.ray.direction - centre);
      const glm::dvec3 found = planes.normalAt(pixel);
      EXPECT_NEAR(glm::length(found), 1, 1e-5);
      off.largest_angle = std::max(off.largest_angle, glm::degrees(std::acos(std::min(1.0, glm::dot(found, normal)))));
    }
    std::printf("%s of %d pixels: Z %.3f px in the mean, rms %.3f, worst %.3f; depth.mean %.3f; normal %.2f degrees\n",
                nameOf(request_.lattice), image.width, off.first.mean(), off.first.rms(), off.first.worst,
                off.mean.mean(), off.largest_angle);
    return off;
  }
  FrameRequest request_;
};

TEST_P(AovValues, OfASolidBallAreItsSurface) {
  const glm::dvec3 centre(20.3, 19.8, 20.1);
  const double radius = 16;
  const DenseVolume volume = fill({{41, 40, 42}, VoxelType::f32}, [&](auto i, auto j, auto k) {
    return radius - glm::length(glm::dvec3(i, j, k) - centre);
  });
  const auto store = makeStore(volume, "ball", 16);
  request_.transfer_function = kSolidAboveZero;
  for (const int size : {70, 108, 120}) {
    look(volume, {0.4, -0.8, 0.3}, size);
    const BallDeparture off = departureFromBall(draw(store, request_), centre, radius);
    EXPECT_GT(off.first.count, 300);
    // On the voxel lattice, footprints are as large as a voxel: one or two pixels.
    EXPECT_LT(std::abs(off.first.mean()), voxels() ? 0.7 : 0.1);
    // A sample on a ray is up to half a slab before or behind a surface.
    EXPECT_LT(off.first.rms(), voxels() ? 1.6 : 0.3);
    EXPECT_LT(off.first.worst, voxels() ? 6 : 0.75);
    EXPECT_LT(std::abs(off.mean.mean()), voxels() ? 0.7 : 0.33);
    EXPECT_LT(off.largest_angle, voxels() ? 10 : 3);
  }
}

TEST_P(AovValues, OfAMediumFollowFromItsExtinction) {
  const DenseVolume volume = fill({{32, 30, 34}, VoxelType::u8}, [](auto, auto, auto) { return 100; });
  const auto store = makeStore(volume, "medium", 16);
  const Solid solid = boxOf(glm::dvec3(-0.5), {31.5, 29.5, 33.5});
  request_.opacity_threshold = 1;
  look(volume, {0.5, -0.7, 0.3}, 55);
  const std::vector<Pixel> pixels = pixelsWellInside(request_.view, solid);
  EXPECT_GT(pixels.size(), 800u);
  for (const double tau : {0.02, 0.2}) {
    request_.transfer_function = {1, {{0, glm::dvec3(1), -std::expm1(-tau)}}};
    const Image image = draw(store, request_);
    const Planes planes{image};
    Departure first, mean;
    for (const Pixel& pixel : pixels) {
      const double length = pixel.crossing.end - pixel.crossing.begin;
      const double hit = std::log(2) / tau;
      const auto off = [&](const char* name, double along) {
        const double depth = depthOf(pixel, pixel.crossing.begin + along);
        return (planes.at(name, pixel) - depth) / pixelAt(depth);
      };
      mean.add(off("depth.mean", 1 / tau - length / std::expm1(tau * length)));
      if (hit < length - 1) first.add(off("Z", hit));
      if (hit > length + 1) {
        EXPECT_EQ(planes.at("Z", pixel), std::numeric_limits<float>::infinity());
      }
      // The medium has no gradient: normals are sums of the normals of faces, which are turned to the eye.
      for (int axis = 0; axis < 3; ++axis)
        EXPECT_GE(-pixel.ray.direction[axis] * planes.normalAt(pixel)[axis], -1e-4) << "a gradient of nothing";
    }
    std::printf("%s, extinction %g: %d of %zu pixels hit; Z %.3f px in the mean, rms %.3f; depth.mean %.3f, %.3f\n",
                nameOf(request_.lattice), tau, first.count, pixels.size(), first.mean(), first.rms(), mean.mean(),
                mean.rms());
    EXPECT_GT(first.count, 150);
    EXPECT_LT(std::abs(first.mean()), voxels() ? 0.15 : 0.05);
    EXPECT_LT(first.rms(), voxels() ? 2 : 0.2);
    EXPECT_LT(std::abs(mean.mean()), 0.05);
    EXPECT_LT(mean.rms(), voxels() ? 0.5 : 0.15);
  }
}

TEST_P(AovValues, OfACutHaveThePlanesNormal) {
  const DenseVolume volume = fill({{20, 20, 20}, VoxelType::u8}, [](auto, auto, auto) { return 100; });
  // points into the remaining half, away from the eye
  const glm::dvec3 normal = glm::normalize(glm::dvec3(-0.5, 0.6, -0.3));
  request_.clipping.planes = {{normal, -glm::dot(normal, glm::dvec3(9.5))}};
  request_.transfer_function = {1, {{0, glm::dvec3(1), 0.9}}};
  look(volume, {0.5, -0.7, 0.3}, 40);
  const Image image = draw(makeStore(volume, "cut", 16), request_);
  const Pixel centre{20, 20, {}, {}};
  EXPECT_LT(glm::length(Planes{image}.normalAt(centre) + normal), 1e-4);
  const Pixel corner{0, 0, {}, {}};
  EXPECT_EQ(Planes{image}.normalAt(corner), glm::dvec3(0));
  EXPECT_EQ(Planes{image}.at("Z", corner), std::numeric_limits<float>::infinity());
  EXPECT_EQ(Planes{image}.at("depth.mean", corner), std::numeric_limits<float>::infinity());
}

// Between voxels of the field R² - r², Catmull-Rom interpolation reproduces R² - r². The B-spline averages over a
// variance of 1/3 along each axis and yields R² - 1 - r². Both gradients point along the radius.
class AovValuesOfCubics : public AovValues {};

TEST_P(AovValuesOfCubics, AreTheSurfaceOfTheInterpolation) {
  const glm::dvec3 centre(15.3, 14.8, 15.1);
  const double radius2 = 144;
  const DenseVolume volume = fill({{31, 30, 32}, VoxelType::f32}, [&](auto i, auto j, auto k) {
    const glm::dvec3 r = glm::dvec3(i, j, k) - centre;
    return radius2 - glm::dot(r, r);
  });
  const auto store = makeStore(volume, "ball", 16);
  request_.transfer_function = kSolidAboveZero;
  // Magnifications from about one sample a voxel to several. The two surfaces are a sixth of a pixel apart or more.
  for (const int size : {40, 162, 180, 202}) {
    look(volume, {0.4, -0.8, 0.3}, size);
    for (const Interpolation interpolation : {Interpolation::kCubic, Interpolation::kCatmullRom}) {
      request_.interpolation = interpolation;
      const bool averages = interpolation == Interpolation::kCubic;
      const BallDeparture off = departureFromBall(draw(store, request_), centre, std::sqrt(radius2 - averages));
      EXPECT_GT(off.first.count, 30);
      EXPECT_LT(std::abs(off.first.mean()), 0.1);
      // A sample is up to half a slab before or behind the surface. A uniform distribution over a pixel has a standard
      // deviation of 0.289.
      EXPECT_LT(off.first.rms(), 0.3);
      EXPECT_LT(off.first.worst, 1);
      EXPECT_LT(std::abs(off.mean.mean()), 0.33);
      EXPECT_LT(off.largest_angle, size == 40 ? 5 : 2);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Views, AovValuesOfCubics,
                         ::testing::Combine(::testing::Values(Projection::kOrthographic, Projection::kPerspective),
                                            ::testing::Values(Lattice::kPixel)));
INSTANTIATE_TEST_SUITE_P(Views, AovValues,
                         ::testing::Combine(::testing::Values(Projection::kOrthographic, Projection::kPerspective),
                                            ::testing::ValuesIn(kLattices)));

}  // namespace
}  // namespace kiln::test
