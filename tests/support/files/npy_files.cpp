#include "support/files/npy_files.h"

#include <fmt/format.h>

namespace kiln::test {
namespace {

constexpr const char* kNpyTypes[] = {"u1", "i1", "u2", "i2", "u4", "i4", "f4", "f8"};

// The stored voxels with z fastest, one at a time.
std::string inFortranOrder(const ForeignVolume& volume, const std::string& stored) {
  const Extent3& n = volume.dims;
  const std::size_t size = sizeOf(volume.type);
  std::string out;
  for (std::int64_t x = 0; x < n.x; ++x) {
    for (std::int64_t y = 0; y < n.y; ++y) {
      for (std::int64_t z = 0; z < n.z; ++z)
        out.append(stored, static_cast<std::size_t>((z * n.y + y) * n.x + x) * size, size);
    }
  }
  return out;
}

}  // namespace

std::string npyHeader(std::string_view dictionary, int major_version) {
  const std::size_t length_bytes = major_version == 1 ? 2 : 4, start = 8 + length_bytes;
  std::string text(dictionary);
  text.append(63 - (start + text.size()) % 64, ' ');
  text += '\n';
  std::string out = "\x93NUMPY";
  out += static_cast<char>(major_version);
  out += '\0';
  for (std::size_t i = 0; i < length_bytes; ++i) out += static_cast<char>(text.size() >> (8 * i) & 0xff);
  return out + text;
}

std::string npyDictionary(const ForeignVolume& volume, const NpyLayout& layout) {
  const char order = sizeOf(volume.type) == 1 ? '|' : layout.big_endian ? '>' : '<';
  return fmt::format("{{'descr': '{}{}', 'fortran_order': {}, 'shape': ({}, {}, {}), }}", order,
                     kNpyTypes[static_cast<int>(volume.type)], layout.fortran_order ? "True" : "False", volume.dims.z,
                     volume.dims.y, volume.dims.x);
}

std::string npyFile(const ForeignVolume& volume, const NpyLayout& layout) {
  const std::string stored = volume.stored(layout.big_endian);
  return npyHeader(npyDictionary(volume, layout), layout.major_version) +
         (layout.fortran_order ? inFortranOrder(volume, stored) : stored);
}

}  // namespace kiln::test
