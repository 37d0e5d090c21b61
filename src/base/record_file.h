// A file that grows by records, each with its hash: whatever ends the process, all whole ones are read again, and a
// torn one at the end is known. What goes on from where another run stopped is kept like this.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "base/file.h"

namespace kiln {

/// What the file begins with: which kind of it this is.
using RecordMagic = std::array<char, 8>;

/// Adds a record: a u32 length, the hash of the payload, the payload.
void appendRecord(std::vector<std::byte>& out, std::span<const std::byte> payload);
std::vector<std::byte> beginningOf(const RecordMagic& magic);

/// Calls take(payload) for each whole record, up to the first that is none, or for which it says false. Returns how
/// long the file is up to there; nothing where there is no file or it is of another kind. unit: bytes. throws: Error
/// kIo.
std::optional<std::uint64_t> readRecords(const std::filesystem::path& path, const RecordMagic& magic,
                                         const std::function<bool(std::span<const std::byte>)>& take);

}  // namespace kiln
