// A folder that an export to OME-Zarr may replace.
#pragma once

#include <filesystem>

namespace kiln {

/// Checks that a folder is an OME-Zarr image of Zarr 3 and nothing else: the headers of the image and of its scales,
/// and their chunks. Labels, further images, links and other files are nobody's to remove. throws: Error kExists,
/// naming the first other entry. cost: visits every file of the folder.
void requireOmeContainer(const std::filesystem::path& folder);

}  // namespace kiln
