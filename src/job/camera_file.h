// Cameras in files of other programs.
// Formats. ParaView's camera files (.pvcc) are XML lists of properties. Cameras of glTF 2.0 (.gltf, .glb) look along -z
// of their node with y up. Source: Khronos, glTF 2.0 specification, 3.10. Coordinates are the file's.
#pragma once

#include <filesystem>

#include "scene/camera/camera_spec.h"

namespace kiln {

/// Sets eye, target, up, projection, and fov or height from the file; of a glTF file from the first node with a camera.
/// The target of a glTF camera is as far away as the world's origin, since the format has no target.
/// throws: Error kNotFound, kIo; kFormat naming file and place; kUnsupported for another ending.
void readCameraFile(const std::filesystem::path& path, CameraSpec& camera);

}  // namespace kiln
