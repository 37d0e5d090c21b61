// Where the parts of bricks whose parents are not yet built wait: a folder of the store being written, one file a part.
// Nothing here outlives the process that wrote it: a resumed conversion makes the parts it needs anew.
#pragma once

#include <filesystem>

#include "base/file.h"
#include "convert/coarse_part.h"

namespace kiln {

class PartStore {
 public:
  /// `directory` is emptied, or made. throws: Error kNoSpace, kIo.
  PartStore(const std::filesystem::path& directory, FileSystem& disk);
  /// Removes it.
  ~PartStore();
  PartStore(const PartStore&) = delete;
  PartStore& operator=(const PartStore&) = delete;

  /// thread: safe for different keys. throws: Error kNoSpace, kIo.
  void put(const BrickKey& key, const CoarsePart& part);
  /// requires: the part was put, and not dropped. thread: safe. throws: Error kIo, kFormat, kNotFound.
  CoarsePart get(const BrickKey& key) const;
  void drop(const BrickKey& key) noexcept;

 private:
  std::filesystem::path pathOf(const BrickKey& key) const;
  std::filesystem::path directory_;
  FileSystem& disk_;
};

}  // namespace kiln
