// A store, given back as one OpenVDB grid that other programs open: the values and the place of every voxel, bit for
// bit.
#pragma once

#include <cstdint>
#include <filesystem>

#include "base/file.h"
#include "base/progress.h"
#include "store/store_reader.h"

namespace kiln {

struct ExportReport {
  /// Active voxels of the grid, those of tiles included.
  std::uint64_t voxels = 0;
  /// The length of the file. unit: bytes.
  std::uint64_t bytes = 0;
};

/// Writes `level` of `store` to `out` as one grid: that of the source with its name, class, background, transform and
/// coordinates where the source was OpenVDB; else "density" at the store's own coordinates. (A level above 0 has
/// coordinates of its own in either case.) A voxel is active where its bits differ from the background's, in a level
/// set where |value| < background; an inactive one keeps its value. Grid type: float for u8, i8, u16, i16 and f32
/// (saved as half where every value survives), int32 for i32, int64 for u32, double for f64. requires: a level that the
/// store has. throws: Error kExists where `out` is there and `overwrite` is false, kUnsupported (a volume beyond
/// OpenVDB's coordinates, voxels too small for its transforms), kNoSpace, kIo, kCancelled, and what StoreReader::read
/// throws; nothing is then left at `out`, and what was there before is untouched. The file is on the disk before it
/// gets its name. cost: the whole grid is held in memory in its sparse form, bricks equal to the background free;
/// kBudget where it takes more than `memory_bytes`.
ExportReport exportVdb(const StoreReader& store, int level, const std::filesystem::path& out, Progress& progress,
                       FileSystem& disk = FileSystem::real(), bool overwrite = false,
                       std::uint64_t memory_bytes = UINT64_MAX);

}  // namespace kiln
