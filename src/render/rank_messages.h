// What ranks tell each other of frames. Frames are named by their place in the row of those that are to be drawn.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "output/image.h"
#include "render/statistics.h"

namespace kiln {

struct TileMessage {
  std::uint32_t frame = 0, tile = 0;
  Image pixels;
};

/// Of a frame or a rank's share of it: what it has cost, or why there is none.
struct FrameReport {
  std::uint32_t frame = 0;
  FrameStatistics statistics;
  std::optional<Error> failure;
};

std::vector<std::byte> packed(const TileMessage& message);
std::vector<std::byte> packed(const FrameReport& report);
std::vector<std::byte> packed(const RankStatistics& statistics);
TileMessage tileFrom(const std::vector<std::byte>& bytes);
FrameReport reportFrom(const std::vector<std::byte>& bytes);
RankStatistics rankFrom(const std::vector<std::byte>& bytes);

}  // namespace kiln
