// Decodes one compressed frame of a DICOM file.
#pragma once

#include <cstddef>
#include <vector>

#include "ingest/dicom/dicom_header.h"

namespace kiln {

/// Returns the stored values of a frame, x fastest, in the machine's byte order. requires: pixels that are packed.
/// throws: Error kFormat if the frame cannot be decoded, kIo, kUnsupported without GDCM's module. thread: any.
/// cost: the frame's compressed bytes twice, and the frame.
std::vector<std::byte> decodeDicomFrame(const DicomHeader& header, std::int64_t frame);

}  // namespace kiln
