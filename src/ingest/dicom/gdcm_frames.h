// What Kiln and its module that holds GDCM agree on. Internal, and not installed.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "ingest/dicom/dicom_header.h"

/// Decodes the fragments of a frame into `out`, which has the frame's bytes. false where GDCM cannot, and then `why` is
/// what it says, if anything. thread: any.
extern "C" bool kilnDecodeByGdcm(const kiln::DicomPixels& pixels, const std::vector<std::vector<char>>& fragments,
                                 std::vector<std::byte>& out, std::string& why);
