// Makes the pass and the engine of a frame: the only place that selects an engine.
#pragma once

#include <memory>
#include <vector>

#include "engine/engine_memory.h"
#include "frame/pass/frame_pass.h"
#include "frame/pass/frame_request.h"
#include "store/bricked_volume.h"

namespace kiln {

/// requires: the stores and `request` outlive the result; the first store is the volume, or all are, together. throws:
/// as FrameLevels.
std::unique_ptr<FramePass> makePass(const std::vector<const BrickedVolume*>& stores, const FrameRequest& request);

/// Returns the memory of the pass and its engine. `tile` is the size of the largest tile, `layers` whether the picture
/// has planes of depths or normals, is deep, or has shadows.
EngineMemory passMemory(const EngineChoice& engine, bool layers, const ImageSize& tile, std::int64_t brick_size);

}  // namespace kiln
