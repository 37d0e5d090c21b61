#include "base/duration_text.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cmath>
#include <ctime>

namespace kiln {
namespace {

constexpr double kMostSeconds = 100, kMostMinutes = 100;  // of a text in seconds, in minutes

std::string minutesText(double seconds) {
  const double minutes = std::round(seconds / 60);
  if (minutes < kMostMinutes) return fmt::format("{:.0f} min", minutes);
  return fmt::format("{:.0f} h {:.0f} min", std::floor(minutes / 60), std::fmod(minutes, 60));
}

}  // namespace

std::string durationText(double seconds) {
  if (seconds >= kMostSeconds) return minutesText(seconds);
  return seconds < 10 ? fmt::format("{:.2f} s", seconds) : fmt::format("{:.1f} s", seconds);
}

std::string roughDurationText(double seconds) {
  return seconds >= kMostSeconds ? minutesText(seconds) : fmt::format("{:.0f} s", seconds);
}

std::string timeNow() { return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr))); }

}  // namespace kiln
