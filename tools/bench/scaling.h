// The scaling study: one object at several sizes, the picture the same. A frame's time and memory should not follow.
#pragma once

#include <filesystem>

#include "base/progress.h"
#include "bench/measurements.h"

namespace kiln {

/// Draws `store` as a render job does by default, first from an empty cache, then `repeat` times. throws: as
/// runRenderJob.
ScalingPoint measureScaling(const Suite& suite, const std::filesystem::path& store, Progress& progress);

}  // namespace kiln
