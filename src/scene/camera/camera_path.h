// The camera of each frame: on a turntable, through keys, or from a list of matrices.
#pragma once

#include <glm/mat4x4.hpp>
#include <optional>
#include <variant>
#include <vector>

#include "grid/geometry.h"
#include "scene/camera/camera_spec.h"
#include "scene/keyframes.h"

namespace kiln {

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

/// throws: Error kUsage if a key's camera cannot be used, keys have different projections or are half a turn apart, or
/// the frame has no matrix.
Camera cameraAt(const CameraPath& path, const CameraSpec& still, double frame, const FramedBox& box,
                const ImageSize& size);

/// Returns whether the path fits the volume into the picture in all its cameras: none has an eye.
bool isFramed(const CameraPath& path, const CameraSpec& still);

/// True if the matrix consists of a rotation and a translation only.
bool isRigid(const glm::dmat4& world_from_camera);

}  // namespace kiln
