// Method. A box is cut across its longest axis in the proportion of the tiles on both sides, and both sides likewise.
#include "export/vdb/vdb_tiles.h"

#include <fmt/format.h>

#include <cmath>

#include "base/error.h"
#include "export/source/numbered_name.h"
#include "export/vdb/grid_placement.h"

namespace kiln {
namespace {

int longestAxis(const Extent3& extent) {
  if (extent.x >= extent.y && extent.x >= extent.z) return 0;
  return extent.y >= extent.z ? 1 : 2;
}

void addTiles(const VoxelBox& box, int count, std::vector<VoxelBox>& out) {
  if (count == 1) return out.push_back(box);
  const int axis = longestAxis(box.extent()), first = count / 2;
  const double share = static_cast<double>(first) / count;
  const double cut = static_cast<double>(box.lo[axis]) + share * static_cast<double>(box.extent()[axis]);
  const std::int64_t at = std::llround(cut / kLeafEdge) * kLeafEdge;
  VoxelBox before = box, behind = box;
  before.hi[axis] = behind.lo[axis] = at;
  addTiles(before, first, out);
  addTiles(behind, count - first, out);
}

}  // namespace

std::vector<ExportedVolume> tilesOf(const ExportedVolume& volume, int count, const std::filesystem::path& out) {
  std::vector<VoxelBox> boxes;
  addTiles(volume.box, count, boxes);
  std::vector<ExportedVolume> tiles;
  for (const VoxelBox& box : boxes) {
    if (box.empty())
      throw Error(ErrorCode::kUsage, out, "--tiles",
                  fmt::format("must be fewer: the volume has {} (found {})", extentText(volume), count));
    tiles.push_back(volume);
    tiles.back().box = box;
  }
  return tiles;
}

std::filesystem::path pathOfTile(const std::filesystem::path& out, int tile) {
  if (!NumberedName::isPattern(out))
    throw Error(ErrorCode::kUsage, out, "--tiles",
                "needs a name with # in place of the tile's number; write NAME_#.vdb");
  return NumberedName(out).path(tile);
}

}  // namespace kiln
