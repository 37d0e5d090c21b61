// Several volumes, zone after zone from near to far.
// Method. In a zone, as many tiles are drawn at a time as the cache has room for the bricks of.
#pragma once

#include <set>

#include "engine/pixel/multi_volume.h"
#include "frame/pass/frame_pass.h"

namespace kiln {

class ZonePass final : public FramePass {
 public:
  /// requires: the stores of `volumes` outlive the object.
  ZonePass(std::vector<MixedVolume> volumes, const MixView& view, int tile_px);

  std::vector<BrickOfFrame> inView(const PixelRect& pixels, BrickWalkCounts& counts) const override;
  /// A step is a tile of a brick in a zone.
  std::uint64_t steps(const PixelRect& pixels) const override;
  PixelRect draw(const PassTarget& target, PassContext& context) override;
  /// The bricks of all volumes that meet in a tile.
  std::uint64_t bytesAtOnce(const PixelRect& pixels) const override;
  std::uint64_t scratchBytes() const override { return volumes_.scratchBytes(); }

 private:
  class Drawing;
  std::uint64_t steps(std::size_t zone, std::span<const PixelRect> tiles) const;

  MultiVolume volumes_;
  const int tile_px_;
  std::set<StoredBrick> drawn_;  // in all pieces so far
};

}  // namespace kiln
