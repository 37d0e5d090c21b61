// Where the parts of bricks whose parents are not yet built wait: in memory as far as they may, then in a folder of the
// store being written, one file a part. Nothing here outlives the process: a resumed conversion makes the parts it
// needs anew.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <mutex>

#include "base/file.h"
#include "convert/coarse_part.h"

namespace kiln {

class PartStore {
 public:
  /// `directory` is emptied, or made. Parts of `memory_bytes` together have no file. throws: Error kNoSpace, kIo.
  PartStore(const std::filesystem::path& directory, std::uint64_t memory_bytes, FileSystem& disk);
  /// Removes it.
  ~PartStore();
  PartStore(const PartStore&) = delete;
  PartStore& operator=(const PartStore&) = delete;

  /// thread: safe for different keys. throws: Error kNoSpace, kIo.
  void put(const BrickKey& key, CoarsePart part);
  /// requires: the part was put, and not dropped. thread: safe. throws: Error kIo, kFormat, kNotFound.
  std::shared_ptr<const CoarsePart> get(const BrickKey& key) const;
  void drop(const BrickKey& key) noexcept;

 private:
  std::filesystem::path pathOf(const BrickKey& key) const;
  std::filesystem::path directory_;
  FileSystem& disk_;
  mutable std::mutex mutex_;  // guards what follows
  std::map<BrickKey, std::shared_ptr<const CoarsePart>> kept_;
  std::uint64_t free_bytes_;
};

}  // namespace kiln
