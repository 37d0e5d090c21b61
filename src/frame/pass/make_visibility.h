// Makes the occlusion structure of a method.
#pragma once

#include <cstdint>

#include "occlusion/visibility.h"
#include "scene/camera/camera.h"
#include "scene/render_options.h"

namespace kiln {

/// Makes one structure for all bricks of a frame. requires: tile_px as in SpeedOptions.
std::unique_ptr<Visibility> makeVisibility(const VisibilityOptions& options, const ImageSize& size, int tile_px);

/// Makes the structure of `rect` alone, addressed in pixels of the whole frame; pixels outside are ignored. requires:
/// `rect` is not empty.
std::unique_ptr<Visibility> makeVisibilityOf(const PixelRect& rect, const VisibilityOptions& options, int tile_px);

/// Upper bound for the memory of `makeVisibility`. unit: bytes.
std::uint64_t visibilityBytes(VisibilityMethod method, const ImageSize& size);

}  // namespace kiln
