#include "ingest/bytes/value_map.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "base/error.h"

namespace kiln {
namespace {

template <class T>
T rounded(double value) noexcept {
  if constexpr (std::is_floating_point_v<T>) {
    return static_cast<T>(value);
  } else {
    if (std::isnan(value)) return 0;
    constexpr double kLo = std::numeric_limits<T>::min(), kHi = std::numeric_limits<T>::max();
    return static_cast<T>(std::clamp(std::nearbyint(value), kLo, kHi));
  }
}

}  // namespace

void swapBytes(std::byte* data, std::size_t count, std::size_t size) noexcept {
  for (std::size_t i = 0; i < count; ++i, data += size) std::reverse(data, data + size);
}

bool ValueMap::leavesFloat() const {
  const double most = withVoxelType(from.voxel(), []<class T>(std::type_identity<T>) {
    if constexpr (std::is_floating_point_v<T>) return 1e8;
    return std::max(-static_cast<double>(std::numeric_limits<T>::lowest()),
                    static_cast<double>(std::numeric_limits<T>::max()));
  });
  return most * std::abs(slope) + std::abs(intercept) > std::numeric_limits<float>::max() ||
         std::abs(slope) < std::numeric_limits<float>::min();
}

bool ValueMap::mergesInFloat() const {
  // A float has 24 bits: neighbouring stored values should differ by at least two units in the last place.
  constexpr double kLastPlace = 0x1p-23;
  return std::abs(intercept) * kLastPlace > std::abs(slope) / 2;
}

std::optional<std::string> ValueMap::misfit(const std::byte* in, std::size_t count) const {
  if (!from.isWide() || to != from.voxel()) return std::nullopt;
  const auto search = [&]<class Wide, class Narrow>(Wide, Narrow) -> std::optional<std::string> {
    for (std::size_t i = 0; i < count; ++i) {
      Wide value;
      std::memcpy(&value, in + i * sizeof(Wide), sizeof(Wide));
      if (!std::in_range<Narrow>(value)) return std::to_string(value);
    }
    return std::nullopt;
  };
  return from.voxel() == VoxelType::i32 ? search(std::int64_t{}, std::int32_t{})
                                        : search(std::uint64_t{}, std::uint32_t{});
}

void requireFits(const ValueMap& map, const std::byte* stored, std::size_t count, const std::filesystem::path& file,
                 std::int64_t slice) {
  if (const std::optional<std::string> value = map.misfit(stored, count))
    throw Error(ErrorCode::kFormat, file, fmt::format("slice {}", slice),
                fmt::format("the 64-bit integer {} does not fit into 32 bits; save the values as double", *value));
}

void ValueMap::apply(const std::byte* in, std::size_t count, std::byte* out) const noexcept {
  withStoredType(from, [&](auto from_type) {
    withVoxelType(to, [&](auto to_type) {
      using From = typename decltype(from_type)::type;
      using To = typename decltype(to_type)::type;
      // A sum with 0 would lose the sign of -0.
      const bool plain = slope == 1 && intercept == 0;
      for (std::size_t i = 0; i < count; ++i) {
        From stored;
        std::memcpy(&stored, in + i * sizeof(From), sizeof(From));
        const auto exact = static_cast<double>(stored);
        const To value = rounded<To>(plain ? exact : exact * slope + intercept);
        std::memcpy(out + i * sizeof(To), &value, sizeof(To));
      }
    });
  });
}

}  // namespace kiln
