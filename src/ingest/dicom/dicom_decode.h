// One compressed frame of a DICOM file as its pixels.
#pragma once

#include <cstddef>
#include <vector>

#include "ingest/dicom/dicom_header.h"

namespace kiln {

/// The stored values of a frame, x fastest, in the machine's order. requires: pixels that are packed. throws: Error
/// kFormat where they cannot be decoded, kIo, kUnsupported where GDCM's module is not there. thread: any. cost: the
/// frame's compressed bytes twice, and the frame.
std::vector<std::byte> decodeDicomFrame(const DicomHeader& header, std::int64_t frame);

}  // namespace kiln
