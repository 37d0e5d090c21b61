// Finds sections that no frame shows: all their cut faces look away from the eye, or nothing cuts the volume.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "job/frame/frame_scene.h"

namespace kiln {

/// "--section: no cut face looks at the camera …; look from …" if a volume has a section, planes cut the volume, and no
/// face of them is seen in any of the frames. "--section: no clip plane and no region cuts the volume …" if nothing
/// cuts the only volume in any of them; else "". Frames whose camera cannot be used are left out. cost: a scene for
/// each frame up to the first that shows a face.
std::string hiddenSectionText(const SceneOfJob& scenes, const std::vector<int>& frames, std::size_t volume,
                              const VolumeGeometry& geometry);

}  // namespace kiln
