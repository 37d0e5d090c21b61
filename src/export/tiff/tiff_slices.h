// A stack of TIFF files, one for each slice.
#pragma once

#include <memory>

#include "export/source/export_formats.h"

namespace kiln {

/// Opens the writer of a stack; a run of # in the name becomes the number of the slice, from 0 on. throws: Error
/// kExists, kNotFound (no folder), kIo.
std::unique_ptr<VolumeWriter> tiffSlicesWriter(const ExportTarget& target, const ExportedVolume& volume);

}  // namespace kiln
