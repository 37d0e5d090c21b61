// Compares the size in a compressed frame's own header with the DICOM header. GDCM trusts the DICOM header and reads or
// writes beyond the pixels if the two differ.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "ingest/dicom/dicom_header.h"

namespace kiln {

/// Returns the reason why these bytes, of all fragments, cannot be a frame of these pixels ("is 16 x 16 of 8 bits and 1
/// component, but the header says …"); empty if no fault is found. Tests sizes, bits and components of JPEG, JPEG-LS
/// and JPEG 2000, and the lengths of run-length segments. Damage behind the headers is not found. source: ITU-T T.81
/// B.2.2, T.87 C.2.2, T.800 A.5.1; DICOM PS3.5 annex G.
std::string codestreamFault(const DicomPixels& pixels, std::span<const std::byte> frame);

}  // namespace kiln
