#include "base/hash.h"

#include <xxhash.h>

#include <cstring>
#include <new>

#include "base/error.h"

namespace kiln {
namespace {

Hash128 canonicalOf(const XXH128_hash_t& hash) {
  XXH128_canonical_t canonical;
  XXH128_canonicalFromHash(&canonical, hash);
  Hash128 out;
  static_assert(sizeof canonical.digest == sizeof out.bytes);
  std::memcpy(out.bytes.data(), canonical.digest, sizeof canonical.digest);
  return out;
}

}  // namespace

struct HashStream::State {
  XXH3_state_t* const state = XXH3_createState();
  ~State() { XXH3_freeState(state); }
};

HashStream::HashStream() : state_(std::make_unique<State>()) {
  if (state_->state == nullptr) throw std::bad_alloc();
  XXH3_128bits_reset(state_->state);
}
HashStream::~HashStream() = default;
void HashStream::add(std::span<const std::byte> piece) {
  XXH3_128bits_update(state_->state, piece.data(), piece.size());
}
Hash128 HashStream::value() const { return canonicalOf(XXH3_128bits_digest(state_->state)); }

Hash128 hashOf(std::span<const std::byte> data) { return canonicalOf(XXH3_128bits(data.data(), data.size())); }

Hash128 hashOf(std::string_view text) { return hashOf(std::as_bytes(std::span(text.data(), text.size()))); }

std::string toHex(const Hash128& hash) {
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string out;
  for (const std::uint8_t byte : hash.bytes) {
    out += kDigits[byte >> 4];
    out += kDigits[byte & 15];
  }
  return out;
}

Hash128 hashFromHex(std::string_view hex) {
  Hash128 out;
  const auto digit = [&](char c) -> int {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    throw Error(ErrorCode::kFormat, "checksum '" + std::string(hex) + "' has a character that is not 0-9 or a-f");
  };
  if (hex.size() != 2 * out.bytes.size()) {
    throw Error(ErrorCode::kFormat, "checksum '" + std::string(hex) + "' is not 32 hexadecimal digits");
  }
  for (std::size_t i = 0; i < out.bytes.size(); ++i) {
    out.bytes[i] = static_cast<std::uint8_t>(digit(hex[2 * i]) * 16 + digit(hex[2 * i + 1]));
  }
  return out;
}

}  // namespace kiln
