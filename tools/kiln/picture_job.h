// The job in the header of a picture of Kiln's, as INPUT of render.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "job/render_job.h"

namespace kiln::tool {

/// Returns the JSON of the job in the picture's header, if any, with the type and the compression of the file, so that
/// the job draws an equal file. throws: Error kBudget if the header exceeds
/// `memory_bytes`; kFormat.
std::optional<std::string> jobTextOf(const std::filesystem::path& picture, std::uint64_t memory_bytes);

/// Returns the picture's job. A volume with a relative name is sought from the folder that the header names, then from
/// the picture's folder, beside the picture and from the current folder. An absolute name is sought first as it is,
/// then beside the picture. throws: as jobTextOf; Error kUsage for a picture without a job; kNotFound naming all places
/// of a volume that is in none.
RenderJob jobOfPicture(const std::filesystem::path& picture, std::uint64_t memory_bytes);

}  // namespace kiln::tool
