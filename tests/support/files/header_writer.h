// Numbers put into the binary header of a foreign file, independently of the tested readers.
#pragma once

#include <algorithm>
#include <bit>
#include <cstring>
#include <string>

namespace kiln::test {

/// Writes `value` at byte `offset` of `header`.
template <class T>
void putNumber(std::string& header, std::size_t offset, T value, bool big_endian = false) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if (big_endian == (std::endian::native == std::endian::little)) std::reverse(raw, raw + sizeof(T));
  header.replace(offset, sizeof(T), raw, sizeof(T));
}

}  // namespace kiln::test
