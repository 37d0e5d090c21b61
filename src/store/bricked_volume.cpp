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

}  // namespace kiln
