// Tests that the names of a folder's slices form one stack without gaps.
#pragma once

#include "ingest/slice_directory.h"

namespace kiln {

/// Returns without effect if the names differ in one number only, and the number grows by a constant step from name
/// to name. Otherwise adds a sentence to `slices.notes` if `allow_irregular` is true.
/// requires: `slices.files` in natural order. throws: Error kFormat if `allow_irregular` is false, naming the two
/// slices around the first gap, or the stacks that the names form.
void requireOneStack(SliceFiles& slices, bool allow_irregular);

}  // namespace kiln
