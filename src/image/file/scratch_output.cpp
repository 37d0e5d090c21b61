#include "image/file/scratch_output.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "base/file/renamed_error.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

constexpr std::uint64_t kCopiedBytes = 1u << 20;  // copied at a time

fs::path folderOf(const fs::path& path) {
  const fs::path folder = behindLinks(path).parent_path();
  return isWrittenInPlace(path) ? temporaryFolder() : folder.empty() ? fs::path(".") : folder;
}

// Calls f(). Errors of the scratch file, which has no name, are errors of the output.
template <class F>
auto forOutput(const fs::path& output, F&& f) {
  try {
    return f();
  } catch (const Error& error) {
    throw renamed(error, folderOf(output), output);
  }
}

}  // namespace

ScratchOutput::ScratchOutput(fs::path path, FileSystem& disk)
    : path_(std::move(path)),
      disk_(disk),
      scratch_(forOutput(path_, [&] { return disk.makeScratch(folderOf(path_)); })) {}

void ScratchOutput::write(std::uint64_t offset, std::span<const std::byte> data) {
  forOutput(path_, [&] { disk_.writeAt(scratch_, offset, data); });
  size_ = std::max(size_, offset + data.size());
}

void ScratchOutput::publish() {
  const auto copyTo = [this](const fs::path& to) {
    std::vector<std::byte> piece;
    for (std::uint64_t at = 0; at < size_; at += piece.size()) {
      piece.resize(std::min(kCopiedBytes, size_ - at));
      forOutput(path_, [&] { scratch_.readAt(at, piece); });
      disk_.appendFile(to, piece);
    }
  };
  if (isWrittenInPlace(path_)) return copyTo(path_);
  disk_.replace(path_, [&](const fs::path& temporary) {
    copyTo(temporary);
    disk_.syncFile(temporary);
  });
}

}  // namespace kiln
