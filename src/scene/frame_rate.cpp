#include "scene/frame_rate.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <numeric>
#include <optional>

#include "base/text.h"

namespace kiln {
namespace {

constexpr double kSlowest = 0.1, kFastest = 1000;
constexpr std::int64_t kLargestPart = 1'000'000'000;

std::optional<std::int64_t> wholeNumber(std::string_view text) {
  const std::optional<std::int64_t> out = numberOf<std::int64_t>(text);
  return out && *out >= 0 ? out : std::nullopt;
}

std::optional<FrameRate> reduced(std::int64_t numerator, std::int64_t denominator) {
  if (numerator <= 0 || denominator <= 0) return std::nullopt;
  const std::int64_t common = std::gcd(numerator, denominator);
  numerator /= common;
  denominator /= common;
  if (numerator > kLargestPart || denominator > kLargestPart) return std::nullopt;
  const FrameRate out{static_cast<int>(numerator), static_cast<int>(denominator)};
  return out.perSecond() >= kSlowest && out.perSecond() <= kFastest ? std::optional(out) : std::nullopt;
}

// Converts `units` of 10^-places.
std::optional<FrameRate> ofDecimal(std::int64_t units, int places) {
  std::int64_t scale = 1;
  for (int i = 0; i < places; ++i) scale *= 10;
  for (const std::int64_t nominal : {24, 30, 48, 60, 120, 240}) {
    const double exact = static_cast<double>(nominal * 1000) / 1001;
    if (places >= 2 && std::llround(exact * static_cast<double>(scale)) == units)
      return FrameRate{static_cast<int>(nominal * 1000), 1001};
  }
  return reduced(units, scale);
}

}  // namespace

std::string FrameRate::text() const {
  return denominator == 1 ? fmt::format("{}", numerator) : fmt::format("{}/{}", numerator, denominator);
}

std::optional<FrameRate> frameRateFrom(std::string_view text) {
  if (const std::size_t slash = text.find('/'); slash != std::string_view::npos) {
    const auto numerator = wholeNumber(text.substr(0, slash)), denominator = wholeNumber(text.substr(slash + 1));
    return numerator && denominator ? reduced(*numerator, *denominator) : std::nullopt;
  }
  constexpr int kMostPlaces = 9;
  const std::size_t point = text.find('.');
  const std::string places(point == std::string_view::npos ? "" : text.substr(point + 1));
  const std::string digits = std::string(text.substr(0, point)) + places;
  const bool decimal = point == std::string_view::npos || !places.empty();
  if (decimal && places.size() > kMostPlaces) {
    const std::optional<double> value = numberOf<double>(text);
    return value && *value <= kFastest ? frameRateFrom(fmt::format("{:.{}f}", *value, kMostPlaces)) : std::nullopt;
  }
  const auto units = wholeNumber(digits);
  if (!decimal || !units || digits.size() > 15) return std::nullopt;
  return ofDecimal(*units, static_cast<int>(places.size()));
}

}  // namespace kiln
