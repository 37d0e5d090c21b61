// Files of AmiraMesh for the tests of the reader.
#pragma once

#include <string>

#include "support/files/foreign_files.h"

namespace kiln::test {

/// Returns the header of a field, up to its mark, which `mark` declares: "@1(HxZip,123)". The bounding box runs from
/// (1, 2, -3) to (5, 8, 3) mm.
std::string amiraHeader(const Extent3& dims, const std::string& encoding, const std::string& type,
                        const std::string& mark = "@1");
/// AmiraMesh's name of a type of 8, 16 or 32 bits, or of a float.
const char* amiraName(VoxelType type);
/// Returns a little-endian file.
std::string amiraFile(const ForeignVolume& volume);

}  // namespace kiln::test
