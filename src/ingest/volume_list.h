// Lists the volumes of a file or folder: grids of OpenVDB, DICOM series, TIFF pages, scales of Zarr, and files of one
// volume.
#pragma once

#include <filesystem>
#include <vector>

#include "ingest/source/listed_volume.h"
#include "ingest/source/volume_source.h"

namespace kiln {

/// Returns the volumes of `input`: of a file; of a folder, its series, its stacks of slices, its folders of Zarr and
/// N5, and its other volume files. throws: as openSource for a file; kUnsupported for a folder without a volume. cost:
/// reads headers, of slices one for each stack, of DICOM all.
std::vector<ListedVolume> volumesIn(const std::filesystem::path& input, const SourceOptions& options = {});

}  // namespace kiln
