// Options that were given and have no effect.
#pragma once

#include <string>
#include <vector>

#include "job/command/given_flags.h"
#include "job/render_job.h"

namespace kiln {

/// Returns a warning for each given flag without effect on the files of the job: "--exr-type: has no effect here;
/// applies to EXR pictures (none is written)". `job`: with the flags applied.
std::vector<std::string> idleFlags(const GivenFlags& flags, const RenderJob& job);

}  // namespace kiln
