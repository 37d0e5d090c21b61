// The scaling study: one object at several volume sizes, with equal pictures. A frame's time and memory should not grow
// with the volume.
#pragma once

#include <filesystem>

#include "base/progress.h"
#include "bench/measurements.h"

namespace kiln {

/// Draws `store` with the defaults of a render job, first from an empty cache, then `repeat` times. throws: as
/// runRenderJob.
ScalingPoint measureScaling(const Suite& suite, const std::filesystem::path& store, Progress& progress);

}  // namespace kiln
