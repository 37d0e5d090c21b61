// Where the camera is at each frame: round a target, through keys, or as a list of matrices says.
#pragma once

#include <glm/mat4x4.hpp>
#include <optional>
#include <variant>
#include <vector>

#include "grid/geometry.h"
#include "scene/camera/camera_spec.h"
#include "scene/keyframes.h"

namespace kiln {

/// Frame 1 is the still camera; each frame turns eye and up on by degrees / frames about the axis through the target,
/// so that after `frames` of them a full turn is closed.
struct Turntable {
  int frames = 1;
  double degrees = 360;            // right-handed: seen from the front about superior, towards the patient's left
  std::optional<glm::dvec3> axis;  // else the camera's up. unit: world
};

/// What stands still where a camera only turns.
enum class Pivot { kEye, kTarget };

/// Cameras at some frames: each is the still camera with what the key says instead. The orientation goes along a
/// spline of its own, and so do either the eye, the target being ahead of it, or the target, the eye being behind it.
struct CameraKeyframes {
  std::vector<Key<CameraSpec>> keys;
  /// Where nothing is said: the target where it is the same in all keys or no key has an eye; else the eye.
  std::optional<Pivot> pivot;
};

/// Camera to world, of frame 1 and those after it; the camera looks along -z, y is up. Projection, fov and height are
/// the still camera's. shape: for column vectors.
using CameraMatrices = std::vector<glm::dmat4>;

/// Empty: the camera stands still.
using CameraPath = std::variant<std::monostate, Turntable, CameraKeyframes, CameraMatrices>;

/// throws: Error kUsage where a key's camera cannot be used, keys have different projections or are half a turn apart,
/// or there is no matrix for the frame.
Camera cameraAt(const CameraPath& path, const CameraSpec& still, double frame, const VolumeGeometry& volume,
                const ImageSize& size);

/// Whether the matrix turns and moves and does nothing else.
bool isRigid(const glm::dmat4& world_from_camera);

}  // namespace kiln
