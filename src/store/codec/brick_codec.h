// Encodes a brick's voxels as an OpenVDB file and decodes the file. Only brick_encode.cpp and brick_decode.cpp use
// OpenVDB.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "grid/geometry.h"
#include "store/codec/brick_block.h"

namespace kiln {

struct Manifest;

/// Position and type of a brick, for encoding and decoding.
struct BrickDesc {
  BrickKey key;
  VoxelType type = VoxelType::u8;
  std::int64_t brick_size = 0;
  std::int64_t apron = 0;
  VolumeGeometry geometry;  // geometry of the key's level

  VoxelBox core() const { return coreBox(key.brick, brick_size, geometry.dims); }
  VoxelBox stored() const { return storedBox(core(), apron, geometry.dims); }
};

/// Returns a brick of a volume. requires: the volume has the level.
BrickDesc descOf(const Manifest& manifest, const BrickKey& key);

/// Returns the bytes of the brick's file. shape: `voxels` covers frame.stored(), x fastest, in frame.type; `cells` as
/// in BrickRanges. Equal arguments give equal bytes. thread: safe. cost: about 20 ms for 128³ floats.
std::vector<std::byte> encodeBrick(const BrickDesc& frame, std::span<const std::byte> voxels,
                                   std::span<const ValueRange> cells);

/// Checks that brick files can hold the affine of the geometry. Call before a store is begun. throws: Error
/// kUnsupported, naming `source`.
void requireTransform(const VolumeGeometry& geometry, const std::filesystem::path& source);

/// Decodes a file of `encodeBrick`. requires: the bytes match their checksum.
/// throws: Error kDamaged, naming `path`, if the bytes are nevertheless no brick file.
BrickBlock decodeBrick(const BrickDesc& frame, std::span<const std::byte> file, const std::filesystem::path& path);

/// Returns a constant brick, which has no file.
BrickBlock constantBrick(const BrickDesc& frame, double value);

/// Upper bound of the memory of `decodeBrick` beside the file's bytes, including the result. unit: bytes.
std::size_t decodeBytes(const BrickDesc& frame);

/// Upper bound of the memory of the decoded brick. unit: bytes.
std::size_t blockBytes(const BrickDesc& frame);

/// "OpenVDB 10.0.1".
std::string containerVersion();

}  // namespace kiln
