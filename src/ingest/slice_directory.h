// A directory as the slices of one volume: which of its files they are, and in which order their names put them.
#pragma once

#include <string_view>

#include "ingest/source/slice_files.h"

namespace kiln {

/// What the first bytes of a file say it is: DICM at byte 128 comes before a TIFF header at byte 0, which such a file
/// may have for viewers. shape: 512 bytes are enough.
SliceFormat sliceFormatOf(std::string_view first_bytes);

/// True where `a` comes before `b` as people count: slice2 before slice10. Names that differ in leading zeros only are
/// in the order of their bytes.
bool naturallyBefore(std::string_view a, std::string_view b);

/// The slices in `directory`, by what its files hold; names that begin with a dot do not count. Folders in it are
/// searched, for DICOM only, where it has a DICOMDIR or no slices of its own.
/// A file that cannot be read is passed over where no slice has its name's ending. throws: Error kUnsupported where
/// there are none, or of both formats; kFormat where a folder, pipe or device has the ending of the slices; kIo where a
/// file that may be a slice cannot be read, or the folder.
SliceFiles slicesIn(const std::filesystem::path& directory);

}  // namespace kiln
