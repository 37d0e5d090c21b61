// The axes of a data set by the attributes and coordinates around it.
#pragma once

#include "ingest/hdf5/hdf5_image.h"

namespace kiln {

/// Sets names, sizes and places of the axes of `out.path`, and adds notes on what is missing. requires: a data set.
/// throws: Error kFormat if attributes contradict the format that they name.
void describeAxes(const Hdf5Objects& objects, Hdf5Image& out);

}  // namespace kiln
