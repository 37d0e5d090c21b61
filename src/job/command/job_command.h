// A job as options of a command line.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "job/render_job.h"

namespace kiln {

/// Returns options of `kiln render` that make the job of its volume, but for names of files and --size; nothing if
/// options cannot state the job. The options are tried out: an equal job results, number by number.
std::optional<std::vector<std::string>> optionsOf(const RenderJob& job);

}  // namespace kiln
