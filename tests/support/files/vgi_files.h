// VGI headers for the tests of the reader.
#pragma once

#include <string>

#include "support/files/foreign_files.h"

namespace kiln::test {

/// Returns the header of voxels in `a.vol` beside it, spaced by 0.5, 0.75 and 2 mm. `type` is VGI's name, such as
/// "unsigned integer".
std::string vgiHeader(const Extent3& dims, const std::string& type, int bits);

}  // namespace kiln::test
