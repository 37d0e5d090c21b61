// The image-space structure that a job's words name.
#pragma once

#include <cstdint>

#include "occlusion/visibility.h"
#include "scene/camera/camera.h"
#include "scene/render_options.h"

namespace kiln {

/// One structure for all bricks of a frame. requires: tile_px as SpeedOptions has it.
std::unique_ptr<Visibility> makeVisibility(const VisibilityOptions& options, const ImageSize& size, int tile_px);

/// The same of `rect` alone, which is asked about in pixels of the whole frame; what is beside it counts for nothing.
/// requires: not empty.
std::unique_ptr<Visibility> makeVisibilityOf(const PixelRect& rect, const VisibilityOptions& options, int tile_px);

/// What `makeVisibility` takes, or a little more. unit: bytes.
std::uint64_t visibilityBytes(VisibilityMethod method, const ImageSize& size);

}  // namespace kiln
