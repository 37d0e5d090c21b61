// Exports a store as one OpenVDB grid: value and place of every voxel, bit for bit.
#pragma once

#include <cstdint>
#include <filesystem>

#include "base/file.h"
#include "base/progress.h"
#include "export/source/exported_volume.h"

namespace kiln {

struct VdbReport {
  /// Active voxels of the grid, including voxels of active tiles.
  std::uint64_t voxels = 0;
  /// The length of the file. unit: bytes.
  std::uint64_t bytes = 0;
};

/// Writes `volume`, a part of `store`, to `out` as a single grid. At level 0 of a store made from OpenVDB, the grid has
/// the source's name, class, background, transform and coordinates. All other grids are in the level's coordinates;
/// without an OpenVDB source the name is "density", or "labels". A voxel is active if its bits differ from the
/// background's; in a level set, if |value| < background. Inactive voxels keep their values. Grid type: float for u8,
/// i8, u16, i16 and f32 (saved as half if every value survives), int32 for i32 and labels, int64 for u32, double for
/// f64. The file is on the disk before it gets its name. throws: Error kExists if `out` exists and `overwrite` is
/// false, kUnsupported (a volume beyond OpenVDB's coordinates, voxels too small for its transforms), kNoSpace, kIo,
/// kCancelled, and the exceptions of StoreReader::read. After an error `out` is as before. cost: the whole grid in
/// memory in sparse form; bricks equal to the background are free. kBudget if the grid exceeds `memory_bytes`.
VdbReport exportVdb(const StoreReader& store, const ExportedVolume& volume, const std::filesystem::path& out,
                    Progress& progress, FileSystem& disk = FileSystem::real(), bool overwrite = false,
                    std::uint64_t memory_bytes = UINT64_MAX);

}  // namespace kiln
