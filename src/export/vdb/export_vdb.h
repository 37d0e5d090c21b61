// Exports a part of a store as one grid of OpenVDB or NanoVDB: value and place of every voxel, bit for bit unless the
// request loosens it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "base/file/file.h"
#include "base/progress.h"
#include "export/source/exported_volume.h"
#include "export/vdb/vdb_values.h"
#include "scene/transfer/transfer_function.h"

namespace kiln {

/// A kind of file (grid_archive.h).
class GridArchive;
/// Returns the archive of .vdb files.
const GridArchive& openVdbArchive();
/// Returns the archive of .nvdb files, compressed by zlib or not. throws: Error kUnsupported if this build has no
/// NanoVDB.
const GridArchive& nanoVdbArchive(bool compress);

struct VdbRequest {
  const GridArchive& archive = openVdbArchive();
  std::filesystem::path out;
  bool overwrite = false;
  std::uint64_t memory_bytes = UINT64_MAX;
  VdbValues values = {};
  /// Bakes two grids for renderers in place of the values: `density`, the extinction per world unit, and `Cd`, the
  /// colour in linear light. The function's unit of length is set.
  std::optional<TransferFunction> baked = {};
};

struct VdbReport {
  /// Active voxels of the grid, including voxels of active tiles.
  std::uint64_t voxels = 0;
  /// The length of the file. unit: bytes.
  std::uint64_t bytes = 0;
  /// The largest difference between a voxel and its value in the grid.
  double largest_error = 0;
};

/// Writes `volume`, a part of `store`, as a single grid. At level 0 of a store made from OpenVDB, the grid has the
/// source's name, class, background, transform and coordinates. All other grids are in the level's coordinates; without
/// an OpenVDB source the name is "density", or "labels".
/// A voxel is active if its bits differ from the background's; in a level set, if |value| < background. Inactive voxels
/// keep their values.
/// Grid type, if exact: float for u8, i8, u16, i16 and f32 (saved as half if every value survives), int32 for i32 and
/// labels, int64 for u32, double for f64.
/// The file is on the disk before it gets its name.
/// throws: Error kExists if the file exists and must not be replaced; kUsage (values that the grid cannot hold);
/// kUnsupported (a volume beyond OpenVDB's coordinates, voxels too small for its transforms); kNoSpace, kIo,
/// kCancelled, and the exceptions of StoreReader::read. After an error the output is as before. cost: the whole grid in
/// memory in sparse form; bricks equal to the background are free. kBudget if the grid exceeds the memory.
VdbReport exportVdb(const StoreReader& store, const ExportedVolume& volume, const VdbRequest& request,
                    Progress& progress, FileSystem& disk = FileSystem::real());

}  // namespace kiln
