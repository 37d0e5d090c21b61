// Finds the slices of one volume in a directory, in the order of their names.
#pragma once

#include <filesystem>
#include <string_view>
#include <utility>
#include <vector>

#include "ingest/source/slice_files.h"

namespace kiln {

/// Returns the format given by the first bytes. DICM at byte 128 takes precedence over a TIFF header at byte 0, which
/// DICOM files may have for viewers. shape: 512 bytes are enough.
SliceFormat sliceFormatOf(std::string_view first_bytes);

/// True if `a` comes before `b` in natural order: slice2 before slice10. Names that differ only in leading zeros are
/// ordered by their bytes.
bool naturallyBefore(std::string_view a, std::string_view b);

/// The files of a folder, each list in natural order; files that cannot be read and names that begin with a dot are
/// left out.
struct FolderFiles {
  std::vector<std::filesystem::path> tiff, dicom, other;
  /// Pictures, if they are the only slices of the folder.
  std::vector<std::pair<SliceFormat, std::vector<std::filesystem::path>>> pictures;
};
/// Searches subfolders for DICOM as slicesIn. throws: Error kIo if the folder cannot be read.
FolderFiles filesIn(const std::filesystem::path& directory);

/// Returns the slices in `directory`, found by file content; names that begin with a dot are ignored. Subfolders are
/// searched for DICOM only, if `directory` has a DICOMDIR or no slices of its own. An unreadable file is passed over
/// if no slice has its ending.
/// throws: Error kUnsupported if there are no slices, or slices of two formats; kFormat if a folder, pipe or
/// device has the ending of the slices; kIo if the folder or a possible slice cannot be read.
SliceFiles slicesIn(const std::filesystem::path& directory);

}  // namespace kiln
