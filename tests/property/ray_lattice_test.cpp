// Samples on rays, known from loops that say where they are and nothing of cells, bricks or vectors.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "frame/frame_levels.h"
#include "splat/pixel_slabs.h"
#include "splat/slab_grid.h"
#include "support/drawing.h"
#include "support/random_scene.h"
#include "support/reference_field.h"
#include "support/reference_renderer.h"
#include "support/test_store.h"

namespace kiln::test {
namespace {

constexpr ImageSize kRaySize{70, 61};

FrameRequest rayRequest(const DenseVolume& volume, Projection projection) {
  FrameRequest out;
  out.lattice = Lattice::kRay;
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

// What of a ray is in the volume. unit: depth.
std::array<double, 2> depthsInside(const PixelRay& ray, const Extent3& dims) {
  std::array<double, 2> out{-1e30, 1e30};
  for (int axis = 0; axis < 3; ++axis) {
    const double a = (-0.5 - ray.base()[axis]) / ray.slope()[axis];
    const double b = (static_cast<double>(dims[axis]) - 0.5 - ray.base()[axis]) / ray.slope()[axis];
    out = {std::max(out[0], std::min(a, b)), std::min(out[1], std::max(a, b))};
  }
  return out;
}

// A pixel's samples one after the other, in doubles. The first and the last are as long as the volume reaches.
class SamplesAlone {
 public:
  SamplesAlone(const DenseVolume& volume, const FrameRequest& request, const StoreReader& store)
      : volume_(volume),
        request_(request),
        levels_(store.manifest(), 0, request.view, ProjectedArea::kBox, {}),
        field_(volume, Interpolation::kLinear) {
    ZonedVolume zoned{&store.manifest(), levels_.projector(0).nearDepth()};
    zoned.sample_distance = request.sample_distance;
    zoned.on_rays = true;
    zones_ = slabZones(zoned, request.view, 0);
  }
  std::array<double, 4> composited(int x, int y) const;

 private:
  const DenseVolume& volume_;
  const FrameRequest& request_;
  const FrameLevels levels_;
  const ReferenceField field_;
  std::vector<SlabZone> zones_;
};

std::array<double, 4> SamplesAlone::composited(int x, int y) const {
  const Projector& projector = levels_.projector(0);
  const PixelRay ray(projector, x, y);
  const std::array<double, 2> inside = depthsInside(ray, volume_.geometry.dims);
  std::vector<std::array<double, 2>> slabs;
  for (const SlabZone& zone : zones_) {
    for (int slab = 0; slab < zone.slabs; ++slab) {
      const double near = zone.near + slab * zone.thickness, middle = near + 0.5 * zone.thickness;
      if (middle >= inside[0] && middle < inside[1]) slabs.push_back({near, near + zone.thickness});
    }
  }
  const glm::dvec2 across = (glm::dvec2(x + 0.5, y + 0.5) - projector.centre()) / projector.focal();
  const double oblique = projector.perspective() ? std::sqrt(1 + glm::dot(across, across)) : 1;
  std::array<double, 4> out{};
  for (std::size_t i = 0; i < slabs.size(); ++i) {
    const double value = field_.at(ray.base() + 0.5 * (slabs[i][0] + slabs[i][1]) * ray.slope());
    if (std::isnan(value)) continue;
    const double near = i == 0 ? inside[0] : slabs[i][0], far = i + 1 == slabs.size() ? inside[1] : slabs[i][1];
    const Classified c = request_.transfer_function.at(value);
    const double tau = extinctionOf(c.opacity, request_.transfer_function.unitIn(volume_.geometry.meanSpacing()));
    const double weight = (1 - out[3]) * -std::expm1(-tau * (far - near) * oblique);
    for (std::size_t channel = 0; channel < 3; ++channel) out[channel] += weight * c.color[static_cast<int>(channel)];
    out[3] += weight;
  }
  return out;
}

TEST(RayLattice, EachSampleOfAPixelIsCompositedOnceAndInItsOrder) {
  for (const VoxelType type : {VoxelType::u8, VoxelType::f32}) {
    const DenseVolume volume = smallHead(type);
    const auto path = makeStore(volume, "head", 16);
    const StoreReader store(path);
    for (const Projection projection : {Projection::kOrthographic, Projection::kPerspective}) {
      FrameRequest request = rayRequest(volume, projection);
      request.shading.phong = false;
      request.opacity_threshold = 1;
      request.sample_distance = 0.75;  // so far apart that no two are one
      const Image image = draw(path, request);
      const SamplesAlone samples(volume, request, store);
      double largest = 0, brightest = 0;
      for (int y = 0; y < image.height; y += 2) {
        for (int x = y % 4 / 2; x < image.width; x += 2) {
          const std::array<double, 4> alone = samples.composited(x, y);
          for (int c = 0; c < 4; ++c)
            largest = std::max(largest, std::abs(alone[static_cast<std::size_t>(c)] - double{image.pixel(x, y)[c]}));
          brightest = std::max(brightest, alone[3]);
        }
      }
      EXPECT_LT(largest, 1e-3) << nameOf(type);
      EXPECT_GT(brightest, 0.9);
    }
  }
}

// An eye on the face between two cells, and rays in that face: on one side of it all the way, whatever the bricks.
TEST(RayLattice, RaysInAFaceAreOnOneSideOfIt) {
  const DenseVolume volume = head({{48, 48, 48}, VoxelType::u8}, usualRange(VoxelType::u8));
  FrameRequest request = rayRequest(volume, Projection::kPerspective);
  request.shading.phong = false;
  request.opacity_threshold = 1;
  request.sample_distance = 0.75;
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

// Rays in a face of a region, too: nothing is more than what is there.
TEST(RayLattice, ARegionHasItsShareOfTheVolume) {
  const DenseVolume volume = fill({{48, 48, 48}, VoxelType::u8}, [](auto...) { return 100; });
  const auto store = makeStore(volume, "uniform", 16);
  constexpr double kTau = 0.02;
  FrameRequest request;
  request.lattice = Lattice::kRay;
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
    request.clipping.region = VoxelBox{{24, first, 0}, {48, 32, 48}};  // faces on cells' and within them
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

// Where pairs of samples are one, pictures are nearly those of all samples.
TEST(RayLattice, TwoSamplesAreOneWhereThatShowsLittle) {
  const DenseVolume volume = fill({{48, 48, 48}, VoxelType::u8}, [](auto x, auto y, auto z) {
    return 40 + x + (std::hypot(x - 24.0, y - 24.0, z - 24.0) < 9 ? 150 : 0);
  });
  const auto store = makeStore(volume, "soft", 16);
  FrameRequest request;
  request.lattice = Lattice::kRay;
  request.level = 0;
  Camera camera = cameraFrom(volume.geometry, {0.3, -1, 0.2}, Projection::kOrthographic);
  camera.height = kRaySize.height / 1.5;  // half a voxel is more than half a pixel
  request.view = resolve(camera, kRaySize);
  request.transfer_function = {1, {{30, {1, 0.6, 0.4}, 0.01}, {100, {1, 0.6, 0.4}, 0.03}, {200, {1, 1, 0.9}, 0.8}}};
  FrameStatistics in_pairs, all;
  const Image few = draw(store, request, 1ull << 30, &in_pairs);
  request.transfer_function.gradient_opacity = {{0, 1}, {1, 1}};  // takes nothing away, but might
  const Image many = draw(store, request, 1ull << 30, &all);
  EXPECT_LT(in_pairs.voxels_splats, 7 * all.voxels_splats / 10);
  double largest = 0;
  for (std::size_t i = 0; i < few.rgba.size(); ++i)
    largest = std::max(largest, std::abs(double{few.rgba[i]} - double{many.rgba[i]}));
  EXPECT_LT(largest, 0.01);
}

}  // namespace
}  // namespace kiln::test
