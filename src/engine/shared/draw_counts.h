// Counters of an engine's work on a brick in a tile.
#pragma once

#include <cstdint>

namespace kiln {

struct DrawCounts {
  std::uint64_t visited = 0;  // interesting voxels, samples or cubes between voxels of the tile
  std::uint64_t splats = 0;   // the visited that were drawn
  std::uint64_t nodes_tested = 0, nodes_hidden = 0;
  bool changed = false;  // a pixel may have changed
  void add(const DrawCounts& other) {
    visited += other.visited;
    splats += other.splats;
    nodes_tested += other.nodes_tested;
    nodes_hidden += other.nodes_hidden;
    changed = changed || other.changed;
  }
};

}  // namespace kiln
