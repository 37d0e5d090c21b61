#include "convert/pyramid/half_brick_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <system_error>

namespace kiln {
namespace fs = std::filesystem;

HalfBrickStore::HalfBrickStore(const fs::path& directory, std::uint64_t memory_bytes, FileSystem& disk)
    : directory_(directory), disk_(disk), free_bytes_(memory_bytes) {
  std::error_code ignored;
  if (fs::exists(directory, ignored)) disk_.removeAll(directory);
  disk_.makeDirectories(directory);
}

HalfBrickStore::~HalfBrickStore() {
  std::error_code ignored;
  fs::remove_all(directory_, ignored);
}

fs::path HalfBrickStore::pathOf(const BrickKey& key) const {
  return directory_ / fmt::format("{}_{}_{}_{}.tmp", key.level, key.brick.x, key.brick.y, key.brick.z);
}

bool HalfBrickStore::reserve(std::uint64_t bytes) {
  const std::scoped_lock lock(mutex_);
  if (bytes > free_bytes_) return false;
  free_bytes_ -= bytes;
  return true;
}

HalfBrickStore::Pieces HalfBrickStore::written(const BrickKey& key, const std::vector<HalfBrickPiece>& pieces) {
  Pieces out;
  out.reserve(pieces.size());
  std::vector<std::byte> file;
  for (const auto& [parent, part] : pieces) {
    const std::vector<std::byte> bytes = bytesOf(part);
    out.push_back({parent, nullptr, {file.size(), bytes.size()}});
    file.insert(file.end(), bytes.begin(), bytes.end());
  }
  disk_.writeFile(pathOf(key), file, WritePolicy::kUnsynced);
  return out;
}

void HalfBrickStore::put(const BrickKey& key, std::vector<HalfBrickPiece> pieces) {
  if (pieces.empty()) return;
  std::uint64_t bytes = 0;
  for (const HalfBrickPiece& piece : pieces) bytes += piece.part.bytes();
  Pieces kept;
  if (reserve(bytes)) {
    kept.reserve(pieces.size());
    for (auto& [parent, part] : pieces) kept.push_back({parent, std::make_unique<HalfBrick>(std::move(part)), {}});
  } else {
    kept = written(key, pieces);
  }
  const std::scoped_lock lock(mutex_);
  left_[key] = std::move(kept);
}

HalfBrick HalfBrickStore::take(const BrickKey& key, const BrickKey& parent) {
  const auto find = [&](Pieces& pieces) {
    const auto found =
        std::find_if(pieces.begin(), pieces.end(), [&](const Piece& piece) { return piece.parent == parent; });
    if (found == pieces.end()) throw std::out_of_range("take: the piece was never put");
    return found;
  };
  Stretch stretch;
  {
    const std::scoped_lock lock(mutex_);
    Pieces& pieces = left_.at(key);
    const auto piece = find(pieces);
    if (piece->part) {
      HalfBrick out = std::move(*piece->part);
      free_bytes_ += out.bytes();
      pieces.erase(piece);
      if (pieces.empty()) left_.erase(key);
      return out;
    }
    stretch = piece->stretch;
  }
  const fs::path path = pathOf(key);
  std::vector<std::byte> bytes(stretch.bytes);
  File(path).readAt(stretch.offset, bytes);
  HalfBrick out = partFrom(bytes, path);
  {
    const std::scoped_lock lock(mutex_);
    Pieces& pieces = left_.at(key);
    pieces.erase(find(pieces));
    if (!pieces.empty()) return out;
    left_.erase(key);
  }
  std::error_code ignored;
  fs::remove(path, ignored);
  return out;
}

}  // namespace kiln
