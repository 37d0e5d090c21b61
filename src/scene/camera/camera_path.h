// The camera of each frame: on a turntable, through keys, or from a list of matrices.
#pragma once

#include <glm/mat4x4.hpp>

#include "scene/camera/camera_spec.h"

namespace kiln {

/// throws: Error kUsage if a key's camera cannot be used, keys have different projections or are half a turn or more
/// apart, or the frame has no matrix.
Camera cameraAt(const CameraPath& path, const CameraSpec& still, double frame, const FramedBox& box,
                const ImageSize& size);

/// Returns whether the path fits the volume into the picture in all its cameras: none has an eye.
bool isFramed(const CameraPath& path, const CameraSpec& still);

/// True if the matrix consists of a rotation and a translation only.
bool isRigid(const glm::dmat4& world_from_camera);

}  // namespace kiln
