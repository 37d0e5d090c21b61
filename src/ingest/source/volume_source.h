// A foreign volume as the conversion reads it: a description, and the voxels box by box. Each format implements this
// interface; the folders above use the interface only.
#pragma once

#include <array>
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

class BrickOrder;

struct SourceInfo {
  /// Shown to the user: "NRRD", "raw, big-endian, 512 bytes skipped". Together with `geometry`, `type` and `vdb` it
  /// records every option that changes voxels.
  std::string format;
  std::vector<std::filesystem::path> files;
  /// Folders of files that belong to the volume and are too many to list: chunks.
  std::vector<std::filesystem::path> trees;
  VolumeGeometry geometry;
  VoxelType type = VoxelType::u8;
  VolumeClass volume_class = VolumeClass::kUnknown;
  /// Value of empty space if the source defines a background, else 0.
  double background = 0;
  std::optional<VdbOrigin> vdb;
  DeclaredLook look;
  /// Sentences for the user: files passed over, choices made.
  std::vector<std::string> notes;
};

/// Returns a note with the name of the opened file or folder in front.
std::string namedNote(const SourceInfo& info, const std::string& note);

enum class ReadOrder {
  kAnyBox,   // boxes in any order, from any thread
  kForward,  // each voxel once, in file order, by one thread at a time: a compressed stream
};

/// Chunks, strips, tiles or compressed slices.
struct DecodedBlocks {
  /// unit: voxels of the volume.
  Extent3 shape;
  /// Size of a decoded block, with voxels outside the volume. unit: bytes.
  std::uint64_t bytes = 0;
  /// Decodings so far; a block counts each time.
  std::uint64_t decodings = 0;

  /// The number of blocks in a volume.
  std::uint64_t countIn(const Extent3& dims) const {
    return static_cast<std::uint64_t>(((dims.x - 1) / shape.x + 1) * ((dims.y - 1) / shape.y + 1) *
                                      ((dims.z - 1) / shape.z + 1));
  }
};

/// thread: `order` states which reads may run together; other calls that change the source from one thread, with no
/// read under way.
class VolumeSource {
 public:
  virtual ~VolumeSource() = default;
  virtual const SourceInfo& info() const = 0;
  virtual ReadOrder order() const = 0;
  /// Fills `out` with the voxels of `box`.
  /// shape: x fastest, then y, then z, densely packed, in `info().type` and the machine's byte order.
  /// requires: box inside the volume; for kForward whole slices, or whole rows of one slice, that begin at the end
  /// of the last read.
  /// throws: Error kFormat (truncated or corrupt data, with the byte or slice), kIo.
  virtual void read(const VoxelBox& box, std::span<std::byte> out) = 0;
  /// Called after the last voxel. throws: Error if a stream's checksum or length contradicts the voxels read.
  virtual void finish() {}
  /// Temporary memory of one read beside `out`: a strip, tile or slice that is decoded as a whole. unit: bytes.
  virtual std::uint64_t decodeBytes() const { return 0; }
  /// Memory that the source holds while it is open, beside the cache of keepDecoded: a grid that is read whole. unit:
  /// bytes.
  virtual std::uint64_t heldBytes() const { return 0; }
  /// Returns the shape of box that costs least for its voxels: a slice, unless the source stores blocks or other axes.
  virtual Extent3 cheapBox() const { return {info().geometry.dims.x, info().geometry.dims.y, 1}; }
  /// Returns the blocks that are decoded as a whole; nothing for a source that decodes nothing, or other parts.
  virtual std::optional<DecodedBlocks> decodedBlocks() const { return std::nullopt; }
  /// Announces the boxes that will be read, so that the cache keeps the blocks needed next. requires: no read under
  /// way.
  virtual void willRead(const BrickOrder& /*order*/) {}
  /// Lets the source cache up to `bytes` of decoded data, which neighbouring boxes share; has no effect for kForward.
  /// requires: no read under way.
  virtual void keepDecoded(std::uint64_t /*bytes*/) {}
};

/// The directions in which the voxel axes x, y, z grow in a patient. shape: three letters, one of R L (right, left),
/// one of A P (anterior, posterior) and one of S I (superior, inferior); capital.
using AxisLetters = std::string;

enum class UpAxis { kZ, kY };

/// The user's words on how a volume lies in the world.
struct Placement {
  /// Voxel axes along which the volume is mirrored within its box.
  std::array<bool, 3> flip{};
  /// For a volume without a patient frame.
  std::optional<AxisLetters> axes;
  /// The world axis of the file that points up. The world of a store has z up.
  UpAxis up = UpAxis::kZ;
  /// For a file that states no unit of length: a name of length_unit.h. Empty: as the file.
  std::string unit;

  bool none() const { return *this == Placement(); }
  bool operator==(const Placement&) const = default;
};

/// The user's description of a source; empty values are taken from the file.
struct SourceOptions {
  std::optional<Extent3> dims;           // headerless raw
  std::optional<VoxelType> type;         // headerless raw
  std::optional<bool> big_endian;        // headerless raw; default little-endian
  std::uint64_t skip_bytes = 0;          // headerless raw
  std::optional<glm::dvec3> spacing;     // replaces the spacing of a file without directions
  std::optional<std::string> grid_name;  // OpenVDB
  std::optional<std::string> series;     // DICOM: the UID of the series, for directories of several series
  std::optional<std::string> channel;    // of several channels: a name, or a number from 0
  std::optional<std::int64_t> time;      // of several times: a number from 0
  std::optional<std::int64_t> scale;     // of several resolutions: 0 is the finest
  Placement placement;                   // the place in the world by the user
  bool allow_irregular = false;          // DICOM, TIFF: accept slices unequally spaced, tilted, different or missing
  bool luminance = false;                // TIFF: RGB colours as luminance
  /// Upper bound for VolumeSource::heldBytes, and for a header in memory. unit: bytes.
  std::uint64_t memory_bytes = UINT64_MAX;
};

}  // namespace kiln
