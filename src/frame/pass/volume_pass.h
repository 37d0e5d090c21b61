// The base class of passes over one volume. Holds the walk over the bricks that the volume's engine selects.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "engine/engine.h"
#include "frame/pass/frame_pass.h"
#include "frame/pass/frame_request.h"
#include "traverse/brick_walk.h"

namespace kiln {

/// EngineOfVolume is VolumeEngine or a derived class.
template <class EngineOfVolume>
class VolumePass : public FramePass {
 public:
  /// `place`: of the volume among the volumes of the cache. requires: `store` and `request` outlive the object;
  /// `engine` refers to `levels` only.
  VolumePass(const BrickedVolume& store, const FrameRequest& request, std::unique_ptr<const FrameLevels> levels,
             std::unique_ptr<EngineOfVolume> engine, int place = 0)
      : place_(place),
        request_(request),
        store_(store),
        levels_(std::move(levels)),
        engine_(std::move(engine)),
        walk_(store, *levels_, engine_->selection()) {}

  std::vector<BrickOfFrame> inView(const PixelRect& pixels, BrickWalkCounts& counts) const final {
    std::vector<BrickOfFrame> out;
    counts = {};
    for (const BrickInView& brick : walk_.inView(pixels, counts)) out.push_back({stored(brick.key), brick.rect});
    return out;
  }
  /// A step is a brick.
  std::uint64_t steps(const PixelRect& pixels) const final {
    BrickWalkCounts ignored;
    return walk_.inView(pixels, ignored).size();
  }
  std::uint64_t scratchBytes() const final { return engine_->scratchBytes(); }

 protected:
  const FrameRequest& request() const { return request_; }
  const BrickedVolume& store() const { return store_; }
  EngineOfVolume& engine() const { return *engine_; }
  const BrickWalk& walk() const { return walk_; }
  StoredBrick stored(const BrickKey& key) const { return {key, place_}; }
  int place() const { return place_; }

  /// Adds the cost of a drawn brick.
  void addCosts(const BrickKey& key, const DrawCounts& drawn, PassCosts& costs) const {
    costs.drawn.add(drawn);
    costs.statistics.levels[static_cast<std::size_t>(key.level)].add(drawn.visited, drawn.splats);
    if (drawn.changed) costs.statistics.addContributing(stored(key), store_.index().at(key).file_bytes);
  }

 private:
  const int place_;
  const FrameRequest& request_;
  const BrickedVolume& store_;
  const std::unique_ptr<const FrameLevels> levels_;
  const std::unique_ptr<EngineOfVolume> engine_;
  const BrickWalk walk_;
};

}  // namespace kiln
