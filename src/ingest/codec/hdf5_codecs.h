// Filters of HDF5 that Zarr lacks.
#pragma once

#include <memory>

#include "ingest/codec/byte_codec.h"

namespace kiln {

/// Fletcher's checksum in the four bytes behind the data.
std::unique_ptr<ByteCodec> fletcher32Codec();
/// LZF, h5py's own compressor.
std::unique_ptr<ByteCodec> lzfCodec();
/// Blocks of LZ4 behind the decoded size and the size of a block, big-endian.
std::unique_ptr<ByteCodec> hdf5Lz4Codec();

enum class BitshuffleInner { kNone, kLz4, kZstd };
/// Bit planes of blocks of `block` numbers, 0 for the library's default, each block compressed by `inner`.
std::unique_ptr<ByteCodec> bitshuffleCodec(std::size_t number_bytes, std::size_t block, BitshuffleInner inner);

}  // namespace kiln
