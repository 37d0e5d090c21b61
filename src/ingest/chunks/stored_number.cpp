#include "ingest/chunks/stored_number.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <utility>
#include <vector>

#include "ingest/bytes/value_map.h"

namespace kiln {
namespace {

const std::array<std::pair<const char*, StoredType>, 11> kNumberNames = {{
    {"uint8", VoxelType::u8},
    {"int8", VoxelType::i8},
    {"uint16", VoxelType::u16},
    {"int16", VoxelType::i16},
    {"uint32", VoxelType::u32},
    {"int32", VoxelType::i32},
    {"uint64", StoredType::wide(false)},
    {"int64", StoredType::wide(true)},
    {"float16", StoredType::half()},
    {"float32", VoxelType::f32},
    {"float64", VoxelType::f64},
}};

}  // namespace

std::string StoredNumber::name() const {
  return std::find_if(kNumberNames.begin(), kNumberNames.end(),
                      [&](const auto& named) {
                        return named.second.voxel() == type.voxel() && sizeOf(named.second) == sizeOf(type);
                      })
      ->first;
}

StoredNumber StoredNumber::withoutSign() const {
  const std::string own = name();
  return own.starts_with("int") ? StoredNumber{storedNumberNamed("u" + own)->type, big_endian} : *this;
}

std::optional<StoredNumber> storedNumberNamed(std::string_view name) {
  if (name == "bool") return StoredNumber{};
  const auto found =
      std::find_if(kNumberNames.begin(), kNumberNames.end(), [&](const auto& named) { return named.first == name; });
  if (found == kNumberNames.end()) return std::nullopt;
  return StoredNumber{found->second, false};
}

void readVoxels(const StoredNumber& number, std::span<std::byte> voxels, const ChunkPlace& place,
                const std::function<void(std::span<std::byte> stored)>& read) {
  const ValueMap map{number.type, number.voxelType(), number.big_endian != (std::endian::native == std::endian::big)};
  const std::size_t count = voxels.size() / sizeOf(number.voxelType());
  std::vector<std::byte> wider_or_narrower(map.copies() ? 0 : count * number.bytes());
  const std::span<std::byte> stored = map.copies() ? voxels : std::span(wider_or_narrower);
  read(stored);
  map.order(stored.data(), count);
  if (map.copies()) return;
  if (const std::optional<std::string> value = map.misfit(stored.data(), count))
    place.fail(fmt::format("the value {} does not fit into 32 bits, the most that a voxel has", *value));
  map.apply(stored.data(), count, voxels.data());
}

}  // namespace kiln
