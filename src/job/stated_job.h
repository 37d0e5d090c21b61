// A job as a user would write it: only what differs from the defaults, with names of presets and framings, for programs
// that change jobs. `resolvedJobText` has every choice made instead.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "job/render_job.h"

namespace kiln {

/// Returns the job without its files (volumes, outputs, trace): `parseJob` of the object, with the names of the volumes
/// added, gives an equal job. Several volumes stand in `volumes`, in order. A transfer function from a file stays the
/// file's name.
nlohmann::ordered_json statedJson(const RenderJob& job);

/// Returns a choice of a transfer function as in a job: a preset, a file's name or an object.
nlohmann::ordered_json statedJson(const TransferFunctionChoice& choice);

}  // namespace kiln
