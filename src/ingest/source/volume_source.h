// A foreign volume as the conversion sees it: what it is, and its voxels box by box. One file a format stands behind
// this interface; nothing above it knows which.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "grid/coords.h"
#include "grid/geometry.h"
#include "grid/volume_info.h"
#include "grid/voxel_type.h"

namespace kiln {

struct SourceInfo {
  /// For people: "NRRD", "raw, big-endian, 512 bytes skipped". With `geometry`, `type` and `vdb` it holds every option
  /// that the voxels depend on.
  std::string format;
  std::vector<std::filesystem::path> files;
  VolumeGeometry geometry;
  VoxelType type = VoxelType::u8;
  VolumeClass volume_class = VolumeClass::kUnknown;
  /// The value of empty space where the source defines one, else 0.
  double background = 0;
  std::optional<VdbOrigin> vdb;
  /// Sentences the user should see: files passed over, choices made for them.
  std::vector<std::string> notes;
};

/// A note of a source behind the name of the file or folder that was opened.
std::string namedNote(const SourceInfo& info, const std::string& note);

enum class ReadOrder {
  kAnyBox,   // boxes in any order, from any thread
  kForward,  // each voxel once, in the order of the file, by one thread at a time: a compressed stream
};

class VolumeSource {
 public:
  virtual ~VolumeSource() = default;
  virtual const SourceInfo& info() const = 0;
  virtual ReadOrder order() const = 0;
  /// Fills `out` with the voxels of `box`. shape: x fastest, then y, then z, densely packed, in `info().type` and the
  /// machine's byte order. requires: box inside the volume; for kForward whole slices, or whole rows of one slice, that
  /// start where the last read ended. throws: Error kFormat (truncated or corrupt data, with the byte or slice), kIo.
  virtual void read(const VoxelBox& box, std::span<std::byte> out) = 0;
  /// After the last voxel: throws where a stream's own checksum or length does not agree with what was read.
  virtual void finish() {}
  /// What one read holds for a moment beside its `out`: a strip, a tile or a slice that is packed as one. unit: bytes.
  virtual std::uint64_t decodeBytes() const { return 0; }
  /// The memory that the source holds as long as it is open, beside what keepDecoded allows: a grid that is read whole.
  /// unit: bytes.
  virtual std::uint64_t heldBytes() const { return 0; }
  /// Lets the source keep up to `bytes` of what it decoded, as neighbouring boxes share it; of no use to kForward.
  /// requires: no read under way.
  virtual void keepDecoded(std::uint64_t /*bytes*/) {}
};

/// What a user may say of a source; empty means "as the file says".
struct SourceOptions {
  std::optional<Extent3> dims;           // headerless raw
  std::optional<VoxelType> type;         // headerless raw
  std::optional<bool> big_endian;        // headerless raw; little-endian where not given
  std::uint64_t skip_bytes = 0;          // headerless raw
  std::optional<glm::dvec3> spacing;     // replaces the spacing of a file without directions
  std::optional<std::string> grid_name;  // OpenVDB
  std::optional<std::string> series;     // DICOM: the UID of the series where there are several
  bool allow_irregular = false;          // DICOM, TIFF: slices unequally far apart, tilted, unlike others or missing
  /// The most that the source may hold (VolumeSource::heldBytes). unit: bytes.
  std::uint64_t memory_bytes = UINT64_MAX;
};

}  // namespace kiln
