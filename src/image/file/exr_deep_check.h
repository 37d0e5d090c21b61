// Checks of deep scanline parts of EXR files, a row at a time: damaged files may claim any number of samples. Not
// installed: the declarations name OpenEXR.
#pragma once

#include <ImfMultiPartInputFile.h>

#include <cstdint>

namespace kiln {

/// throws: std::runtime_error where a row of a deep part has more samples than `memory_bytes` hold; what OpenEXR
/// throws.
void requireRowsWithin(Imf::MultiPartInputFile& file, int part, std::uint64_t memory_bytes);
/// Reads every sample of a deep part, a row at a time in at most `memory_bytes`. throws: as requireRowsWithin.
void checkDeepPart(Imf::MultiPartInputFile& file, int part, std::uint64_t memory_bytes);

}  // namespace kiln
