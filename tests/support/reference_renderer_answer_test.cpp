// The reference renderer against closed forms. A slab, a ball, a ramp and a constant medium absorb as their analytic
// integrals; a planar ramp has a single normal; a mirrored volume gives a mirrored picture. Expected lengths come from
// plane distances in world space, not from the renderer's index space.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <numeric>

#include "support/reference/reference_renderer.h"
#include "support/volumes/random_scene.h"

namespace kiln::test {
namespace {

constexpr Projection kBothProjections[] = {Projection::kPerspective, Projection::kOrthographic};
const glm::dvec3 kRed(0.8, 0.3, 0.1);

glm::dvec3 middleOf(const VolumeGeometry& volume) {
  return volume.worldOf(0.5 * glm::dvec3(volume.dims.x, volume.dims.y, volume.dims.z) - 0.5);
}

/// Looks at the volume's centre along `forward`; the picture is `height` world units high at the centre's distance.
View viewAlong(Projection projection, const VolumeGeometry& volume, const glm::dvec3& forward, double height,
               const ImageSize& size, const glm::dvec3& up = {0.1, 0.9, 0.2}) {
  const double distance = 3 * height;
  Camera camera;
  camera.projection = projection;
  camera.target = middleOf(volume);
  camera.eye = camera.target - distance * glm::normalize(forward);
  camera.up = up;
  camera.fov_deg = 2 * std::atan(0.5 * height / distance) * 180 / 3.141592653589793;
  camera.height = height;
  return resolve(camera, size);
}

/// Returns a step function: `opacity` from half of `value` on, 0 below.
TransferFunction stepAtHalf(double value, double opacity, double unit = 0) {
  return {unit, {{value / 2, kRed, 0}, {value / 2, kRed, opacity}}};
}

TransferFunction everywhere(double opacity, double unit = 0) { return {unit, {{0, kRed, opacity}}}; }

ReferenceSettings oneRay(double step_voxels = 0.1) { return {1, step_voxels, 1}; }

/// World normal of the planes where index coordinate `axis` is constant; its length is 1 / (distance of the planes).
glm::dvec3 planeNormal(const VolumeGeometry& volume, int axis) {
  glm::dvec3 one(0);
  one[axis] = 1;
  return glm::transpose(glm::inverse(glm::dmat3(volume.world_from_index))) * one;
}

/// Returns the length of the ray between two index planes of `axis` that are `planes` apart.
double lengthBetween(const VolumeGeometry& volume, const Ray& ray, int axis, double planes) {
  return planes / std::abs(glm::dot(planeNormal(volume, axis), ray.direction));
}

bool inBox(const VolumeGeometry& volume, const glm::dvec3& world) {
  const glm::dvec3 index = glm::dvec3(glm::inverse(volume.world_from_index) * glm::dvec4(world, 1));
  for (int axis = 0; axis < 3; ++axis) {
    if (index[axis] < -0.5 - 1e-9 || index[axis] > static_cast<double>(volume.dims[axis]) - 0.5 + 1e-9) return false;
  }
  return true;
}

/// Returns true if the ray crosses the volume from face to face of `axis`, not through its sides.
bool crossesFaces(const VolumeGeometry& volume, const Ray& ray, int axis) {
  const glm::dvec3 normal = planeNormal(volume, axis);
  for (const double plane : {-0.5, static_cast<double>(volume.dims[axis]) - 0.5}) {
    glm::dvec3 index(0);
    index[axis] = plane;
    const double distance = glm::dot(normal, volume.worldOf(index) - ray.origin) / glm::dot(normal, ray.direction);
    if (!inBox(volume, ray.origin + distance * ray.direction)) return false;
  }
  return true;
}

std::size_t placeOf(const View& view, int column, int row) {
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(view.size.width) + static_cast<std::size_t>(column);
}

/// Calls check(column, row, ray through the pixel's centre).
template <class Check>
void forPixels(const View& view, const Check& check) {
  for (int row = 0; row < view.size.height; ++row) {
    for (int column = 0; column < view.size.width; ++column) {
      check(column, row, rayThrough(view, {column + 0.5, row + 0.5}));
    }
  }
}

double sum(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

// Known from the definition of View: a point of a ray projects to the pixel of the ray.
TEST(ReferenceRenderer, RayProjectsToItsPixel) {
  VolumeGeometry volume;
  volume.dims = {20, 30, 40};
  volume.world_from_index = obliqueAffine();
  for (const Projection projection : kBothProjections) {
    const View view = viewAlong(projection, volume, {1, -2, 0.7}, 30, {40, 30});
    for (const glm::dvec2 pixel : {glm::dvec2(0.5, 0.5), glm::dvec2(20, 15), glm::dvec2(39.1, 3.7)}) {
      const Ray ray = rayThrough(view, pixel);
      EXPECT_NEAR(glm::length(ray.direction), 1, 1e-14);
      for (const double distance : {1.0, 77.0}) {
        const glm::dvec3 world = ray.origin + distance * ray.direction;
        const glm::dvec2 back = view.pixelOf(glm::dvec3(view.view_from_world * glm::dvec4(world, 1)));
        EXPECT_NEAR(glm::length(back - pixel), 0, 1e-10);
      }
    }
  }
}

// A constant medium fills the box. Along the lattice's z the optical depth is extinction times the box's exact length,
// including half a voxel beyond the outer voxel centres. The clipped last step makes the depth exact for any step.
TEST(ReferenceRenderer, ConstantBoxHasItsExactLength) {
  const DenseVolume volume = slab({{8, 9, 10}, VoxelType::u8, anisotropicAffine()}, 2, 0, 10, 200);
  const View view = viewAlong(Projection::kOrthographic, volume.geometry, {0, 0, 1}, 4, {6, 6}, {0, -1, 0});
  const double expected = extinctionOf(0.3, 1.5) * 10 * 2.1;
  for (const double step : {0.1, 0.37, 1.0}) {
    for (const double depth : opticalDepthImage(volume, view, everywhere(0.3, 1.5), oneRay(step)).depth) {
      EXPECT_NEAR(depth, expected, 1e-10 * expected);
    }
  }
}

// Unit 0 is the edge of the cube with the voxel's volume: 0.7 * 0.9 * 2.1 = 1.323.
TEST(ReferenceRenderer, UnitZeroIsTheMeanSpacing) {
  const DenseVolume volume = slab({{8, 9, 10}, VoxelType::u8, anisotropicAffine()}, 2, 0, 10, 200);
  const View view = viewAlong(Projection::kOrthographic, volume.geometry, {0, 0, 1}, 4, {2, 2}, {0, -1, 0});
  const double expected = -std::log(1 - 0.3) / std::cbrt(1.323) * 10 * 2.1;
  EXPECT_NEAR(opticalDepthImage(volume, view, everywhere(0.3)).depth[0], expected, 1e-10);
}

// Trilinear interpolation crosses half the slab's value exactly at lo - 1/2 and hi - 1/2. Under a step function there
// the depth is extinction * thickness / |cos|. A midpoint step is off by at most half a step at each of the two planes
// (here 0.005 of 16 voxels each).
TEST(ReferenceRenderer, SlabSeenObliquely) {
  for (const VoxelType type : {VoxelType::u8, VoxelType::i16, VoxelType::f32, VoxelType::f64}) {
    const DenseVolume volume = slab({{40, 40, 24}, type, obliqueAffine()}, 2, 4, 20, 100);
    const glm::dvec3 forward = glm::normalize(planeNormal(volume.geometry, 2)) + glm::dvec3(0.3, -0.2, 0.1);
    for (const Projection projection : kBothProjections) {
      const View view = viewAlong(projection, volume.geometry, forward, 8, {8, 6});
      const OpticalDepthImage image = opticalDepthImage(volume, view, stepAtHalf(100, 0.1, 2), oneRay(0.01));
      forPixels(view, [&](int column, int row, const Ray& ray) {
        ASSERT_TRUE(crossesFaces(volume.geometry, ray, 2));
        const double expected = extinctionOf(0.1, 2) * lengthBetween(volume.geometry, ray, 2, 16);
        EXPECT_NEAR(image.depth[placeOf(view, column, row)] / expected, 1, 0.001);
        EXPECT_NEAR(image.transmittance[placeOf(view, column, row)], std::exp(-expected), 0.001);
      });
    }
  }
}

// A slab at the default step. In a single view all rays may meet a plane at an equal phase of their steps; over many
// views phases vary, so the mean has no error.
TEST(ReferenceRenderer, SlabHasNoBiasAtTheDefaultStep) {
  const DenseVolume volume = slab({{40, 40, 24}, VoxelType::f32, obliqueAffine()}, 2, 4, 20, 1);
  Random random(1);
  double ratio = 0;
  int pixels = 0;
  for (int i = 0; i < 40; ++i) {
    const glm::dvec3 forward = glm::normalize(planeNormal(volume.geometry, 2)) + 0.3 * random.direction();
    const View view = viewAlong(kBothProjections[i % 2], volume.geometry, forward, 6, {6, 4});
    const OpticalDepthImage image = opticalDepthImage(volume, view, stepAtHalf(1, 0.05), oneRay());
    forPixels(view, [&](int column, int row, const Ray& ray) {
      const double expected =
          extinctionOf(0.05, volume.geometry.meanSpacing()) * lengthBetween(volume.geometry, ray, 2, 16);
      ratio += image.depth[placeOf(view, column, row)] / expected;
      ++pixels;
    });
  }
  EXPECT_NEAR(ratio / pixels, 1, 0.001);
}

/// The length of the ray inside a sphere.
double chordOf(const Ray& ray, const glm::dvec3& centre, double radius) {
  const glm::dvec3 to_centre = centre - ray.origin;
  const double along = glm::dot(to_centre, ray.direction);
  const double reach = radius * radius - (glm::dot(to_centre, to_centre) - along * along);
  return reach > 0 ? 2 * std::sqrt(reach) : 0;
}

// The voxels of the ball sum to its volume, and interpolation keeps the sum. For a faint medium extinction is linear in
// the value (to 0.01 % at opacity 0.005). In any parallel view the depths therefore sum to extinction * (4/3)πr³ /
// pixel area.
TEST(ReferenceRenderer, FaintBallAbsorbsItsVolume) {
  const double radius = 12;
  const DenseVolume volume = ball({{31, 31, 31}, VoxelType::f32}, {15.2, 14.9, 15.3}, radius, 1);
  const double ball_volume = 4.0 / 3 * 3.141592653589793 * radius * radius * radius;
  double voxels = 0;
  for (std::int64_t i = 0; i < 31 * 31 * 31; ++i) voxels += volume.valueAt(i % 31, i / 31 % 31, i / 31 / 31);
  EXPECT_NEAR(voxels / ball_volume, 1, 2e-4);

  const TransferFunction faint{1, {{0, kRed, 0}, {1, kRed, 0.005}}};
  for (const glm::dvec3 forward : {glm::dvec3(0, 0, 1), glm::dvec3(1, 0.4, -0.6), glm::dvec3(-0.3, 0.2, 0.5)}) {
    const View view = viewAlong(Projection::kOrthographic, volume.geometry, forward, 32, {40, 40});
    const double pixel_area = 0.8 * 0.8;
    const double expected = extinctionOf(0.005, 1) * ball_volume / pixel_area;
    EXPECT_NEAR(sum(opticalDepthImage(volume, view, faint).depth) / expected, 1, 0.001);
  }
}

// With a step function at half the value, a ball is a medium with the chord's length in each ray. Box and tent filters
// move the half-value surface inwards by about 1/(4r) voxel (variance 1/4 times the mean curvature): 0.14 % of the
// depth here.
TEST(ReferenceRenderer, BallHasTheChordsDepth) {
  const double radius = 23;
  const glm::dvec3 centre(26.3, 26.1, 25.8);
  const DenseVolume volume = ball({{53, 53, 53}, VoxelType::f32}, centre, radius, 1);
  for (const Projection projection : kBothProjections) {
    const View view = viewAlong(projection, volume.geometry, {1, 0.4, -0.6}, 60, {40, 40});
    const OpticalDepthImage image = opticalDepthImage(volume, view, stepAtHalf(1, 0.05, 1), oneRay());
    const double extinction = extinctionOf(0.05, 1);
    std::vector<double> depth, difference;
    forPixels(view, [&](int column, int row, const Ray& ray) {
      const double expected = extinction * chordOf(ray, centre, radius - 1 / (4 * radius));
      depth.push_back(expected);
      difference.push_back(image.transmittance[placeOf(view, column, row)] - std::exp(-expected));
      // A single ray is off by up to 0.3 voxel of its chord of 23 to 46. Measured: 0.25 voxel remains at a step of
      // 0.02, so the error comes from the sampled half-value surface, not from the step. The means below are free of
      // this error.
      if (expected > extinction * radius) {
        EXPECT_NEAR(image.depth[placeOf(view, column, row)] / expected, 1, 0.02);
      }
    });
    EXPECT_NEAR(sum(image.depth) / sum(depth), 1, 0.001);
    EXPECT_NEAR(sum(difference) / static_cast<double>(difference.size()), 0, 0.0005);
  }
}

// Opacity a·x/(N-1) along x: ∫ -ln(1 - a t) dt over [0,1] is ((1-a) ln(1-a) + a) / a; beyond the outer voxel centres
// the value is clamped, so half a voxel of the last opacity is added (and half a voxel of none).
TEST(ReferenceRenderer, RampHasItsIntegral) {
  const double a = 0.8;
  for (const glm::dmat4& affine : {glm::dmat4(1.0), anisotropicAffine(), obliqueAffine()}) {
    const DenseVolume volume = ramp({{25, 40, 40}, VoxelType::i16, affine}, -100, 7);
    const TransferFunction function{3, {{-100, kRed, 0}, {-100 + 7 * 24, kRed, a}}};
    const glm::dvec3 forward = glm::normalize(planeNormal(volume.geometry, 0)) + glm::dvec3(0.2, 0.25, -0.1);
    for (const Projection projection : kBothProjections) {
      const View view = viewAlong(projection, volume.geometry, forward, 8, {8, 6});
      const OpticalDepthImage image = opticalDepthImage(volume, view, function, oneRay());
      forPixels(view, [&](int column, int row, const Ray& ray) {
        ASSERT_TRUE(crossesFaces(volume.geometry, ray, 0));
        const double voxel = lengthBetween(volume.geometry, ray, 0, 1);
        const double expected = voxel / 3 * (24 * ((1 - a) * std::log(1 - a) + a) / a - 0.5 * std::log(1 - a));
        EXPECT_NEAR(image.depth[placeOf(view, column, row)] / expected, 1, 1e-3);
      });
    }
  }
}

// A ray that starts inside a constant medium has transmittance exp(-τ d), with d the distance to the box's surface,
// found here by bisection.
TEST(ReferenceRenderer, EyeInsideAConstantMedium) {
  const DenseVolume volume = slab({{20, 24, 28}, VoxelType::u16, obliqueAffine()}, 0, 0, 20, 1000);
  Camera camera;
  camera.eye = volume.geometry.worldOf({4.2, 9, 15});
  camera.target = volume.geometry.worldOf({15, 20, 5});
  camera.fov_deg = 110;
  const View view = resolve(camera, {24, 18});
  const OpticalDepthImage image = opticalDepthImage(volume, view, everywhere(0.04, 1), oneRay());
  forPixels(view, [&](int column, int row, const Ray& ray) {
    double inside = 0, outside = 1000;
    for (int i = 0; i < 80; ++i) {
      const double middle = (inside + outside) / 2;
      (inBox(volume.geometry, camera.eye + middle * ray.direction) ? inside : outside) = middle;
    }
    EXPECT_NEAR(image.transmittance[placeOf(view, column, row)], std::exp(-extinctionOf(0.04, 1) * inside), 1e-8);
  });
}

// A planar ramp has a constant gradient, perpendicular to its planes in world space. Every sample of a ray has an equal
// colour, given by one evaluation of the shading formula (tools/kiln/manual/render.md). The function shows planes
// within the volume, and rays that meet them away from the border, whose normals are those of its faces.
TEST(ReferenceRenderer, PlanarRampIsShadedByTheFormula) {
  const DenseVolume volume = ramp({{20, 40, 40}, VoxelType::f32, obliqueAffine()}, 0, 1);
  const TransferFunction planes{1, {{2, kRed, 0}, {2.01, kRed, 0.5}, {17, kRed, 0.5}, {17.01, kRed, 0}}};
  const glm::dmat4 index_from_world = glm::inverse(volume.geometry.world_from_index);
  const auto staysInside = [&](const Ray& ray) {
    const auto origin = glm::dvec3(index_from_world * glm::dvec4(ray.origin, 1));
    const auto step = glm::dvec3(index_from_world * glm::dvec4(ray.direction, 0));
    for (const double x : {2.0, 17.01}) {
      const glm::dvec3 at = origin + (x - origin.x) / step.x * step;
      if (!(std::min(at.y, at.z) > 1 && std::max(at.y, at.z) < 38)) return false;
    }
    return true;
  };
  const glm::dvec3 normal = glm::normalize(planeNormal(volume.geometry, 0));
  const Shading shading{true, 0.15, 0.7, 0.3, 12};
  for (const Projection projection : kBothProjections) {
    for (const glm::dvec3& forward : {glm::dvec3(1, 0.5, 0.2), glm::dvec3(-1, 0.5, 0.2)}) {
      const View view = viewAlong(projection, volume.geometry, forward, 24, {12, 9});
      const Image image = referenceImage(volume, view, planes, shading, {}, oneRay());
      int seen = 0;
      forPixels(view, [&](int column, int row, const Ray& ray) {
        const float* rgba = image.pixel(column, row);
        if (rgba[3] < 0.5f || !staysInside(ray)) return;
        ++seen;
        const double facing = std::abs(glm::dot(normal, ray.direction));
        const glm::dvec3 expected = kRed * (0.15 + 0.7 * facing) + 0.3 * std::pow(facing, 12);
        for (int channel = 0; channel < 3; ++channel) {
          EXPECT_NEAR(rgba[channel] / rgba[3], expected[channel], 1e-6);
        }
      });
      EXPECT_GT(seen, 30);
    }
  }
}

// A constant region has no normal: the transfer function's colour stays unshaded for every shading. A slope below
// kGradientNoise of the range per voxel counts as constant, a larger slope does not. The eye is inside the volume, and
// the first voxels hide the border behind them.
TEST(ReferenceRenderer, GradientBelowNoiseIsUnshaded) {
  const Shading dark{true, 0.1, 0.1, 0, 1};
  const auto colorOf = [&](double slope, double outlier) {
    DenseVolume volume = ramp({{16, 16, 16}, VoxelType::f64}, 0, slope);
    volume.set(0, 0, 0, outlier);  // gives the volume its range, out of the ray's sight
    Camera camera;
    camera.eye = volume.geometry.worldOf({2, 8, 8});
    camera.target = volume.geometry.worldOf({15, 8, 8});
    camera.fov_deg = 10;
    const View view = resolve(camera, {1, 1});
    const Image image = referenceImage(volume, view, everywhere(0.9), dark, {}, oneRay());
    return image.pixel(0, 0)[0] / image.pixel(0, 0)[3];
  };
  EXPECT_NEAR(colorOf(0, 0), kRed.r, 1e-6);
  EXPECT_NEAR(colorOf(0.5 * kGradientNoise, 1), kRed.r, 1e-6);
  EXPECT_NEAR(colorOf(4 * kGradientNoise, 1), 0.2 * kRed.r, 1e-6);
}

// Mirroring the volume in a plane through eye and target mirrors the picture: left becomes right, pixel for pixel.
// Mirroring both voxels and affine changes nothing.
TEST(ReferenceRenderer, AMirroredVolumeIsAMirroredPicture) {
  const Extent3 dims{18, 20, 22};
  const DenseVolume volume = cheese({dims, VoxelType::f32}, 7, {0, 1});
  DenseVolume mirrored = volume;
  mirrored.geometry.world_from_index = mirroredAffine(volume.geometry.world_from_index, 0, dims);
  const DenseVolume twice =
      fill({dims, VoxelType::f32, mirrored.geometry.world_from_index},
           [&](std::int64_t i, std::int64_t j, std::int64_t k) { return volume.valueAt(dims.x - 1 - i, j, k); });
  const TransferFunction smooth{0, {{0.2, {0.2, 0.4, 1}, 0}, {0.9, kRed, 0.6}}};
  const ReferenceSettings settings{2, 0.25, 1};
  for (const Projection projection : kBothProjections) {
    const View view = viewAlong(projection, volume.geometry, {0, 1, 0}, 26, {20, 20}, {0, 0, 1});
    const Image a = referenceImage(volume, view, smooth, {}, {}, settings);
    const Image b = referenceImage(mirrored, view, smooth, {}, {}, settings);
    const Image c = referenceImage(twice, view, smooth, {}, {}, settings);
    double difference_unmirrored = 0;
    forPixels(view, [&](int column, int row, const Ray&) {
      for (int channel = 0; channel < 4; ++channel) {
        const float expected = a.pixel(column, row)[channel];
        EXPECT_NEAR(b.pixel(19 - column, row)[channel], expected, 1e-5);
        EXPECT_NEAR(c.pixel(column, row)[channel], expected, 1e-5);
        difference_unmirrored =
            std::max(difference_unmirrored, std::abs(double(b.pixel(column, row)[channel]) - expected));
      }
    });
    EXPECT_GT(difference_unmirrored, 0.05) << "the volume is symmetric, so that the test says nothing";
  }
}

// A NaN voxel has weight within a voxel length on both sides. A ray a quarter of a voxel beside its centre loses
// exactly this length, and a ray whose eight neighbours exclude the NaN loses nothing.
TEST(ReferenceRenderer, NanIsTransparentWhereItHasWeight) {
  DenseVolume volume = slab({{9, 9, 9}, VoxelType::f32}, 2, 0, 9, 1);
  volume.set(4, 4, 4, std::numeric_limits<double>::quiet_NaN());
  View view = viewAlong(Projection::kOrthographic, volume.geometry, {0, 0, 1}, 9, {9, 9}, {0, -1, 0});
  view.centre_px -= 0.25;  // the rays of column c and row r run through index (c + 1/4, r + 1/4)
  const double extinction = extinctionOf(0.1, 1);
  const OpticalDepthImage image = opticalDepthImage(volume, view, everywhere(0.1, 1), oneRay());
  forPixels(view, [&](int column, int row, const Ray&) {
    const bool near = (column == 3 || column == 4) && (row == 3 || row == 4);
    EXPECT_NEAR(image.depth[placeOf(view, column, row)], extinction * (near ? 7 : 9), 1e-9) << column << " " << row;
  });
}

// Over: a medium of transmittance T adds T times a premultiplied background.
TEST(ReferenceRenderer, BackgroundShinesThrough) {
  const DenseVolume volume = slab({{8, 8, 8}, VoxelType::u8}, 0, 0, 8, 1);
  const View view = viewAlong(Projection::kOrthographic, volume.geometry, {0, 0, 1}, 16, {2, 2}, {0, -1, 0});
  const View close = viewAlong(Projection::kOrthographic, volume.geometry, {0, 0, 1}, 2, {1, 1}, {0, -1, 0});
  const std::array<double, 4> background{0.1, 0.2, 0.3, 0.5};
  const Shading none{false, 0, 0, 0, 1};
  const Image empty = referenceImage(volume, view, everywhere(0), none, background);
  const Image filled = referenceImage(volume, close, everywhere(0.2, 1), none, background);
  const double transmittance = std::pow(0.8, 8);
  for (int channel = 0; channel < 4; ++channel) {
    const auto c = static_cast<std::size_t>(channel);
    EXPECT_FLOAT_EQ(empty.pixel(1, 1)[channel], static_cast<float>(background[c]));
    const double own = channel < 3 ? kRed[channel] : 1;
    EXPECT_NEAR(filled.pixel(0, 0)[channel], (1 - transmittance) * own + transmittance * background[c], 1e-6);
  }
}

// A ray that reaches the threshold is divided by its alpha and ends, so in a medium of one colour it has exactly this
// colour. A ray below the threshold (here 0.8^8 of the light passes) is unchanged.
TEST(ReferenceRenderer, ThresholdDividesAndCloses) {
  const DenseVolume volume = slab({{8, 8, 8}, VoxelType::u8}, 0, 0, 8, 1);
  const View view = viewAlong(Projection::kOrthographic, volume.geometry, {0, 0, 1}, 2, {1, 1}, {0, -1, 0});
  const Shading none{false, 0, 0, 0, 1};
  const double alpha = 1 - std::pow(0.8, 8);
  const Image closed = referenceImage(volume, view, everywhere(0.2, 1), none, {}, {1, 0.1, alpha - 0.01});
  const Image open = referenceImage(volume, view, everywhere(0.2, 1), none, {}, {1, 0.1, alpha + 0.01});
  EXPECT_EQ(closed.pixel(0, 0)[3], 1.0f);
  EXPECT_NEAR(open.pixel(0, 0)[3], alpha, 1e-6);
  for (int channel = 0; channel < 3; ++channel) {
    EXPECT_NEAR(closed.pixel(0, 0)[channel], kRed[channel], 1e-6);
    EXPECT_NEAR(open.pixel(0, 0)[channel], alpha * kRed[channel], 1e-6);
  }
}

// In a smooth, faint medium the midpoint rule is accurate even at a step of a voxel, and a single ray a pixel gives an
// equal mean.
TEST(ReferenceRenderer, VtkLikeAgreesWhereThePictureIsSmooth) {
  const DenseVolume volume = ball({{31, 31, 31}, VoxelType::f32}, {15, 15, 15}, 12, 1);
  const TransferFunction faint{1, {{0, kRed, 0}, {1, kRed, 0.02}}};
  for (const Projection projection : kBothProjections) {
    const View view = viewAlong(projection, volume.geometry, {1, 0.4, -0.6}, 32, {64, 64});
    const double fine = sum(opticalDepthImage(volume, view, faint).depth);
    EXPECT_NEAR(sum(opticalDepthImage(volume, view, faint, ReferenceSettings::vtkLike()).depth) / fine, 1, 0.002);
  }
}

// Absorption and picture integrate one medium: alpha is one minus the transmittance. Alpha lies in [0,1] and every
// channel is finite, for random scenes in every voxel type.
TEST(ReferenceRenderer, AlphaIsWhatIsAbsorbedInAnyScene) {
  const ReferenceSettings settings{1, 0.3, 1};
  int seen = 0;
  constexpr int kScenes = 64;
  for (std::uint64_t seed = 0; seed < kScenes; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const auto type = static_cast<VoxelType>(seed % 8);
    const glm::dmat4 affine = seed % 3 == 0 ? obliqueAffine() : anisotropicAffine();
    const DenseVolume volume = seed % 2 == 0 ? cheese({{17, 12, 15}, type, affine}, seed, usualRange(type))
                                             : head({{17, 12, 15}, type, affine}, usualRange(type));
    const RandomScene scene = randomScene(seed, volume, {12, 9});
    const Image image =
        referenceImage(volume, scene.view, scene.transfer_function, scene.shading, {0, 0, 0, 0}, settings);
    const OpticalDepthImage absorbed = opticalDepthImage(volume, scene.view, scene.transfer_function, settings);
    bool anything = false;
    forPixels(scene.view, [&](int column, int row, const Ray&) {
      const float* rgba = image.pixel(column, row);
      EXPECT_NEAR(rgba[3], 1 - absorbed.transmittance[placeOf(scene.view, column, row)], 2e-6);
      EXPECT_TRUE(rgba[3] >= 0 && rgba[3] <= 1);
      for (int channel = 0; channel < 3; ++channel) EXPECT_TRUE(std::isfinite(rgba[channel]) && rgba[channel] >= 0);
      anything = anything || rgba[3] > 0.01f;
    });
    seen += anything;
  }
  EXPECT_GT(seen, kScenes * 2 / 3) << "most random scenes should show something";
}

// Skipped samples would add nothing, so both pictures sum equal terms: their bits are equal. The volumes have empty
// regions of every size, NaN and thin walls; the views come from everywhere, inside too.
TEST(ReferenceRenderer, SteppingOverEmptyBlocksChangesNoBit) {
  DenseVolume volumes[] = {cheese({{31, 22, 40}, VoxelType::f32, obliqueAffine()}, 1, {0, 1}),
                           head({{40, 33, 21}, VoxelType::i16, anisotropicAffine()}, usualRange(VoxelType::i16)),
                           ball({{29, 30, 31}, VoxelType::u8}, {9, 14, 20}, 6, 200)};
  for (int i = 0; i < 31 * 22 * 40; i += 97) volumes[0].set(i % 31, i / 31 % 22, i / 31 / 22, std::nan(""));
  ReferenceSettings skipping{1, 0.3, 1}, plodding = skipping;
  plodding.skip_empty = false;
  int pictures_with_something = 0;
  for (std::uint64_t seed = 0; seed < 45; ++seed) {
    const DenseVolume& volume = volumes[seed % 3];
    const RandomScene scene = randomScene(seed, volume, {24, 20});
    skipping.interpolation = plodding.interpolation = scene.interpolation;
    const auto picture = [&](const ReferenceSettings& settings) {
      return referenceImage(volume, scene.view, scene.transfer_function, scene.shading, {0, 0, 0, 0}, settings);
    };
    const Image image = picture(skipping);
    EXPECT_EQ(image.rgba, picture(plodding).rgba) << "seed " << seed;
    const auto depth = opticalDepthImage(volume, scene.view, scene.transfer_function, skipping).depth;
    EXPECT_EQ(depth, opticalDepthImage(volume, scene.view, scene.transfer_function, plodding).depth) << "seed " << seed;
    pictures_with_something += std::any_of(image.rgba.begin(), image.rgba.end(), [](float v) { return v > 0; });
  }
  EXPECT_GT(pictures_with_something, 25);
}

// A box read from a source is the voxels of the volume, in the order of volume_source.h.
TEST(DenseSource, ReadsTheVoxelsOfABox) {
  for (int type = 0; type < 8; ++type) {
    const auto voxel_type = static_cast<VoxelType>(type);
    const DenseVolume volume = noise({{7, 6, 5}, voxel_type}, 3, usualRange(voxel_type));
    DenseSource source(volume);
    const VoxelBox box{{2, 1, 1}, {7, 4, 3}};
    std::vector<std::byte> bytes(static_cast<std::size_t>(box.count()) * sizeOf(voxel_type));
    source.read(box, bytes);
    withVoxelType(voxel_type, [&]<class T>(std::type_identity<T>) {
      const std::byte* from = bytes.data();
      for (std::int64_t k = 1; k < 3; ++k) {
        for (std::int64_t j = 1; j < 4; ++j) {
          for (std::int64_t i = 2; i < 7; ++i, from += sizeof(T)) {
            T value;
            std::memcpy(&value, from, sizeof(T));
            EXPECT_EQ(value, volume.at<T>(i, j, k));
          }
        }
      }
    });
  }
}

}  // namespace
}  // namespace kiln::test
