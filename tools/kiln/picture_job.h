// The job in the header of a picture of Kiln's, as INPUT of render.
#pragma once

#include <filesystem>

#include "job/render_job.h"

namespace kiln::tool {

/// Returns whether the name is a picture's, .exr or .png.
bool isPicture(const std::filesystem::path& path);

/// Returns the picture's job. A volume with a relative name is sought from the picture's folder, then by its file name
/// beside the picture, then from the current folder; an absolute name first where it was, then beside the picture.
/// throws: Error kUsage for a picture without a job; kNotFound naming all places of a volume that is in none.
RenderJob jobOfPicture(const std::filesystem::path& picture);

}  // namespace kiln::tool
