// The manifest of a volume whose bricks are being made, on disk or in memory.
#pragma once

#include "convert/convert.h"

namespace kiln {

/// throws: Error kUsage for a size of bricks that no volume has, or labels that are no whole numbers or
/// are to be rounded.
void requireBricks(const SourceInfo& info, const ConvertOptions& options);
/// Returns everything but the results of the bricks.
Manifest draftOf(const SourceInfo& info, const ConvertOptions& options);

}  // namespace kiln
