// Whether the names of a folder's slices show one stack without a gap.
#pragma once

#include "ingest/slice_directory.h"

namespace kiln {

/// Returns without effect where the names differ in one number only, and that number grows by a constant step from name
/// to name. Otherwise adds a sentence to `slices.notes` where `allow_irregular` is true.
/// requires: `slices.files` in natural order. throws: Error kFormat where `allow_irregular` is false, naming the two
/// slices around the first gap, or the stacks that the names form.
void requireOneStack(SliceFiles& slices, bool allow_irregular);

}  // namespace kiln
