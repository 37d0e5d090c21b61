// Size and times of a file, by one call of the system.
#pragma once

#include <cstdint>
#include <ctime>
#include <filesystem>
#include <optional>

namespace kiln {

struct FileStamp {
  std::uint64_t bytes = 0;
  std::int64_t written_ns = 0;  // mtime
  std::int64_t changed_ns = 0;  // ctime
};

/// A time of a file. unit: ns since 1970.
std::int64_t nanosecondsOf(const std::timespec& time);

/// Returns the stamp of a regular file, for a link of its target; nothing for a folder, a device or no file.
/// throws: Error kIo.
std::optional<FileStamp> stampOfFile(const std::filesystem::path& path);

}  // namespace kiln
