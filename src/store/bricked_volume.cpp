#include "store/bricked_volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/error.h"
#include "store/brick_index.h"
#include "store/codec/brick_codec.h"

namespace kiln {

BrickedVolume::BrickedVolume(std::filesystem::path path) : path_(std::move(path)) {}
BrickedVolume::BrickedVolume(const BrickedVolume&) = default;
BrickedVolume::~BrickedVolume() = default;

void BrickedVolume::hold(Manifest manifest, BrickIndex index) {
  manifest_ = std::move(manifest);
  index_ = std::make_shared<const BrickIndex>(std::move(index));
}

void BrickedVolume::requireLevel(int level) const {
  const int levels = index_->levels();
  if (level >= 0 && level < levels) return;
  throw Error(ErrorCode::kUsage, path_, "level",
              fmt::format("there is no level {}; it has {}, from 0 to {}", level,
                          levels == 1 ? "1 level" : fmt::format("{} levels", levels), levels - 1));
}

BrickDesc BrickedVolume::frame(const BrickKey& key) const { return descOf(manifest_, key); }

std::optional<double> BrickedVolume::constantOf(const BrickKey& key) const {
  const BrickEntry& entry = index_->at(key);
  return entry.constant ? std::optional<double>(entry.core.lo) : std::nullopt;
}

std::size_t BrickedVolume::blockBytes(const BrickKey& key) const { return kiln::blockBytes(frame(key)); }

std::uint64_t BrickedVolume::largestReadBytes() const {
  return index_->largest([this](const BrickKey& key) { return readBytes(key); });
}

std::uint64_t BrickedVolume::heldBytes() const { return index_->bytes(); }

std::optional<int> BrickedVolume::overviewLevel() const {
  // Limits for the time that a camera takes: at most 64 files, of at most the voxels of a brick of the default size.
  constexpr std::int64_t kMostEdge = 128, kMostBricks = 64;
  const auto finest = [&](auto wanted) -> std::optional<int> {
    for (int level = 0; level < index().levels(); ++level) {
      if (wanted(manifest().levels[static_cast<std::size_t>(level)])) return level;
    }
    return std::nullopt;
  };
  const auto few = finest([&](const LevelInfo& level) {
    const Extent3& dims = level.geometry.dims;
    return std::max({dims.x, dims.y, dims.z}) <= kMostEdge && level.bricks.count() <= kMostBricks;
  });
  return few ? few : finest([](const LevelInfo& level) { return level.bricks.count() == 1; });
}

}  // namespace kiln
