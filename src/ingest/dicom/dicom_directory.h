// A DICOMDIR: the list of the files on a CD, beside the folders that hold them. Source: DICOM PS3.10, 8; PS3.3, F.
#pragma once

#include <filesystem>
#include <string>

namespace kiln {

/// True for the name that the standard demands of a list.
bool isDicomDirectory(const std::filesystem::path& path);

/// A sentence for the user where files that the list at `path` names are not there; else empty. Folders are searched in
/// capital and in small letters, as a CD shows either. throws: Error kFormat where the list is no DICOM file; kIo.
std::string missingOf(const std::filesystem::path& path);

}  // namespace kiln
