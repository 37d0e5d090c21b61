// What a compressed frame says of itself, held against what its DICOM file says: GDCM trusts the file, and reads or
// writes beyond the pixels where the two differ.
#pragma once

#include <string>
#include <vector>

#include "ingest/dicom/dicom_header.h"

namespace kiln {

/// Why these fragments are no frame of these pixels: "is 16 x 16 of 8 bits and 1 component, but the header says …";
/// empty where nothing says so. Looks at sizes, bits and components of JPEG, JPEG-LS and JPEG 2000, and at the lengths
/// of run-length segments; damage behind those it does not see. Source: ITU-T T.81 B.2.2, T.87 C.2.2, T.800 A.5.1;
/// DICOM PS3.5 annex G.
std::string codestreamFault(const DicomPixels& pixels, const std::vector<std::vector<char>>& fragments);

}  // namespace kiln
