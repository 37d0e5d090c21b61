#include "convert/part_store.h"

#include <fmt/format.h>

#include <cstring>
#include <system_error>

namespace kiln {
namespace fs = std::filesystem;
namespace {

// The fixed part of a file; voxels and cells follow.
struct Header {
  VoxelBox box, cell_box;
  ValueRange support;
  std::uint64_t voxel_bytes;
};

}  // namespace

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
  const Header header{part.box, part.cell_box, part.support, part.voxels.size()};
  const std::size_t cell_bytes = part.cells.size() * sizeof(ValueRange);
  std::vector<std::byte> file(sizeof header + part.voxels.size() + cell_bytes);
  std::memcpy(file.data(), &header, sizeof header);
  std::memcpy(file.data() + sizeof header, part.voxels.data(), part.voxels.size());
  std::memcpy(file.data() + sizeof header + part.voxels.size(), part.cells.data(), cell_bytes);
  disk_.writeFile(pathOf(key), file, WriteMode::kUnsynced);
}

std::shared_ptr<const CoarsePart> PartStore::get(const BrickKey& key) const {
  {
    const std::scoped_lock lock(mutex_);
    const auto found = kept_.find(key);
    if (found != kept_.end()) return found->second;
  }
  return std::make_shared<const CoarsePart>(read(key));
}

CoarsePart PartStore::read(const BrickKey& key) const {
  const File file(pathOf(key));
  Header header;
  file.readAt(0, std::as_writable_bytes(std::span(&header, 1)));
  CoarsePart part{header.box, std::vector<std::byte>(header.voxel_bytes), header.cell_box, {}, header.support};
  part.cells.resize(static_cast<std::size_t>(part.cell_box.count()));
  file.readAt(sizeof header, part.voxels);
  file.readAt(sizeof header + part.voxels.size(), std::as_writable_bytes(std::span(part.cells)));
  return part;
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
