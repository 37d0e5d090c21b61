// MRC and MGH files. Each number of the header is put at its documented offset, independently of the tested readers.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "support/files/foreign_files.h"

namespace kiln::test {

using HeaderChange = std::function<void(std::string& header)>;

/// A header as mrcfile writes it: a cell of 5 x 6 x 12 ångström, so voxels of 1 x 1.5 x 4 at 5 x 4 x 3 voxels.
std::string mrcHeader(const Extent3& dims, int mode, bool big = false);
/// requires: a type that MRC has, as does mghFile for MGH.
std::string mrcFile(const ForeignVolume& volume, bool big = false, const HeaderChange& change = {});

/// Sagittal directions, voxels of 2 x 3 x 4 mm, the middle at (10, 20, 30). The slices are shared by `frames`.
std::string mghFile(const ForeignVolume& volume, std::int32_t frames = 1, const HeaderChange& change = {});

}  // namespace kiln::test
