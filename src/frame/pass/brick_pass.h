// One volume, brick after brick from front to back.
// Method. Bricks in memory are drawn together: tiles in parallel, the bricks of a tile front to back. A missing brick
// is read while earlier bricks are drawn, unless the earlier bricks would hide it.
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
