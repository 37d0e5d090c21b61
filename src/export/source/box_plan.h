// Divides a volume into boxes that fit into memory and decode few bricks more than once.
#pragma once

#include <filesystem>

#include "export/source/volume_writer.h"

namespace kiln {

struct BoxPlan {
  /// Boxes begin at multiples of `step` from `anchor` on, in the coordinates of the level.
  Extent3 step;
  VoxelCoord anchor;
  unsigned threads = 1;
};

/// Plans the boxes of one volume of `writer` within `memory_bytes`, which hold the index, a box, the writer's memory
/// and a brick for each thread. throws: Error kBudget, naming `out` and the least memory.
BoxPlan planBoxes(const StoreReader& store, const ExportedVolume& volume, const VolumeWriter& writer,
                  std::uint64_t memory_bytes, const std::filesystem::path& out);

/// The boxes of a plan, x fastest, then y, then z.
class BoxList {
 public:
  BoxList(const VoxelBox& whole, const BoxPlan& plan);
  std::int64_t count() const { return counts_.count(); }
  VoxelBox at(std::int64_t i) const;

 private:
  VoxelBox whole_;
  BoxPlan shape_;
  VoxelCoord first_;  // in steps from the anchor
  Extent3 counts_;
};

}  // namespace kiln
