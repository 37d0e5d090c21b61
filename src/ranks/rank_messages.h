// Messages between ranks about frames. A frame is named by its position in the list of frames to draw.
#pragma once

#include <optional>
#include <vector>

#include "base/byte_record.h"
#include "base/error.h"
#include "frame/statistics.h"

namespace kiln {

/// Statistics of a frame, or of a rank's share of a frame; or the error that prevented drawing.
struct FrameReport {
  std::uint32_t frame = 0;
  FrameStatistics statistics;
  std::optional<Error> failure;
};

std::vector<std::byte> packed(const FrameReport& report);
FrameReport reportFrom(const std::vector<std::byte>& bytes);

/// throws: Error kIo if a message is longer or shorter than the values taken.
void requireTaken(const ByteTaker& taker);

}  // namespace kiln
