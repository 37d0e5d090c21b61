#include "random_scene.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace kiln::test {
namespace {

glm::dvec3 randomIndex(Random& random, const Extent3& dims) {
  glm::dvec3 index;
  for (int axis = 0; axis < 3; ++axis) index[axis] = random.uniform(-0.5, static_cast<double>(dims[axis]) - 0.5);
  return index;
}

/// Half the longest diagonal of the volume's box.
double radiusOf(const VolumeGeometry& volume) {
  const glm::dvec3 size(volume.dims.x, volume.dims.y, volume.dims.z);
  const glm::dvec3 centre = volume.worldOf(0.5 * size - 0.5);
  double radius = 0;
  for (const glm::dvec3& corner : volume.corners()) radius = std::max(radius, glm::length(corner - centre));
  return radius;
}

glm::dvec3 randomColor(Random& random) { return {random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1)}; }

TransferPoint point(Random& random, double value, double opacity) { return {value, randomColor(random), opacity}; }

/// Transparent below a value, and (nearly) opaque above: a sharp edge or a slope.
void addSurface(Random& random, const ValueRange& range, std::vector<TransferPoint>& points) {
  const double width = range.hi - range.lo;
  const double at = range.lo + width * random.uniform(0.2, 0.8);
  points.push_back(point(random, at, 0));
  points.push_back(point(random, at + (random.chance(0.5) ? 0 : width * random.uniform(0, 0.2)),
                         random.chance(0.5) ? 1 : random.uniform(0.7, 1)));
}

/// Something only between two values, with a flank on each side.
void addWindow(Random& random, const ValueRange& range, std::vector<TransferPoint>& points) {
  const double width = range.hi - range.lo;
  const double lo = range.lo + width * random.uniform(0, 0.7);
  const double flank = width * random.uniform(0.01, 0.1);
  points.push_back(point(random, lo, 0));
  points.push_back(point(random, lo + flank, random.uniform(0.02, 1)));
  points.push_back(point(random, lo + 2 * flank, 0));
}

void addAnything(Random& random, const ValueRange& range, int count, double most, std::vector<TransferPoint>& points) {
  const double width = range.hi - range.lo;
  for (int i = 0; i < count; ++i) {
    const double value = range.lo + width * random.uniform(-0.1, 1.1);
    points.push_back(point(random, value, random.chance(0.3) ? 0 : random.uniform(0, most)));
  }
}

}  // namespace

glm::dvec3 Random::direction() {
  const double z = uniform(-1, 1);
  const double angle = uniform(0, 6.283185307179586);
  const double radius = std::sqrt(1 - z * z);
  return {radius * std::cos(angle), radius * std::sin(angle), z};
}

Camera randomCamera(Random& random, const VolumeGeometry& volume) {
  const double radius = radiusOf(volume);
  Camera camera;
  camera.projection = random.chance(0.5) ? Projection::kPerspective : Projection::kOrthographic;
  camera.target = volume.worldOf(randomIndex(random, volume.dims));
  camera.eye = camera.target + random.direction() * radius * random.uniform(1.1, 4);
  if (random.chance(0.15)) camera.eye = volume.worldOf(randomIndex(random, volume.dims));
  // Two points of a small volume may nearly coincide.
  if (glm::length(camera.eye - camera.target) < 1e-3 * radius) camera.eye += radius * random.direction();
  const glm::dvec3 forward = glm::normalize(camera.target - camera.eye);
  do {
    camera.up = random.direction();
  } while (std::abs(glm::dot(camera.up, forward)) > 0.99);
  camera.fov_deg = random.uniform(10, 100);
  camera.height = radius * random.uniform(0.3, 3);
  return camera;
}

TransferFunction randomTransferFunction(Random& random, const ValueRange& range, double mean_spacing) {
  TransferFunction function;
  if (random.chance(0.5)) function.unit = mean_spacing * random.uniform(0.3, 5);
  switch (random.between(0, 4)) {
    case 0:
      addSurface(random, range, function.points);
      break;
    case 1:
      addAnything(random, range, random.between(2, 6), 0.05, function.points);
      break;
    case 2:
      for (int windows = random.between(1, 2); windows > 0; --windows) addWindow(random, range, function.points);
      break;
    case 3:
      addAnything(random, range, random.between(1, 4), 0.03, function.points);
      addSurface(random, range, function.points);
      break;
    default:
      addAnything(random, range, random.between(1, 6), 1, function.points);
  }
  std::stable_sort(function.points.begin(), function.points.end(),
                   [](const TransferPoint& a, const TransferPoint& b) { return a.value < b.value; });
  return function;
}

Shading randomShading(Random& random) {
  Shading shading;
  shading.phong = random.chance(0.8);
  shading.ambient = random.uniform(0, 1);
  shading.diffuse = random.uniform(0, 1);
  shading.specular = random.chance(0.3) ? 0 : random.uniform(0, 0.5);
  shading.power = random.chance(0.3) ? random.between(1, 64) : random.uniform(1, 64);
  return shading;
}

std::vector<Light> randomLights(Random& random, const VolumeGeometry& volume) {
  std::vector<Light> lights(static_cast<std::size_t>(random.between(0, 3)));
  for (Light& light : lights) {
    light.kind = static_cast<LightKind>(random.between(0, 2));
    light.place = random.direction();
    if (light.kind == LightKind::kPoint) light.place = volume.worldOf(1.5 * randomIndex(random, volume.dims));
    light.color = randomColor(random);
    light.intensity = random.uniform(0, 2);
  }
  return lights;
}

Clipping randomClipping(Random& random, const VolumeGeometry& volume) {
  Clipping clipping;
  if (random.chance(0.5)) return clipping;
  if (random.chance(0.6)) {
    clipping.region.emplace();
    for (int axis = 0; axis < 3; ++axis) {
      const auto voxels = static_cast<int>(volume.dims[axis]);
      clipping.region->lo[axis] = random.between(-2, voxels / 2);
      clipping.region->hi[axis] = random.between(voxels / 2 + 1, voxels + 2);
    }
  }
  for (int planes = random.between(0, 2); planes > 0; --planes) {
    const glm::dvec3 normal = random.uniform(0.1, 5) * random.direction();
    clipping.planes.push_back({normal, -glm::dot(normal, volume.worldOf(randomIndex(random, volume.dims)))});
  }
  return clipping;
}

RandomScene randomScene(std::uint64_t seed, const DenseVolume& volume, const ImageSize& size) {
  Random random(seed);
  RandomScene scene;
  scene.camera = randomCamera(random, volume.geometry);
  scene.view = resolve(scene.camera, size);
  scene.transfer_function = randomTransferFunction(random, volume.range(), volume.geometry.meanSpacing());
  scene.shading = randomShading(random);
  if (random.chance(0.5)) {
    const double alpha = random.uniform(0, 1);
    const glm::dvec3 color = alpha * randomColor(random);
    scene.background.top = {color.r, color.g, color.b, alpha};
    scene.background.bottom = random.chance(0.5) ? scene.background.top : std::array<double, 4>{0, 0, 0, 1};
  }
  scene.clipping = randomClipping(random, volume.geometry);
  if (random.chance(0.5)) scene.shading.lights = randomLights(random, volume.geometry);
  scene.interpolation = static_cast<Interpolation>(random.between(0, 2));
  if (random.chance(0.5)) scene.sample_distance = random.uniform(kLeastSampleDistance, kMostSampleDistance);
  return scene;
}

CameraSpec specOf(const Camera& camera) {
  CameraSpec out;
  out.projection = camera.projection;
  out.eye = camera.eye;
  out.target = camera.target;
  out.up = camera.up;
  if (camera.projection == Projection::kPerspective)
    out.fov_deg = camera.fov_deg;
  else
    out.height = camera.height;
  return out;
}

FrameRequest requestOf(const RandomScene& scene, Lattice lattice, double opacity_threshold) {
  FrameRequest request;
  request.lattice = lattice;
  if (lattice == Lattice::kPixel) request.interpolation = scene.interpolation;
  if (lattice != Lattice::kVoxel) request.sample_distance = scene.sample_distance;
  request.view = scene.view;
  request.transfer_function = scene.transfer_function;
  request.shading = scene.shading;
  request.background = scene.background;
  request.clipping = scene.clipping;
  request.opacity_threshold = opacity_threshold;
  return request;
}

double randomThreshold(std::uint64_t seed) { return 0.3 + 0.7 * hashUnit(seed, 77); }

}  // namespace kiln::test
