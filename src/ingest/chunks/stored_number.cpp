#include "ingest/chunks/stored_number.h"

#include <fmt/format.h>

#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

#include "ingest/bytes/stored_type.h"
#include "ingest/bytes/value_map.h"

namespace kiln {
namespace {

template <class From, class To, class Convert>
void convertAll(std::span<const std::byte> in, std::span<std::byte> out, Convert convert) {
  for (std::size_t i = 0; i < in.size() / sizeof(From); ++i) {
    From from;
    std::memcpy(&from, in.data() + i * sizeof from, sizeof from);
    const To to = convert(from);
    std::memcpy(out.data() + i * sizeof to, &to, sizeof to);
  }
}

template <class Wide, class Narrow>
void narrow(std::span<const std::byte> in, std::span<std::byte> out, const ChunkPlace& place) {
  convertAll<Wide, Narrow>(in, out, [&](Wide value) {
    if (value < std::numeric_limits<Narrow>::min() || value > std::numeric_limits<Narrow>::max())
      place.fail(fmt::format("the value {} does not fit into 32 bits, the most that a voxel has", value));
    return static_cast<Narrow>(value);
  });
}

}  // namespace

VoxelType StoredNumber::voxelType() const {
  const bool is_signed = kind == NumberKind::kSigned;
  if (kind == NumberKind::kFloat) return bytes == 8 ? VoxelType::f64 : VoxelType::f32;
  if (bytes == 1) return is_signed ? VoxelType::i8 : VoxelType::u8;
  if (bytes == 2) return is_signed ? VoxelType::i16 : VoxelType::u16;
  return is_signed ? VoxelType::i32 : VoxelType::u32;
}

std::string StoredNumber::name() const {
  const char* const kinds[] = {"uint", "int", "float"};
  return kinds[static_cast<int>(kind)] + std::to_string(8 * bytes);
}

std::optional<StoredNumber> storedNumberNamed(std::string_view name) {
  if (name == "bool") return StoredNumber{};
  for (const NumberKind kind : {NumberKind::kUnsigned, NumberKind::kSigned, NumberKind::kFloat}) {
    for (const std::size_t bytes : {1, 2, 4, 8}) {
      const StoredNumber number{kind, bytes, false};
      if (number.name() == name && (kind != NumberKind::kFloat || bytes > 1)) return number;
    }
  }
  return std::nullopt;
}

void readVoxels(const StoredNumber& number, std::span<std::byte> voxels, const ChunkPlace& place,
                const std::function<void(std::span<std::byte> stored)>& read) {
  const std::size_t size = sizeOf(number.voxelType());
  std::vector<std::byte> wider_or_narrower(number.bytes == size ? 0 : voxels.size() / size * number.bytes);
  const std::span<std::byte> stored = number.bytes == size ? voxels : std::span(wider_or_narrower);
  read(stored);
  if (number.bytes > 1 && number.big_endian != (std::endian::native == std::endian::big))
    swapBytes(stored.data(), stored.size() / number.bytes, number.bytes);
  if (number.bytes == size) return;
  if (number.kind == NumberKind::kFloat)
    convertAll<Half, float>(stored, voxels, [](Half half) { return static_cast<float>(static_cast<double>(half)); });
  else if (number.kind == NumberKind::kSigned)
    narrow<std::int64_t, std::int32_t>(stored, voxels, place);
  else
    narrow<std::uint64_t, std::uint32_t>(stored, voxels, place);
}

}  // namespace kiln
