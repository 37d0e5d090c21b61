// Frames a second of a video, as the quotient of whole numbers that video files hold.
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

/// The forms that `frameRateFrom` reads, for messages.
inline constexpr const char* kFrameRateForms =
    "frames a second from 0.1 to 1000, such as 25, 23.976, 29.97 or 24000/1001";

/// Reads "25", "12.5" or "24000/1001". A decimal that rounds 1000/1001 of 24, 30, 48, 60, 120 or 240, with two places
/// or more, is the rate of NTSC video that people write so: 23.976 and 23.98 are 24000/1001. Nothing where the text is
/// no such rate.
std::optional<FrameRate> frameRateFrom(std::string_view text);

}  // namespace kiln
