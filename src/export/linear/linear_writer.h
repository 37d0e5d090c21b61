// Voxels in one file as most formats store them: a header, then all voxels, x fastest, little-endian.
#pragma once

#include <filesystem>
#include <memory>

#include "base/file.h"
#include "export/output/pending_file.h"
#include "export/source/volume_writer.h"

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
  /// A header in a file of its own, which gets its name last; empty for a header before the voxels.
  std::filesystem::path header_file;
  std::vector<std::string> lines;
};

/// Opens the writer of the file `out`. throws: Error kIo, kNoSpace.
std::unique_ptr<VolumeWriter> linearWriter(const ExportedVolume& volume, const std::filesystem::path& out,
                                           LinearLayout layout, FileSystem& disk);

}  // namespace kiln
