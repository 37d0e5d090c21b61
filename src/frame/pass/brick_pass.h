// One volume, brick after brick from front to back.
// Method. Bricks that are in memory are drawn together: tiles in parallel, in each tile its bricks front to back. A
// brick that is not in memory is read while the bricks before it are drawn, unless they would hide it.
#pragma once

#include "frame/pass/volume_pass.h"

namespace kiln {

class BrickPass final : public VolumePass<VolumeEngine> {
 public:
  using VolumePass::VolumePass;
  PixelRect draw(const PassTarget& target, PassContext& context) override;

 private:
  class Drawing;
};

}  // namespace kiln
