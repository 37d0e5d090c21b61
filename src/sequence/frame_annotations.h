// Annotations of the views of a drawn frame.
#pragma once

#include <memory>
#include <vector>

#include "annotate/annotator.h"
#include "sequence/opened_job.h"

namespace kiln {

/// throws: Error kUnsupported if the job has annotations with letters and there is no font.
void requireFont(const RenderJob& job);

/// One for each view, in order; null without annotations.
using Annotators = std::vector<std::unique_ptr<Annotator>>;
/// Returns the annotations of a frame of the job. `store` is the first volume.
Annotators annotatorsOf(const RenderJob& job, const DrawnFrame& drawn, const BrickedVolume& store);

}  // namespace kiln
