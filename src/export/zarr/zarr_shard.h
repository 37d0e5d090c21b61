// A shard: chunks one behind the other, and an index of their places at the end.
#pragma once

#include <filesystem>
#include <vector>

#include "base/file/file.h"
#include "grid/coords.h"

namespace kiln {

/// Writes a shard under its own name in one step. `chunks` are in the order of the index, x fastest; an empty chunk is
/// missing, which means the fill value. Returns the size of the file. throws: Error kNoSpace, kIo. unit: bytes.
std::uint64_t writeShard(const std::filesystem::path& path, const std::vector<std::vector<std::byte>>& chunks,
                         FileSystem& disk);

/// Returns the size of the file if it is a whole shard of `chunks` chunks, by the checksum of its index; else 0. unit:
/// bytes.
std::uint64_t wholeShardBytes(const std::filesystem::path& path, std::size_t chunks);

}  // namespace kiln
