// The directories of a TIFF file whose pages hold their voxels in one strip each, page behind page.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "export/source/exported_volume.h"

namespace kiln {

class TiffPages {
 public:
  /// Describes the first `pages` slices of a volume as one file: classic TIFF, or BigTIFF beyond 4 GiB.
  TiffPages(const ExportedVolume& volume, std::int64_t pages);

  /// The begin of the file: header and first directory, up to the first voxel.
  const std::vector<std::byte>& head() const { return head_; }
  /// The directory of a page from 1 on. Directories follow each other behind the last voxel.
  std::vector<std::byte> directory(std::int64_t page) const;

 private:
  std::uint64_t stripBegin(std::int64_t page) const;
  std::uint64_t directoryBegin(std::int64_t page) const;
  std::vector<std::byte> entries(std::int64_t page, std::uint64_t described_at) const;
  std::uint64_t laterBytes() const;

  ExportedVolume volume_;
  std::int64_t pages_;
  bool big_ = false;
  std::string description_;
  std::uint64_t resolution_begin_ = 0;
  std::vector<std::byte> head_;
};

}  // namespace kiln
