// The binary header of a foreign file: numbers at documented offsets, in the writer's byte order.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace kiln {

class HeaderBytes {
 public:
  HeaderBytes(std::filesystem::path path, std::vector<std::byte> bytes, bool in_gzip = false)
      : path_(std::move(path)), bytes_(std::move(bytes)), in_gzip_(in_gzip) {}

  const std::filesystem::path& path() const { return path_; }
  std::size_t size() const { return bytes_.size(); }
  /// True if the file is in gzip, and these bytes are decompressed ones.
  bool inGzip() const { return in_gzip_; }
  bool bigEndian() const { return big_endian_; }
  void setBigEndian(bool big_endian) { big_endian_ = big_endian; }

  /// Returns the number at byte `offset`. requires: the number lies inside the header.
  template <class T>
  T get(std::size_t offset) const {
    assert(offset + sizeof(T) <= bytes_.size());
    std::array<std::byte, sizeof(T)> raw;
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(offset), sizeof(T), raw.begin());
    if (big_endian_ != (std::endian::native == std::endian::big)) std::reverse(raw.begin(), raw.end());
    return std::bit_cast<T>(raw);
  }
  /// Returns a 32-bit float as double.
  double f32(std::size_t offset) const { return static_cast<double>(get<float>(offset)); }
  /// Returns three 32-bit floats, one behind the other.
  glm::dvec3 vector(std::size_t offset) const { return {f32(offset), f32(offset + 4), f32(offset + 8)}; }
  /// True if `bytes` stand at `offset`.
  bool holds(std::size_t offset, std::string_view bytes) const {
    const std::string_view all(reinterpret_cast<const char*>(bytes_.data()), bytes_.size());
    return offset <= all.size() && all.substr(offset).starts_with(bytes);
  }

  /// Throws an Error kFormat at `place` ("byte 40").
  [[noreturn]] void fail(const std::string& place, const std::string& what) const;
  /// Throws an Error kUnsupported.
  [[noreturn]] void refuse(const std::string& what) const;

 private:
  std::filesystem::path path_;
  std::vector<std::byte> bytes_;
  bool in_gzip_;
  bool big_endian_ = false;
};

/// Returns the first `count` bytes of a file, decompressed if the file is in gzip.
/// throws: Error kFormat if the file is shorter, or its compressed data are damaged; kIo.
HeaderBytes readHeaderBytes(const std::filesystem::path& path, std::size_t count);

}  // namespace kiln
