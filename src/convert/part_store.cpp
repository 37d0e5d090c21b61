#include "convert/part_store.h"

#include <fmt/format.h>

#include <system_error>

namespace kiln {
namespace fs = std::filesystem;

PartStore::PartStore(const fs::path& directory, std::uint64_t memory_bytes, FileSystem& disk)
    : directory_(directory), disk_(disk), free_bytes_(memory_bytes) {
  std::error_code ignored;
  if (fs::exists(directory, ignored)) disk_.removeAll(directory);
  disk_.makeDirectories(directory);
}

PartStore::~PartStore() {
  std::error_code ignored;
  fs::remove_all(directory_, ignored);
}

fs::path PartStore::pathOf(const BrickKey& key) const {
  return directory_ / fmt::format("{}_{}_{}_{}.tmp", key.level, key.brick.x, key.brick.y, key.brick.z);
}

void PartStore::put(const BrickKey& key, CoarsePart part) {
  const std::uint64_t bytes = part.bytes();
  {
    const std::scoped_lock lock(mutex_);
    if (bytes <= free_bytes_) {
      free_bytes_ -= bytes;
      kept_[key] = std::make_shared<const CoarsePart>(std::move(part));
      return;
    }
  }
  disk_.writeFile(pathOf(key), bytesOf(part), WriteMode::kUnsynced);
}

std::shared_ptr<const CoarsePart> PartStore::get(const BrickKey& key) const {
  {
    const std::scoped_lock lock(mutex_);
    const auto found = kept_.find(key);
    if (found != kept_.end()) return found->second;
  }
  return std::make_shared<const CoarsePart>(partFrom(readFile(pathOf(key)), pathOf(key)));
}

void PartStore::drop(const BrickKey& key) noexcept {
  {
    const std::scoped_lock lock(mutex_);
    const auto found = kept_.find(key);
    if (found != kept_.end()) {
      free_bytes_ += found->second->bytes();
      kept_.erase(found);
      return;
    }
  }
  std::error_code ignored;
  fs::remove(pathOf(key), ignored);
}

}  // namespace kiln
