// Memory that an engine needs beside bricks and picture, before a frame is planned.
#pragma once

#include <cstdint>

namespace kiln {

/// unit: bytes.
struct EngineMemory {
  std::uint64_t pixel = 0;         // for each pixel that is drawn at a time
  std::uint64_t stored_brick = 0;  // for each brick of the stores: lists of bricks, and their order
  std::uint64_t thread = 0;        // for each thread that draws
  std::uint64_t tile = 0;          // for each thread that draws, by the size of its tile
  std::uint64_t brick = 0;         // for each brick that is drawn at a time
};

}  // namespace kiln
