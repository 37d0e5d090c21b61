// Writes a store, or a part of it, as a file of another format.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/progress.h"
#include "export/vdb/vdb_values.h"
#include "scene/transfer/transfer_function.h"
#include "store/store_reader.h"

namespace kiln {

class FileSystem;

struct ExportRequest {
  /// The ending of the name decides the format.
  std::filesystem::path out;
  int level = 0;
  /// The part that is written, in voxels of level 0; everything if not given.
  std::optional<VoxelBox> region;
  /// Replaces files that are there.
  bool overwrite = false;
  /// Continues an interrupted export, for formats of many files.
  bool resume = false;
  /// Compresses a format that may be compressed or not.
  bool compress = false;
  /// OpenVDB: the values of the grid.
  VdbValues values;
  /// OpenVDB: the function whose densities and colours are written instead of values.
  std::optional<TransferFunction> baked;
  /// OpenVDB: the number of files side by side.
  int tiles = 1;
  /// Upper bound of the memory of the whole export: index, bricks and buffers. unit: bytes.
  std::uint64_t memory_bytes = UINT64_MAX;
  FileSystem* disk = nullptr;  // null: the operating system's
};

struct ExportReport {
  /// "64 x 64 x 32 voxels of u16".
  std::string contents;
  /// unit: bytes.
  std::uint64_t bytes = 0;
  /// Further lines for the user: the command that reads a file without a header.
  std::vector<std::string> lines;
};

/// Writes the voxels of a level exactly. An output has its name only when it is whole and on the disk.
/// requires: the store has the level.
/// throws: Error kUsage (an ending of no format, an option that the format does not have, a region beside the volume),
/// kExists, kUnsupported, kBudget (with the least memory), kNoSpace, kIo, kCancelled, and the exceptions of
/// StoreReader::read. After an error the output is as before.
/// cost: a box of voxels, a brick for each thread and the index in memory; OpenVDB needs the whole grid.
ExportReport exportStore(const StoreReader& store, const ExportRequest& request, Progress& progress);

/// Checks the ending and the options that depend on it, before the store is opened. throws: Error kUsage.
void requireExportFormat(const ExportRequest& request);

/// The endings of all formats, ".nrrd, .nii".
std::string exportEndings();

}  // namespace kiln
