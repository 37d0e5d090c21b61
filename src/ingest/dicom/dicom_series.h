// Selects the files of a directory that form one volume, and orders their slices.
#pragma once

#include "ingest/dicom/dicom_header.h"
#include "ingest/source/slice_files.h"
#include "ingest/source/volume_source.h"

namespace kiln {

/// One slice: a frame of a file.
struct DicomSlice {
  std::size_t file = 0;
  std::int64_t frame = 0;
};

/// Returns the headers of the series chosen by `options`, or of the only series; `notes` lists the objects passed over.
/// throws: Error kUsage if there are several series and `options.series` names none of them (the message lists
/// them); kUnsupported if there is no image, or an image of an unsupported kind; kFormat if a file cannot be
/// read, or slices differ in size or type.
std::vector<DicomHeader> readSeries(const SliceFiles& input, const SourceOptions& options,
                                    std::vector<std::string>& notes);

/// Sorts the slices of a series by their positions along the normal. Returns the exact affine from the first slice to
/// the last, sheared if the slices are tilted. Slices without positions are sorted by instance number. `notes` lists
/// the choices made.
/// throws: Error kFormat naming the slices if they are tilted, missing or unequally spaced and `options` does not
/// allow it; if they are not parallel, have different pixels, or lie at equal places; kUsage if --spacing is
/// given for files that have a spacing.
VolumeGeometry arrangeSlices(const std::filesystem::path& input, const std::vector<DicomHeader>& files,
                             const SourceOptions& options, std::vector<DicomSlice>& slices,
                             std::vector<std::string>& notes);

}  // namespace kiln
