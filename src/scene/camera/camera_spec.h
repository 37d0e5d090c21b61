// The camera as a user gives it: settings of which any may be missing, the path from frame to frame, a pair of eyes.
#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <variant>
#include <vector>

#include "grid/geometry.h"
#include "scene/camera/camera.h"
#include "scene/camera/framing.h"
#include "scene/keyframes.h"

namespace kiln {

/// A camera, and the pan that it lacks. unit: widths and heights of the picture.
struct UnpannedCamera {
  Camera camera;
  glm::dvec2 pan{0};
};

/// Either an eye or a framing; each key is optional. Azimuth and elevation turn an eye about its target, and zoom
/// enlarges its picture. Defaults with an eye: target at the volume's centre, up superior, fov 60, and an orthographic
/// height that fits. Defaults without: `defaultFraming`, or a side seen straight; a target then moves eye and target
/// together. A named projection ignores the other projection's fov or height.
struct CameraSpec {
  std::optional<Projection> projection;
  std::optional<glm::dvec3> eye, target, up;
  std::optional<double> fov_deg, height;
  std::optional<Side> side;
  std::optional<double> azimuth_deg, elevation_deg, zoom;
  std::optional<double> roll_deg;  // about the line of sight, from the direction `up`
  std::optional<glm::dvec2> pan;   // of the picture, right and up. unit: widths and heights of the picture

  /// Returns whether the camera fits the volume into the picture: it has no eye.
  bool framed() const { return !eye; }
  /// Returns whether the camera leaves edges of the picture free: neither its place nor what it looks at is given.
  bool leavesEdges() const { return framed() && !target && projection != Projection::kEquirectangular; }
  /// `turns` are the rotations of a turntable (frameVolume). throws: Error kUsage if settings contradict each other (an
  /// eye and a side; a height without a projection) or the camera cannot be used.
  Camera resolve(const FramedBox& box, const ImageSize& size, const Turns& turns = {}) const;
  /// Returns the camera before its pan, which is `pan` and the shift to the middle between free edges: a camera on a
  /// turntable turns first. throws: as `resolve`.
  UnpannedCamera unpanned(const FramedBox& box, const ImageSize& size, const Turns& turns = {}) const;
};

/// Frame 1 is the still camera. Each later frame turns eye and up by degrees / frames about the axis through the
/// target, so that frame 1 + `frames` closes a full turn.
struct Turntable {
  int frames = 1;
  double degrees = 360;            // right-handed: seen from the front about superior, towards the patient's left
  std::optional<glm::dvec3> axis;  // default: the camera's up. unit: world
};

/// The fixed point of a camera that only turns.
enum class Pivot { kEye, kTarget };

/// Cameras at some frames: each is the still camera with the key's changes. The orientation follows a spline of its
/// own. A second spline moves the eye with the target ahead of it, or the target with the eye behind it.
struct CameraKeyframes {
  std::vector<Key<CameraSpec>> keys;
  /// Default: the target if it is equal in all keys or no key has an eye; else the eye.
  std::optional<Pivot> pivot;
};

/// Camera to world, for frame 1 and later frames; the camera looks along -z, y is up. Projection, fov and height are
/// the still camera's. shape: for column vectors.
using CameraMatrices = std::vector<glm::dmat4>;

/// std::monostate: the camera stands still.
using CameraPath = std::variant<std::monostate, Turntable, CameraKeyframes, CameraMatrices>;

/// A lens (scene/camera/lens.h).
struct Lens {
  double aperture = 0;          // diameter; 0: a point, with all depths sharp. unit: world
  std::optional<double> focus;  // depth of the sharp plane; absent: the target's. unit: world
  int eyes = 48;                // points of the lens
  bool operator==(const Lens&) const = default;
};

/// Most points of a lens: the time of a picture is proportional.
inline constexpr int kMostEyes = 1024;

enum class StereoEye { kLeft, kRight, kBoth };

/// One eye of a stereo pair, or both (job/stereo.h).
struct Stereo {
  StereoEye eye = StereoEye::kLeft;
  double interocular = 0;             // between both eyes. unit: world
  std::optional<double> convergence;  // depth; else the target's distance from the eye. unit: world
  bool operator==(const Stereo&) const = default;
};

}  // namespace kiln
