// One volume, its engine, and the walk over the bricks that the engine selects.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "engine/engine.h"
#include "frame/pass/frame_pass.h"
#include "traverse/brick_walk.h"

namespace kiln {

/// EngineOfVolume is VolumeEngine, or a class derived from it.
template <class EngineOfVolume>
class WalkedVolume {
 public:
  /// requires: `store` outlives this; `engine` refers to no other levels.
  WalkedVolume(const StoreReader& store, std::unique_ptr<const FrameLevels> levels,
               std::unique_ptr<EngineOfVolume> engine)
      : store_(store),
        levels_(std::move(levels)),
        engine_(std::move(engine)),
        walk_(store, *levels_, engine_->selection()) {}

  const StoreReader& store() const { return store_; }
  EngineOfVolume& engine() const { return *engine_; }
  const BrickWalk& walk() const { return walk_; }

  std::vector<BrickOfFrame> inView(const PixelRect& pixels, BrickWalkCounts& counts) const {
    std::vector<BrickOfFrame> out;
    for (const BrickInView& brick : walk_.inView(pixels, counts)) out.push_back({{brick.key}, brick.rect});
    return out;
  }
  std::uint64_t bricksIn(const PixelRect& pixels) const {
    BrickWalkCounts ignored;
    return walk_.inView(pixels, ignored).size();
  }
  /// Adds the cost of a drawn brick.
  void addCosts(const BrickKey& key, const DrawCounts& drawn, PassCosts& costs) const {
    costs.drawn.add(drawn);
    costs.statistics.levels[static_cast<std::size_t>(key.level)].add(drawn.visited, drawn.splats);
    if (drawn.changed) costs.statistics.addContributing({key}, store_.index().at(key).file_bytes);
  }

 private:
  const StoreReader& store_;
  const std::unique_ptr<const FrameLevels> levels_;
  const std::unique_ptr<EngineOfVolume> engine_;
  const BrickWalk walk_;
};

}  // namespace kiln
