// Which files of a directory are one volume, and in which order.
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

/// The headers of the one series that `options` or the directory leaves; what was passed over goes to `notes`.
/// throws: Error kUsage where there are several and `options.series` names none of them (the message lists them);
/// kUnsupported where there is no image, or an image is of a kind that is not read; kFormat where a file cannot be
/// read, or slices differ in size or type.
std::vector<DicomHeader> readSeries(const SliceFiles& input, const SourceOptions& options,
                                    std::vector<std::string>& notes);

/// Puts the slices of a series in the order of their positions along the normal and says where they are: the exact
/// affine from the first to the last, sheared where they are tilted. Without positions: by instance number. Choices go
/// to `notes`. throws: Error kFormat naming the slices where they are tilted, missing or unequally far apart and
/// `options` does not allow it, where they are not parallel or have different pixels, or lie at the same place; kUsage
/// where --spacing is given and the files know better.
VolumeGeometry arrangeSlices(const std::filesystem::path& input, const std::vector<DicomHeader>& files,
                             const SourceOptions& options, std::vector<DicomSlice>& slices,
                             std::vector<std::string>& notes);

}  // namespace kiln
