// Binary segmentation objects: frames of single bits, each the part of one segment in one plane, as a volume of labels.
// Source: DICOM PS3.3, A.51 and C.8.20.
#pragma once

#include <memory>

#include "ingest/dicom/dicom_header.h"
#include "ingest/source/volume_source.h"

namespace kiln {

/// Returns the extents of the volume, with the planes that hold no segment and have no frame. requires: a binary
/// segmentation object. throws: Error kFormat if the planes of the frames are not parallel, or not at equal distances.
Extent3 segmentationDims(const DicomHeader& header);

/// Opens the volume whose labels are the numbers of the segments; of overlapping segments the greatest number counts.
/// `info` has the files and the format. requires and throws: as segmentationDims; Error kUsage for --spacing, kBudget
/// if a deflated object does not fit into `options.memory_bytes`.
std::unique_ptr<VolumeSource> openSegmentation(SourceInfo info, const DicomHeader& header,
                                               const SourceOptions& options);

}  // namespace kiln
