// 128-bit content hashes (XXH3) for the checksums of a store and for reproducible file identifiers.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace kiln {

struct Hash128 {
  std::array<std::uint8_t, 16> bytes{};
  bool operator==(const Hash128&) const = default;
};

/// The XXH3-128 hash of `data` in its canonical (big-endian) byte order. cost: about 10 GB/s.
Hash128 hashOf(std::span<const std::byte> data);
Hash128 hashOf(std::string_view text);

/// Hashes bytes that come in pieces; `value` equals hashOf of all bytes.
class HashStream {
 public:
  HashStream();
  ~HashStream();
  void add(std::span<const std::byte> piece);
  Hash128 value() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Converts to 32 lower-case hexadecimal digits and back. throws: Error kFormat if `hex` is not 32 such digits.
std::string toHex(const Hash128& hash);
Hash128 hashFromHex(std::string_view hex);

}  // namespace kiln
