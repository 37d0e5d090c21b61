// What ranks tell each other of frames. Frames are named by their place in the row of those that are to be drawn.
#pragma once

#include <optional>
#include <vector>

#include "base/byte_record.h"
#include "base/error.h"
#include "frame/statistics.h"

namespace kiln {

/// Of a frame or a rank's share of it: what it has cost, or why there is none.
struct FrameReport {
  std::uint32_t frame = 0;
  FrameStatistics statistics;
  std::optional<Error> failure;
};

std::vector<std::byte> packed(const FrameReport& report);
FrameReport reportFrom(const std::vector<std::byte>& bytes);

/// Of a message that has been read: throws Error kIo where it was not what was taken.
void requireTaken(const ByteTaker& taker);

}  // namespace kiln
