// Samples on rays. Known from plain loops over sample positions, without cells, bricks or vectors.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>

#include "engine/projection/pixel_slabs.h"
#include "engine/shared/slab_grid.h"
#include "store/store_reader.h"
#include "support/reference/drawing.h"
#include "support/reference/reference_field.h"
#include "support/reference/reference_renderer.h"
#include "support/volumes/random_scene.h"
#include "support/volumes/test_store.h"
#include "traverse/frame_levels.h"

namespace kiln::test {
namespace {

constexpr ImageSize kRaySize{70, 61};

FrameRequest rayRequest(const DenseVolume& volume, Projection projection) {
  FrameRequest out;
  out.filters_rays = false;
  out.level = 0;
  out.view = resolve(cameraFrom(volume.geometry, {0.7, -1, 0.4}, projection), kRaySize);
  const ValueRange range = volume.range();
  const auto at = [&](double part) { return range.lo + part * (range.hi - range.lo); };
  out.transfer_function.unit = volume.geometry.meanSpacing();
  out.transfer_function.points = {
      {at(0.1), {1, 0.7, 0.5}, 0}, {at(0.3), {1, 0.7, 0.5}, 0.2}, {at(0.6), {1, 1, 0.8}, 0.7}};
  return out;
}

// Returns the depths where a ray enters and leaves the volume. unit: depth.
std::array<double, 2> depthsInside(const PixelRay& ray, const Extent3& dims) {
  std::array<double, 2> out{-1e30, 1e30};
  for (int axis = 0; axis < 3; ++axis) {
    const double a = (-0.5 - ray.base()[axis]) / ray.slope()[axis];
    const double b = (static_cast<double>(dims[axis]) - 0.5 - ray.base()[axis]) / ray.slope()[axis];
    out = {std::max(out[0], std::min(a, b)), std::min(out[1], std::max(a, b))};
  }
  return out;
}

// Composites a pixel's samples one after another, in doubles. The first and the last sample end at the volume's
// boundary. A ray between the middles of two slabs has one sample. A sample lies in the middle of its piece.
class SamplesAlone {
 public:
  SamplesAlone(const DenseVolume& volume, const FrameRequest& request, const StoreReader& store)
      : volume_(volume),
        request_(request),
        view_(drawnView(request.view, store.manifest().geometry())),
        levels_(store.manifest(), 0, view_, ProjectedArea::kBox, {}),
        field_(volume, request.interpolation) {
    ZonedVolume zoned{&store.manifest(), levels_.projector(0).nearDepth()};
    zoned.sample_distance = request.sample_distance;
    zones_ = slabZones(zoned, view_, 0);
  }
  std::array<double, 4> composited(int x, int y) const;

 private:
  // The volume's nearest face towards the eye.
  struct Face {
    glm::dvec3 normal{0};  // in world space
    double share = 0;      // part of a sample's piece within a voxel of the face
  };
  // `ray`: from the eye, in index space; `length`: of the piece. unit: length: rays.
  Face faceAt(const glm::dvec3& index, const glm::dvec3& ray, double length) const {
    Face out;
    double nearest = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      if (ray[axis] == 0) continue;
      const auto edge = static_cast<double>(volume_.geometry.dims[axis]);
      const double inside = ray[axis] > 0 ? index[axis] + 0.5 : edge - 0.5 - index[axis];
      const double distance = inside / std::abs(ray[axis]), depth = length * std::abs(ray[axis]);
      if (!(distance < nearest)) continue;
      nearest = distance;
      out.normal = worldFromGradient()[axis];
      out.share = std::clamp((1 - inside) / depth + 0.5, 0.0, 1.0);
    }
    return out;
  }
  glm::dmat3 worldFromGradient() const {
    return glm::transpose(glm::inverse(glm::dmat3(volume_.geometry.world_from_index)));
  }

  // Returns a colour lit by a headlight, from a normal in world space and the direction to the eye.
  glm::dvec3 lit(const glm::dvec3& color, const glm::dvec3& normal, const glm::dvec3& ray) const {
    if (!request_.shading.phong || !(glm::length(normal) > 0)) return color;
    const glm::dvec3 along = glm::dmat3(volume_.geometry.world_from_index) * ray;
    const double cosine = std::abs(glm::dot(glm::normalize(normal), glm::normalize(along)));
    const Shading& s = request_.shading;
    return color * (s.ambient + s.diffuse * cosine) + s.specular * std::pow(cosine, s.power);
  }
  glm::dvec3 lit(const glm::dvec3& color, const glm::dvec3& index, const glm::dvec3& ray, double length) const {
    const Face face = faceAt(index, ray, length);
    const glm::dvec3 own = lit(color, worldFromGradient() * field_.gradient(index), ray);
    return glm::mix(own, lit(color, face.normal, ray), face.share);
  }

  const DenseVolume& volume_;
  const FrameRequest& request_;
  const View view_;
  const FrameLevels levels_;
  const ReferenceField field_;
  std::vector<SlabZone> zones_;
};

std::array<double, 4> SamplesAlone::composited(int x, int y) const {
  const Projector& projector = levels_.projector(0);
  const PixelRay ray(projector, {x + 0.5, y + 0.5});
  const std::array<double, 2> inside = depthsInside(ray, volume_.geometry.dims);
  std::vector<std::array<double, 2>> slabs;
  for (const SlabZone& zone : zones_) {
    for (int slab = 0; slab < zone.slabs; ++slab) {
      const double near = zone.near + slab * zone.thickness, middle = near + 0.5 * zone.thickness;
      if (middle >= inside[0] && middle < inside[1]) slabs.push_back({near, near + zone.thickness});
    }
  }
  if (slabs.empty() && inside[0] < inside[1]) slabs.push_back(inside);
  const glm::dvec2 across = (glm::dvec2(x + 0.5, y + 0.5) - projector.centre()) / projector.focal();
  const double oblique = projector.perspective() ? std::sqrt(1 + glm::dot(across, across)) : 1;
  std::array<double, 4> out{};
  for (std::size_t i = 0; i < slabs.size(); ++i) {
    const double near = i == 0 ? inside[0] : slabs[i][0], far = i + 1 == slabs.size() ? inside[1] : slabs[i][1];
    const glm::dvec3 index = ray.base() + 0.5 * (near + far) * ray.slope();
    const double value = field_.at(index);
    if (std::isnan(value)) continue;
    const Classified c = request_.transfer_function.at(value);
    const double tau = extinctionOf(c.opacity, request_.transfer_function.unitIn(volume_.geometry.meanSpacing()));
    const double weight = (1 - out[3]) * -std::expm1(-tau * (far - near) * oblique);
    const glm::dvec3 color = lit(c.color, index, ray.slope(), far - near);
    for (std::size_t channel = 0; channel < 3; ++channel) out[channel] += weight * color[static_cast<int>(channel)];
    out[3] += weight;
  }
  return out;
}

struct Difference {
  double largest = 0, brightest = 0;
};
// Over a quarter of the pixels.
Difference differenceFrom(const SamplesAlone& samples, const Image& image) {
  Difference out;
  for (int y = 0; y < image.height; y += 2) {
    for (int x = y % 4 / 2; x < image.width; x += 2) {
      const std::array<double, 4> alone = samples.composited(x, y);
      for (int c = 0; c < 4; ++c)
        out.largest =
            std::max(out.largest, std::abs(alone[static_cast<std::size_t>(c)] - double{image.pixel(x, y)[c]}));
      out.brightest = std::max(out.brightest, alone[3]);
    }
  }
  return out;
}

// Requests samples that are neither lit nor merged.
FrameRequest samplesRequest(const DenseVolume& volume, Projection projection, Interpolation interpolation) {
  FrameRequest out = rayRequest(volume, projection);
  out.interpolation = interpolation;
  out.shading.phong = false;
  out.opacity_threshold = 1;
  out.sample_distance = 0.75;  // so far apart that no two samples are merged
  return out;
}

constexpr std::array kInterpolations = {Interpolation::kLinear, Interpolation::kCubic, Interpolation::kCatmullRom};

TEST(RayLattice, EachSampleOfAPixelIsCompositedOnceAndInItsOrder) {
  for (const VoxelType type : {VoxelType::u8, VoxelType::f32}) {
    const DenseVolume volume = smallHead(type);
    const auto path = makeStore(volume, "head", 16);
    const StoreReader store(path);
    for (const auto& [projection, interpolation] : {std::pair(Projection::kOrthographic, Interpolation::kLinear),
                                                    {Projection::kPerspective, Interpolation::kLinear},
                                                    {Projection::kOrthographic, Interpolation::kCubic},
                                                    {Projection::kPerspective, Interpolation::kCatmullRom}}) {
      const FrameRequest request = samplesRequest(volume, projection, interpolation);
      const Difference found = differenceFrom(SamplesAlone(volume, request, store), draw(path, request));
      EXPECT_LT(found.largest, 1e-3) << nameOf(type);
      EXPECT_GT(found.brightest, 0.9);
    }
  }
}

// Every gradient is far from zero, so that its direction is exact to a float.
TEST(RayLattice, Shading_ofEveryInterpolation_hasItsGradient) {
  const DenseVolume volume = fill({{40, 37, 43}, VoxelType::f32, obliqueAffine()}, [](auto x, auto y, auto z) {
    return 2.0 * x + 1.5 * y + z + 4 * std::sin(0.4 * x) * std::cos(0.3 * z) + 3 * std::sin(0.5 * y);
  });
  const auto path = makeStore(volume, "waves", 16);
  const StoreReader store(path);
  for (const Interpolation interpolation : kInterpolations) {
    for (const Projection projection : {Projection::kOrthographic, Projection::kPerspective}) {
      FrameRequest request = samplesRequest(volume, projection, interpolation);
      request.shading.phong = true;
      const Difference found = differenceFrom(SamplesAlone(volume, request, store), draw(path, request));
      EXPECT_LT(found.largest, 1e-3) << static_cast<int>(interpolation);
      EXPECT_GT(found.brightest, 0.9);
    }
  }
}

TEST(RayLattice, SamplesThatOnlyDistantVoxelsShow_areDrawn) {
  const DenseVolume steep = specks();
  const DenseVolume volume = fill({steep.geometry.dims, VoxelType::f32},
                                  [&](auto i, auto j, auto k) { return (steep.valueAt(i, j, k) - 128) / 64; });
  const auto path = makeStore(volume, "soft_specks", 16);
  const StoreReader store(path);
  for (const Interpolation interpolation : kInterpolations) {
    FrameRequest request = samplesRequest(volume, Projection::kPerspective, interpolation);
    for (const auto& [lo, hi] : {std::array{-0.2, -0.02}, std::array{0.02, 0.2}}) {
      const glm::dvec3 color(0.9, 0.8, 0.7);
      request.transfer_function = {1, {{lo, color, 0}, {(lo + hi) / 2, color, 0.6}, {hi, color, 0}}};
      const Difference found = differenceFrom(SamplesAlone(volume, request, store), draw(path, request));
      EXPECT_LT(found.largest, 0.005) << static_cast<int>(interpolation) << ", values from " << lo << " to " << hi;
      EXPECT_GT(found.brightest, 0.3);
    }
  }
}

// The table ends at 2, and its last opacity is that of all greater values, also of 8³ voxels of the greatest float.
TEST(RayLattice, ValuesFarBeyondTheTable_areDrawnInsideABlock) {
  for (const double far : {3.4e38, -3.4e38}) {
    const double sign = far > 0 ? 1 : -1;
    const DenseVolume volume = fill({{28, 27, 29}, VoxelType::f32}, [&](auto i, auto j, auto k) {
      const auto inside = [](auto at) { return at >= 6 && at < 22; };
      return inside(i) && inside(j) && inside(k) ? far
                                                 : sign * hashUnit(3, static_cast<std::uint64_t>(i + 30 * j + 900 * k));
    });
    const auto path = makeStore(volume, "far_values", 16);
    const StoreReader store(path);
    for (const Interpolation interpolation : kInterpolations) {
      FrameRequest request = samplesRequest(volume, Projection::kOrthographic, interpolation);
      const glm::dvec3 color(0.9, 0.8, 0.7);
      request.transfer_function = {1, {{1.5, color, 0}, {2, color, 0.05}}};
      if (sign < 0) request.transfer_function.points = {{-2, color, 0.05}, {-1.5, color, 0}};
      const Difference found = differenceFrom(SamplesAlone(volume, request, store), draw(path, request));
      EXPECT_LT(found.largest, 1e-3) << far << ", interpolation " << static_cast<int>(interpolation);
      EXPECT_GT(found.brightest, 0.3);
    }
  }
}

TEST(RayLattice, Picture_ofEveryInterpolation_isTheSameForEveryBrickSize) {
  const DenseVolume volume = specks();
  FrameRequest request = rayRequest(volume, Projection::kPerspective);
  for (const Interpolation interpolation : {Interpolation::kCubic, Interpolation::kCatmullRom}) {
    request.interpolation = interpolation;
    for (const auto& [lo, hi] : {std::array{126.0, 127.9}, std::array{128.1, 130.0}}) {
      const glm::dvec3 color(0.9, 0.8, 0.7);
      request.transfer_function = {1, {{lo, color, 0}, {(lo + hi) / 2, color, 0.6}, {hi, color, 0}}};
      const Image whole = draw(makeStore(volume, "specks_of_64", 64), request);
      EXPECT_TRUE(showsSomething(whole));
      for (const std::int64_t brick : {16, 32})
        EXPECT_TRUE(equalBits(whole, draw(makeStore(volume, "specks_of_" + std::to_string(brick), brick), request)));
    }
  }
}

// An eye on the face between two cells, and rays in the face: each ray belongs to one of the two cells all the way, for
// every brick size.
TEST(RayLattice, RaysInAFaceAreOnOneSideOfIt) {
  const DenseVolume volume = head({{48, 48, 48}, VoxelType::u8}, usualRange(VoxelType::u8));
  FrameRequest request = samplesRequest(volume, Projection::kPerspective, Interpolation::kLinear);
  for (const Projection projection : {Projection::kPerspective, Projection::kOrthographic}) {
    Camera camera;
    camera.projection = projection;
    camera.eye = {23.5, -60, 23.5}, camera.target = {23.5, 23.5, 23.5}, camera.up = {0, 0, 1};
    camera.fov_deg = 40, camera.height = 61;
    request.view = resolve(camera, {61, 61});
    const auto path = makeStore(volume, "bricks_of_16", 16);
    const StoreReader store(path);
    const Image image = draw(path, request);
    const SamplesAlone samples(volume, request, store);
    for (int i = 0; i < image.width; ++i) {
      for (const auto& [x, y] : {std::pair(30, i), {i, 30}}) {
        const std::array<double, 4> alone = samples.composited(x, y);
        for (int c = 0; c < 4; ++c)
          EXPECT_NEAR(alone[static_cast<std::size_t>(c)], double{image.pixel(x, y)[c]}, 1e-3) << x << " " << y;
      }
    }
    for (const std::int64_t brick : {32, 64}) {
      const auto other = makeStore(volume, "bricks_of_" + std::to_string(brick), brick);
      EXPECT_TRUE(equalBits(image, draw(other, request))) << brick;
    }
  }
}

// Rays in a face of a region count the region at most once.
TEST(RayLattice, ARegionHasItsShareOfTheVolume) {
  const DenseVolume volume = fill({{48, 48, 48}, VoxelType::u8}, [](auto...) { return 100; });
  const auto store = makeStore(volume, "uniform", 16);
  constexpr double kTau = 0.02;
  FrameRequest request;
  request.filters_rays = false;
  request.level = 0;
  request.shading.phong = false;
  request.opacity_threshold = 1;
  request.transfer_function = {1, {{100, glm::dvec3(1), -std::expm1(-kTau)}}};
  Camera camera;
  camera.projection = Projection::kOrthographic;
  camera.eye = {23.5, -60, 23.5}, camera.target = {23.5, 23.5, 23.5}, camera.up = {0, 0, 1}, camera.height = 61;
  request.view = resolve(camera, {61, 61});
  for (const std::int64_t first : {8, 11}) {
    request.clipping.region = VoxelBox{{24, first, 0}, {48, 32, 48}};  // faces on the faces of cells, and inside cells
    const Image image = draw(store, request);
    const double depth = kTau * static_cast<double>(32 - first);
    for (int x = 0; x < 61; ++x) {
      const double found = -std::log1p(-double{image.pixel(x, 30)[3]});
      EXPECT_LE(found, depth * 1.001) << x;
      if (x > 31 && x < 54) {
        EXPECT_NEAR(found, depth, depth * 1e-3) << x;
      }
      if (x < 29) {
        EXPECT_EQ(found, 0) << x;
      }
    }
  }
}

// Pictures with merged pairs of samples are close to pictures of all samples. Cells at the border, which are lit as a
// face, merge nothing, and are empty.
TEST(RayLattice, TwoSamplesAreOneWhereThatShowsLittle) {
  const DenseVolume volume = fill({{64, 64, 64}, VoxelType::u8}, [](auto x, auto y, auto z) {
    if (std::min({x, y, z}) < 9 || std::max({x, y, z}) >= 55) return 0.0;
    return 32.0 + x + (std::hypot(x - 32.0, y - 32.0, z - 32.0) < 9 ? 150 : 0);
  });
  const auto store = makeStore(volume, "soft", 16);
  FrameRequest request;
  request.level = 0;
  Camera camera = cameraFrom(volume.geometry, {0.3, -1, 0.2}, Projection::kOrthographic);
  camera.height = kRaySize.height / 1.5;  // half a voxel is more than half a pixel
  request.view = resolve(camera, kRaySize);
  request.transfer_function = {
      1, {{20, {1, 0.6, 0.4}, 0}, {30, {1, 0.6, 0.4}, 0.01}, {100, {1, 0.6, 0.4}, 0.03}, {200, {1, 1, 0.9}, 0.8}}};
  FrameStatistics in_pairs, all;
  const Image few = draw(store, request, 1ull << 30, &in_pairs);
  request.transfer_function.gradient_opacity = {{0, 1}, {1, 1}};  // removes no opacity, but prevents merging
  const Image many = draw(store, request, 1ull << 30, &all);
  EXPECT_LT(in_pairs.voxels_splats, 7 * all.voxels_splats / 10);
  double largest = 0;
  for (std::size_t i = 0; i < few.rgba.size(); ++i)
    largest = std::max(largest, std::abs(double{few.rgba[i]} - double{many.rgba[i]}));
  EXPECT_LT(largest, 0.01);
}

}  // namespace
}  // namespace kiln::test
