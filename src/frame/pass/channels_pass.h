// Several volumes, each projected by itself in its own colours, and the pictures added: channels of microscopy.
// Method. The volumes are drawn one after another by a pass of their own (frame/pass/value_pass.h). The light of a
// pixel is the sum over the volumes, in their order; its alpha is the largest of theirs. Invariant. A picture of
// several volumes is the sum of their own pictures, to the rounding of a float.
#pragma once

#include <memory>
#include <vector>

#include "frame/pass/frame_request.h"
#include "frame/pass/value_pass.h"

namespace kiln {

class ChannelsPass final : public FramePass {
 public:
  /// Makes the pass of the volume at a place among the volumes; `request` is the request of this volume alone.
  using MakePass = std::unique_ptr<ValuePass> (*)(const BrickedVolume& store, const FrameRequest& request, int place);
  /// requires: the stores outlive this; a store for each volume of the request.
  ChannelsPass(const std::vector<const BrickedVolume*>& stores, const FrameRequest& request, MakePass make);

  std::vector<BrickOfFrame> inView(const PixelRect& pixels, BrickWalkCounts& counts) const override;
  std::uint64_t steps(const PixelRect& pixels) const override;
  PixelRect draw(const PassTarget& target, PassContext& context) override;
  std::uint64_t scratchBytes() const override;

 private:
  struct Channel {
    std::unique_ptr<const FrameRequest> request;  // the pass refers to it
    std::unique_ptr<ValuePass> pass;
    BrickWalkCounts walked;
  };
  std::vector<Channel> channels_;
};

}  // namespace kiln
