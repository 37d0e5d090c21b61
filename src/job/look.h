// Looks: words that stand for shading and tone together.
#pragma once

#include "job/render_job.h"

namespace kiln {

/// In the order of kLookNames (job/job_names.h).
enum class Look { kPlain, kStudio };

/// Sets shading and tone to those of the look.
void setLook(Look look, PictureOptions& picture);

}  // namespace kiln
