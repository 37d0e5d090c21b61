// One volume, brick after brick from front to back.
// Method. Bricks that are in memory are drawn together: tiles in parallel, in each tile its bricks front to back. A
// brick that is not in memory is read while the bricks before it are drawn, unless they would hide it.
#pragma once

#include <memory>

#include "frame/pass/frame_request.h"
#include "frame/pass/walked_volume.h"

namespace kiln {

class BrickPass final : public FramePass {
 public:
  /// requires: `store` and `request` outlive this; `engine` refers to `levels`.
  BrickPass(const StoreReader& store, const FrameRequest& request, std::unique_ptr<const FrameLevels> levels,
            std::unique_ptr<VolumeEngine> engine);

  std::vector<BrickOfFrame> inView(const PixelRect& pixels, BrickWalkCounts& counts) const override {
    return volume_.inView(pixels, counts);
  }
  std::uint64_t steps(const PixelRect& pixels) const override { return volume_.bricksIn(pixels); }
  PixelRect draw(const PassTarget& target, PassContext& context) override;
  std::uint64_t scratchBytes() const override { return volume_.engine().scratchBytes(); }

 private:
  class Drawing;

  const FrameRequest& request_;
  const WalkedVolume<VolumeEngine> volume_;
};

}  // namespace kiln
