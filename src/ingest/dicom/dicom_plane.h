// The rules for the planes of frames that make up one volume, of a series and of a segmentation object alike.
#pragma once

#include <string>

#include "ingest/dicom/dicom_header.h"

namespace kiln {

/// Returns the reason why a frame with an orientation has no plane: "the orientation is not …"; empty if it has one.
std::string orientationFault(const DicomFrame& frame);

/// True if the frames are not parallel. requires: orientations.
bool isTurned(const DicomFrame& frame, const DicomFrame& against);

/// True if the pixels of the frames have different sizes, or `frame` has no size. requires: `than` has a spacing.
bool isResized(const DicomFrame& frame, const DicomFrame& than);

}  // namespace kiln
