// A file or folder that takes the voxels of a volume box by box. Each format implements this interface.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "export/source/exported_volume.h"

namespace kiln {

/// The boxes that a writer takes.
struct BoxRule {
  enum class Kind {
    kRows,    // whole rows, in any order
    kSlices,  // whole slices, in ascending order
    kGrid,    // boxes of `grid`, counted from the first voxel of the volume
  };
  Kind kind = Kind::kRows;
  Extent3 grid;
};

struct WrittenFiles {
  /// unit: bytes.
  std::uint64_t bytes = 0;
  /// Lines for the user: the command that reads a file without a header.
  std::vector<std::string> lines;
};

class VolumeWriter {
 public:
  virtual ~VolumeWriter() = default;
  /// The volumes of the file: a single volume, or levels of a pyramid.
  virtual const std::vector<ExportedVolume>& volumes() const = 0;
  virtual BoxRule boxes(const ExportedVolume& volume) const = 0;
  /// Memory of `write` beside the box, with this number of threads. unit: bytes.
  virtual std::uint64_t workBytes(std::uint64_t box_bytes, unsigned threads) const = 0;
  /// True if an earlier run wrote the box.
  virtual bool holds(const ExportedVolume& /*volume*/, const VoxelBox& /*box*/) { return false; }
  /// Takes the voxels of a box. shape: x fastest, densely packed, in the volume's type. throws: Error kNoSpace, kIo.
  virtual void write(const ExportedVolume& volume, const VoxelBox& box, std::span<const std::byte> voxels) = 0;
  /// Called after a failure. Keeps finished parts for a later run and returns a sentence about them; empty if nothing
  /// is kept.
  virtual std::string keepParts() { return {}; }
  /// Writes the rest, brings all files onto the disk and gives them their names. A writer that is destroyed before
  /// leaves the output as it was. throws: Error kNoSpace, kIo.
  virtual WrittenFiles finish() = 0;
};

}  // namespace kiln
