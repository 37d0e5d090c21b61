// Composites a finished picture over its background.
#pragma once

#include "image/image.h"
#include "job/render_job.h"

namespace kiln {

/// Lays `image`, the rows from `first_row` on of a picture of `rows` rows, over the background.
void layOverBackground(Image& image, int first_row, int rows, const Background& background);

}  // namespace kiln
