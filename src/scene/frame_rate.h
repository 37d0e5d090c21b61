// Frames per second of a video, as the quotient of integers that video files store.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace kiln {

struct FrameRate {
  int numerator = 24, denominator = 1;
  double perSecond() const { return static_cast<double>(numerator) / denominator; }
  /// "24", "24000/1001".
  std::string text() const;
  bool operator==(const FrameRate&) const = default;
};

/// The forms read by `frameRateFrom`, for messages.
inline constexpr const char* kFrameRateForms =
    "frames a second from 0.1 to 1000, such as 25, 23.976, 29.97 or 24000/1001";

/// Parses "25", "12.5" or "24000/1001". NTSC rates may be written as rounded decimals: a number with two or more places
/// that rounds 1000/1001 of 24, 30, 48, 60, 120 or 240 is that rate; 23.976 and 23.98 are 24000/1001. Empty if the text
/// is no legal rate.
std::optional<FrameRate> frameRateFrom(std::string_view text);

}  // namespace kiln
