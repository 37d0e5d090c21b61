// What a finished picture is laid over.
#pragma once

#include "image/image.h"
#include "job/render_job.h"

namespace kiln {

/// `image` holds the rows from `first_row` on of a picture of `rows`.
void layOverBackground(Image& image, int first_row, int rows, const Background& background);

}  // namespace kiln
