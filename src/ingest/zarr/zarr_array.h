// An array of a Zarr or N5 container: shape, places of chunks, and codecs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "ingest/chunks/array_volume.h"
#include "ingest/chunks/chunked_array.h"
#include "ingest/codec/byte_codec.h"
#include "ingest/source/json_node.h"

namespace kiln {

/// The name of a chunk's file: the chunk's index in the grid, joined.
struct ChunkNames {
  /// A separator that the header does not state.
  static constexpr char kOpen = '\0';
  std::string prefix;
  char separator = '/';
  /// True for N5, which writes the fastest axis first.
  bool reversed = false;
  std::filesystem::path of(const AxisNumbers& index) const;
};

/// A shard is a file of several chunks with an index: offset and length of each. Source: Zarr 3, sharding_indexed.
struct Sharding {
  CodecChain index_codecs;
  bool index_at_end = true;
  bool index_big_endian = false;
};

struct ZarrArray : ChunkLayout {
  std::filesystem::path folder;
  /// The file that describes the array.
  std::filesystem::path header;
  /// "Zarr v2", "Zarr v3" or "N5".
  std::string format;
  /// Shape of the voxels of a file: a shard or a chunk.
  AxisNumbers file_shape;
  ChunkNames names;
  CodecChain codecs;
  std::optional<Sharding> sharding;
  /// True if each chunk has N5's header, and chunks at the border of the array are cut.
  bool has_block_headers = false;
  /// Empty if the header does not name the axes.
  std::vector<std::string> axis_names;
  /// The attributes: `attributes`, `.zattrs`, or N5's whole header.
  std::optional<JsonNode> attributes;

  /// As errors name the array.
  ArrayName name() const { return {folder, header, shape}; }
  std::uint64_t chunkBytes() const;
  std::uint64_t chunksInFile() const;
};

/// The file in `folder` that describes a Zarr or N5 array or group; empty if there is none.
std::filesystem::path zarrHeaderIn(const std::filesystem::path& folder);

/// The attributes of an array or group: those of Zarr v3, `.zattrs` of v2, N5's header; nothing if there are none.
std::optional<JsonNode> zarrAttributes(const std::filesystem::path& folder, std::uint64_t memory_bytes);

/// Returns the array in `folder`; nothing if the folder holds a group or no header at all.
/// throws: Error kFormat, kUnsupported (naming the codec, type or grid), kIo.
std::optional<ZarrArray> readZarrArray(const std::filesystem::path& folder, std::uint64_t memory_bytes);

// Codecs with equal settings in versions 2 and 3.

/// The filter "shuffle" of numcodecs; 4 bytes a number unless `element_size` states another size.
std::unique_ptr<ByteCodec> shuffleOf(const std::optional<JsonNode>& element_size);
/// The compressor "lzma" of numcodecs, whose formats are numbered as in Python's module lzma. throws: Error
/// kUnsupported for formats other than xz.
std::unique_ptr<ByteCodec> lzmaOf(const std::optional<JsonNode>& format);
/// True for a filter that only rounded numbers before they were written.
bool isRounding(const std::string& codec);

// One reader per version, for readZarrArray.
ZarrArray readZarr2(const JsonNode& header);
std::optional<ZarrArray> readZarr3(const JsonNode& header);
std::optional<ZarrArray> readN5(const JsonNode& header);

}  // namespace kiln
