#pragma once

#include <cstddef>
#include <span>
#include <string_view>

namespace kiln::test {

/// The bytes as text, for `writeText`. requires: the bytes outlive the text.
inline std::string_view textOf(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace kiln::test
