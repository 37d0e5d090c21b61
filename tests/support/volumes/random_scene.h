// Random scenes for properties that must hold for all scenes. A seed determines the scene on every machine; a test
// prints its seed, which reproduces a failure.
#pragma once

#include <array>
#include <cstdint>

#include "frame/render_frame.h"
#include "job/render_job.h"
#include "scene/camera/camera.h"
#include "scene/transfer/transfer_function.h"
#include "support/volumes/procedural.h"

namespace kiln::test {

/// A sequence of numbers determined by a seed (the standard library's distributions differ between libraries).
class Random {
 public:
  explicit Random(std::uint64_t seed) : seed_(seed) {}
  /// Returns a number in [lo, hi).
  double uniform(double lo, double hi) { return lo + (hi - lo) * hashUnit(seed_, counter_++); }
  /// Returns an integer from lo to hi, inclusive.
  int between(int lo, int hi) {
    return lo + static_cast<int>(hashBits(seed_, counter_++) % std::uint64_t(hi - lo + 1));
  }
  bool chance(double probability) { return uniform(0, 1) < probability; }
  /// Uniform on the unit sphere.
  glm::dvec3 direction();

 private:
  std::uint64_t seed_;
  std::uint64_t counter_ = 0;
};

/// Either projection, from any side of the volume's box, towards a random point inside. Some cameras are inside, or so
/// near that much of the volume is out of the picture.
Camera randomCamera(Random& random, const VolumeGeometry& volume);
/// One to six points over `range` (and slightly beyond): surfaces, translucent media, windows, steps, constants.
TransferFunction randomTransferFunction(Random& random, const ValueRange& range, double mean_spacing);
Shading randomShading(Random& random);
/// Up to three lights of any kind, in and around the volume.
std::vector<Light> randomLights(Random& random, const VolumeGeometry& volume);
/// Half of the results clip nothing; the rest have a region, planes or both, each of which leaves some of the volume.
Clipping randomClipping(Random& random, const VolumeGeometry& volume);

struct RandomScene {
  Camera camera;
  View view;
  TransferFunction transfer_function;
  Shading shading;
  Background background;
  Clipping clipping;
  Interpolation interpolation = Interpolation::kLinear;
  double sample_distance = kSampleDistance;
};
RandomScene randomScene(std::uint64_t seed, const DenseVolume& volume, const ImageSize& size);

/// Returns the camera as written in a job.
CameraSpec specOf(const Camera& camera);
/// The picture of the scene.
FrameRequest requestOf(const RandomScene& scene, Lattice lattice, double opacity_threshold);
/// Returns a threshold determined by the seed, from 0.3 to 1.
double randomThreshold(std::uint64_t seed);

}  // namespace kiln::test
