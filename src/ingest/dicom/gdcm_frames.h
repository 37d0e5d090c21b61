// The interface between Kiln and its GDCM module. Internal, and not installed.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "ingest/dicom/dicom_header.h"

/// Decodes the fragments of a frame into `out`, which has the frame's size. Returns false if GDCM fails; `why` is
/// then GDCM's message, if there is a message. thread: any.
extern "C" bool kilnDecodeByGdcm(const kiln::DicomPixels& pixels, const std::vector<std::vector<char>>& fragments,
                                 std::vector<std::byte>& out, std::string& why);
