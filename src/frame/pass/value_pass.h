// One volume whose values are projected, in an order of values.
#pragma once

#include <memory>

#include "engine/projection/value_projection.h"
#include "frame/pass/frame_request.h"
#include "frame/pass/walked_volume.h"

namespace kiln {

class ValuePass final : public FramePass {
 public:
  /// requires: `store` and `request` outlive this; `projection` refers to `levels`.
  ValuePass(const StoreReader& store, const FrameRequest& request, std::unique_ptr<const FrameLevels> levels,
            std::unique_ptr<ValueProjection> projection);

  std::vector<BrickOfFrame> inView(const PixelRect& pixels, BrickWalkCounts& counts) const override {
    return volume_.inView(pixels, counts);
  }
  std::uint64_t steps(const PixelRect& pixels) const override { return volume_.bricksIn(pixels); }
  PixelRect draw(const PassTarget& target, PassContext& context) override;
  std::uint64_t scratchBytes() const override { return volume_.engine().scratchBytes(); }

 private:
  DrawCounts drawBrick(const BrickToDraw& brick, const PassTarget& target);

  const FrameRequest& request_;
  const WalkedVolume<ValueProjection> volume_;
};

}  // namespace kiln
