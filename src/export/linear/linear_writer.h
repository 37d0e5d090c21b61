// Voxels in one file as most formats store them: a header, then all voxels, x fastest, little-endian.
#pragma once

#include <filesystem>
#include <memory>

#include "export/output/pending_file.h"
#include "export/source/export_formats.h"

namespace kiln {

/// Writes the rows of a box into a file that holds the volume from `offset` on.
void writeRows(PendingFile& file, std::uint64_t offset, const ExportedVolume& volume, const VoxelBox& box,
               std::span<const std::byte> voxels);

enum class Packing {
  kNone,
  kVoxels,  // the voxels are a gzip stream behind the header
  kAll,     // header and voxels are one gzip stream
};

struct LinearLayout {
  std::vector<std::byte> header;
  Packing packing = Packing::kNone;
  /// A file of their own for the voxels; empty for voxels behind the header. The header then gets its name last.
  std::filesystem::path voxels_file;
  std::vector<std::string> lines;
};

/// Opens the writer of a header and the voxels. throws: Error kExists, kIo, kNoSpace.
std::unique_ptr<VolumeWriter> linearWriter(const ExportTarget& target, const ExportedVolume& volume,
                                           LinearLayout layout);

}  // namespace kiln
