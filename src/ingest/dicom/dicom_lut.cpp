#include "ingest/dicom/dicom_lut.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cstring>
#include <type_traits>

#include "base/error.h"

namespace kiln {

void DicomLut::apply(VoxelType from, const std::byte* in, std::size_t count, VoxelType to, std::byte* out) const {
  assert(to == VoxelType::u8 || to == VoxelType::u16);
  const auto last = static_cast<std::int64_t>(values.size()) - 1;
  withVoxelType(from, [&]<class T>(std::type_identity<T>) {
    if constexpr (std::is_integral_v<T>) {
      for (std::size_t i = 0; i < count; ++i) {
        T stored;
        std::memcpy(&stored, in + i * sizeof(T), sizeof(T));
        const std::int64_t entry = std::clamp<std::int64_t>(std::int64_t{stored} - first, 0, last);
        const std::uint16_t value = values[static_cast<std::size_t>(entry)];
        const auto narrow = static_cast<std::uint8_t>(value);
        if (to == VoxelType::u16)
          std::memcpy(out + 2 * i, &value, sizeof value);
        else
          std::memcpy(out + i, &narrow, sizeof narrow);
      }
    }
  });
}

// The descriptor is the number of entries, where 0 stands for 65536; the first stored value; the bits of an entry.
// Entries of 8 bits may be bytes or words.
std::optional<DicomLut> modalityLut(const DicomSet& file, bool is_signed, const std::filesystem::path& path) {
  if (file.find(kModalityLut) == nullptr) return std::nullopt;
  const DicomSet* const item = file.item(kModalityLut);
  const auto fail = [&](DicomTag tag, const std::string& what) {
    throw Error(ErrorCode::kFormat, path, nameOf(tag), what + "; correct the header");
  };
  const std::vector<std::uint16_t> descriptor =
      item == nullptr ? std::vector<std::uint16_t>() : item->shorts(kLutDescriptor);
  if (descriptor.size() != 3) fail(kLutDescriptor, fmt::format("expected 3 numbers (found {})", descriptor.size()));
  DicomLut out;
  const std::size_t entries = descriptor[0] == 0 ? 65536 : descriptor[0];
  out.first = is_signed ? static_cast<std::int16_t>(descriptor[1]) : descriptor[1];
  out.bits = descriptor[2];
  if (out.bits < 8 || out.bits > 16)
    fail(kLutDescriptor, fmt::format("expected 8 to 16 bits an entry (found {})", out.bits));
  const DicomElement* const data = item->find(kLutData);
  const std::size_t bytes = data == nullptr ? 0 : data->value.size();
  if (out.bits == 8 && bytes == (entries + 1) / 2 * 2) {
    out.values.assign(entries, 0);
    // In big-endian files the first of two entries is the second byte of a word.
    for (std::size_t i = 0; i < entries; ++i)
      out.values[i] = static_cast<unsigned char>(data->value[data->big_endian ? i ^ 1 : i]);
  } else {
    out.values = item->shorts(kLutData);
    if (out.values.size() != entries)
      fail(kLutData, fmt::format("expected {} entries (found {} bytes)", entries, bytes));
    const auto most = static_cast<std::uint32_t>((1u << out.bits) - 1);
    for (std::uint16_t& value : out.values) value = static_cast<std::uint16_t>(std::min<std::uint32_t>(value, most));
  }
  return out;
}

}  // namespace kiln
