// One volume with projected values, drawn in an order of values.
#pragma once

#include "engine/projection/value_projection.h"
#include "frame/pass/volume_pass.h"

namespace kiln {

class ValuePass final : public VolumePass<ValueProjection> {
 public:
  using VolumePass::VolumePass;
  PixelRect draw(const PassTarget& target, PassContext& context) override;

 private:
  DrawCounts drawBrick(const BrickToDraw& brick, const PassTarget& target);
};

}  // namespace kiln
