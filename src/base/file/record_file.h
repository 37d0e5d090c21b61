// A file of records, each with a hash of its bytes, that grows at its end. A torn record at the end is detected, and
// all whole records before it are readable after any crash. Journals of resumable work are such files.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "base/file/file.h"

namespace kiln {

/// The first bytes of the file, which name its kind.
using RecordMagic = std::array<char, 8>;

/// Appends a record: payload length (u32), hash of the payload, payload.
void appendRecord(std::vector<std::byte>& out, std::span<const std::byte> payload);
std::vector<std::byte> beginningOf(const RecordMagic& magic);

/// Calls take(payload) for each whole record, until a record is torn or `take` returns false. Returns the length of the
/// file up to the last accepted record; nothing if the file is missing or of another kind. unit: bytes. throws: Error
/// kIo.
std::optional<std::uint64_t> readRecords(const std::filesystem::path& path, const RecordMagic& magic,
                                         const std::function<bool(std::span<const std::byte>)>& take);

}  // namespace kiln
