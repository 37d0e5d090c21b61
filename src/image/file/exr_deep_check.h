// Checks deep scanline parts of EXR files row by row: a damaged file may claim any number of samples. Not installed:
// the declarations name OpenEXR.
#pragma once

#include <ImfMultiPartInputFile.h>

#include <cstdint>

namespace kiln {

/// throws: std::runtime_error if a row of a deep part has more samples than fit `memory_bytes`; any exception of
/// OpenEXR.
void requireRowsWithin(Imf::MultiPartInputFile& file, int part, std::uint64_t memory_bytes);
/// Reads every sample of a deep part, row by row in at most `memory_bytes`. throws: as requireRowsWithin.
void checkDeepPart(Imf::MultiPartInputFile& file, int part, std::uint64_t memory_bytes);

}  // namespace kiln
