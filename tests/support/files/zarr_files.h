// Arrays of Zarr 2, Zarr 3 and N5, put together from the formats' descriptions independently of the tested readers.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "support/files/foreign_files.h"

namespace kiln::test {

enum class ZarrVersion { kTwo, kThree, kN5 };
enum class ZarrCodec { kRaw, kGzip, kZlib, kZstd, kLz4, kBlosc, kBzip2, kXz };

inline constexpr ZarrCodec kZarrCodecs[] = {ZarrCodec::kRaw, ZarrCodec::kGzip,  ZarrCodec::kZlib,  ZarrCodec::kZstd,
                                            ZarrCodec::kLz4, ZarrCodec::kBlosc, ZarrCodec::kBzip2, ZarrCodec::kXz};

/// An axis of an array. Along an axis other than x, y and z the volume lies at one index of `count`; voxels at other
/// indices are complements.
struct ZarrTestAxis {
  char name = 'x';
  std::int64_t chunk = 4;
  std::int64_t count = 1, index = 0;
};

struct ZarrLayout {
  ZarrVersion version = ZarrVersion::kTwo;
  ZarrCodec codec = ZarrCodec::kRaw;
  std::vector<ZarrTestAxis> axes = {{'z', 2}, {'y', 3}, {'x', 4}};
  bool big_endian = false;
  /// Version 2: order F. Version 3: transpose. The order of axes in a chunk, the slowest first; empty for the array's.
  std::vector<int> stored_axes{};
  /// 0 for the version's default, which the header then leaves out.
  char separator = '\0';
  /// Version 3: chunks of a shard along each axis; 0 for no shards.
  std::int64_t chunks_in_shard = 0;
  bool index_at_start = false;
  /// Version 3: CRC-32C behind each chunk.
  bool checksum = false;
  /// The JSON of the fill value; chunks of nothing but `fill_byte` are left out where a fill value is stated.
  std::string fill = "0";
  char fill_byte = '\0';
  /// Version 3: the names of the axes are in the header.
  bool names_axes = false;
  /// More members of the header, with a comma in front: `, "attributes": {}`.
  std::string more{};
};

/// Writes the header and the chunks of an array, and returns its folder.
std::filesystem::path writeZarr(const std::filesystem::path& folder, const ForeignVolume& volume,
                                const ZarrLayout& layout = {});
/// The text of zarr.json, .zarray or attributes.json, and the name.
std::string zarrHeader(const ForeignVolume& volume, const ZarrLayout& layout);
const char* zarrHeaderName(ZarrVersion version);

/// Writes a file and the folders above it.
void writeBelow(const std::filesystem::path& path, std::string_view bytes);

}  // namespace kiln::test
