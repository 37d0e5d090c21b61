// A brick's voxels as the bytes of its OpenVDB file, and back. OpenVDB is known to brick_encode.cpp and
// brick_decode.cpp alone.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "grid/geometry.h"
#include "store/codec/brick_block.h"

namespace kiln {

/// What both directions need to know of a brick's surroundings.
struct BrickDesc {
  BrickKey key;
  VoxelType type = VoxelType::u8;
  std::int64_t brick_size = 0;
  std::int64_t apron = 0;
  VolumeGeometry geometry;  // of the key's level

  VoxelBox core() const { return coreBox(key.brick, brick_size, geometry.dims); }
  VoxelBox stored() const { return storedBox(core(), apron, geometry.dims); }
};

/// The bytes of the brick's file. shape: `voxels` covers frame.stored(), x fastest, in frame.type; `cells` as
/// BrickRanges has them. The same arguments give the same bytes. thread: safe. cost: about 20 ms for 128³ floats.
std::vector<std::byte> encodeBrick(const BrickDesc& frame, std::span<const std::byte> voxels,
                                   std::span<const ValueRange> cells);

/// Before a store of this geometry is begun: that its files have a place for the affine. throws: Error kUnsupported,
/// naming `source`.
void requireTransform(const VolumeGeometry& geometry, const std::filesystem::path& source);

/// Decodes what `encodeBrick` made. requires: the bytes have passed their checksum.
/// throws: Error kDamaged naming `path` where they are not such a file all the same.
BrickBlock decodeBrick(const BrickDesc& frame, std::span<const std::byte> file, const std::filesystem::path& path);

/// A constant brick, which has no file.
BrickBlock constantBrick(const BrickDesc& frame, double value);

/// The most memory `decodeBrick` holds beside the file's bytes, its result included. unit: bytes.
std::size_t decodeBytes(const BrickDesc& frame);

/// The most that the decoded brick takes. unit: bytes.
std::size_t blockBytes(const BrickDesc& frame);

/// "OpenVDB 10.0.1".
std::string containerVersion();

}  // namespace kiln
