#include "export/output/pending_file.h"

#include <algorithm>

namespace kiln {

PendingFile::PendingFile(const std::filesystem::path& path, FileSystem& disk)
    : place_(behindLinks(path)), disk_(disk), temporary_(place_), file_(disk.openToWriteAt(temporary_.path())) {}

void PendingFile::writeAt(std::uint64_t offset, std::span<const std::byte> data) {
  try {
    disk_.writeAt(file_, offset, data);
  } catch (const Error& error) {
    throw temporary_.named(error);
  }
  size_ = std::max(size_, offset + data.size());
}

void PendingFile::sync() {
  try {
    disk_.syncFile(temporary_.path());
  } catch (const Error& error) {
    throw temporary_.named(error);
  }
}

void PendingFile::publish() { disk_.rename(temporary_.path(), place_); }

}  // namespace kiln
