// A DICOMDIR: the list of the files on a CD, beside the folders with the files. Source: DICOM PS3.10, 8; PS3.3, F.
#pragma once

#include <filesystem>
#include <string>

namespace kiln {

/// True for the file name that the standard requires for the list.
bool isDicomDirectory(const std::filesystem::path& path);

/// Returns a note for the user if files named by the list at `path` are missing; else empty. Names are searched in
/// capital and in small letters, as a CD shows either.
/// throws: Error kFormat if the list is no DICOM file; kIo.
std::string missingOf(const std::filesystem::path& path);

}  // namespace kiln
