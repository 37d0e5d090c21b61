#include "traverse/tile_scope.h"

#include <fmt/format.h>

#include "store/store_writer.h"

namespace kiln {

TileScope::~TileScope() {
  if (!span_.traced()) return;
  span_.note("brick", brickPath(brick_).native());
  span_.note("tile", fmt::format("{},{} {}x{}", tile_.x0, tile_.y0, tile_.width(), tile_.height()));
  span_.note("samples", counts_.visited - before_.visited);
  span_.note("splats", counts_.splats - before_.splats);
  span_.note("tests", counts_.nodes_tested - before_.nodes_tested);
}

}  // namespace kiln
