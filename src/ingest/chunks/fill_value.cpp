#include "ingest/chunks/fill_value.h"

#include <fmt/format.h>

#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>

#include "ingest/bytes/stored_type.h"

namespace kiln {
namespace {

// Zarr 3 writes bits of floats as hexadecimal digits, the highest first, for numbers such as a signalling NaN.
std::optional<double> ofBits(const JsonNode& value, const StoredNumber& number) {
  if (!value.isText() || !isFloating(number.voxelType())) return std::nullopt;
  const std::string text = value.text();
  if (!text.starts_with("0x") || text.size() != 2 + 2 * number.bytes()) return std::nullopt;
  std::uint64_t bits = 0;
  const char* const end = text.data() + text.size();
  if (std::from_chars(text.data() + 2, end, bits, 16).ptr != end) return std::nullopt;
  if (number.bytes() == 8) return std::bit_cast<double>(bits);
  if (number.bytes() == 4) return std::bit_cast<float>(static_cast<std::uint32_t>(bits));
  return static_cast<double>(Half{static_cast<std::uint16_t>(bits)});
}

double statedNumberOf(const JsonNode& value, const StoredNumber& number) {
  if (value.isTruth()) return value.truth() ? 1 : 0;
  // Some programs write an empty text where there is no fill value.
  if (value.isText() && value.text().empty()) return 0;
  if (const std::optional<double> bits = ofBits(value, number)) return *bits;
  return value.number();
}

template <class T>
bool isValueOf(double value) {
  if constexpr (!std::is_integral_v<T>) return true;
  using Limits = std::numeric_limits<T>;
  return value == std::floor(value) && value >= static_cast<double>(Limits::min()) &&
         value <= static_cast<double>(Limits::max());
}

}  // namespace

void readFill(const std::optional<JsonNode>& value, ChunkLayout& out) {
  if (!value) return;
  const VoxelType type = out.number.voxelType();
  const double fill = statedNumberOf(*value, out.number);
  withVoxelType(type, [&]<class T>(std::type_identity<T>) {
    if (!isValueOf<T>(fill)) {
      out.fill_fault = fmt::format("chunks are missing, and their fill value {} is no {}", fill, nameOf(type));
      return;
    }
    const T voxel = static_cast<T>(fill);
    std::memcpy(out.fill.data(), &voxel, sizeof voxel);
  });
}

}  // namespace kiln
