#include "ingest/zarr/fill_value.h"

#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

namespace kiln {
namespace {

// Zarr 3 writes bits of floats as hexadecimal digits, the highest first, for numbers such as a signalling NaN.
std::optional<double> ofBits(const JsonNode& value, const StoredNumber& number) {
  if (!value.isText() || number.kind != NumberKind::kFloat) return std::nullopt;
  const std::string text = value.text();
  if (!text.starts_with("0x") || text.size() != 2 + 2 * number.bytes) return std::nullopt;
  std::uint64_t bits = 0;
  const char* const end = text.data() + text.size();
  if (std::from_chars(text.data() + 2, end, bits, 16).ptr != end) return std::nullopt;
  if (number.bytes == 8) return std::bit_cast<double>(bits);
  if (number.bytes == 4) return std::bit_cast<float>(static_cast<std::uint32_t>(bits));
  std::array<std::byte, 8> half{}, voxel{};
  std::memcpy(half.data(), &bits, sizeof bits);
  toVoxels({NumberKind::kFloat, 2, false}, std::span(half).first(2), std::span(voxel).first(4), {});
  float out;
  std::memcpy(&out, voxel.data(), sizeof out);
  return out;
}

double numberOf(const JsonNode& value, const StoredNumber& number) {
  if (value.isTruth()) return value.truth() ? 1 : 0;
  // Some programs write an empty text where there is no fill value.
  if (value.isText() && value.text().empty()) return 0;
  if (const std::optional<double> bits = ofBits(value, number)) return *bits;
  return value.number();
}

}  // namespace

std::array<std::byte, 8> fillOf(const std::optional<JsonNode>& value, const StoredNumber& number) {
  std::array<std::byte, 8> out{};
  if (!value) return out;
  const double fill = numberOf(*value, number);
  withVoxelType(number.voxelType(), [&]<class T>(std::type_identity<T>) {
    if constexpr (std::is_integral_v<T>) {
      using Limits = std::numeric_limits<T>;
      if (fill != std::floor(fill) || !(fill >= static_cast<double>(Limits::min())) ||
          !(fill <= static_cast<double>(Limits::max())))
        value->fail("must be a value of " + std::string(nameOf(number.voxelType())));
    }
    const T voxel = static_cast<T>(fill);
    std::memcpy(out.data(), &voxel, sizeof voxel);
  });
  return out;
}

}  // namespace kiln
