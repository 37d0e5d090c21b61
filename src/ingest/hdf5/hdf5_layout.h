// One data set of an HDF5 file: numbers, shape, and the places of voxels in the file.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ingest/chunks/chunked_array.h"
#include "ingest/codec/byte_codec.h"
#include "ingest/hdf5/hdf5_reader.h"
#include "ingest/source/json_node.h"

namespace kiln {

struct Hdf5Filter {
  int id = 0;
  std::vector<std::int64_t> values;
};

struct Hdf5Layout : ChunkLayout {
  std::string path;
  /// The numbers that the library gives, in the machine's byte order; `number` are those of the file.
  StoredNumber served;
  /// Begin of a contiguous data set in this file; nothing otherwise. unit: bytes.
  std::optional<std::uint64_t> offset;
  /// Filters of a chunk in the order of encoding.
  std::vector<Hdf5Filter> filters;
  /// The chunks in the order of the grid, the last axis fastest; empty unless Kiln reads the chunks itself.
  std::vector<hdf5::ChunkEntry> table;
  /// Further files that hold voxels, of a virtual or external data set.
  std::vector<std::filesystem::path> files;
};

/// Returns the layout of the data set at `path`. `offset` is set for contiguous data, `table` for chunks whose filters
/// Kiln decodes; all other voxels the HDF5 library has to read (virtual and external data sets, other filters, types
/// with unused bits, more chunks than are listed). throws: Error kFormat, kUnsupported if the data set holds no
/// numbers.
Hdf5Layout readHdf5Layout(Hdf5Reader& reader, const std::filesystem::path& file, const std::string& path,
                          std::uint64_t memory_bytes);

/// Returns the codecs of a chunk whose filters in `left_out` (bit i for filter i) were not applied; nothing if a filter
/// is unknown to Kiln.
std::optional<CodecChain> codecsOf(const std::vector<Hdf5Filter>& filters, std::uint64_t left_out,
                                   std::size_t number_bytes);

}  // namespace kiln
