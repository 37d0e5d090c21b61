// Appends and reads values in a sequence of bytes, in the byte order of this machine. Journals, resume entries and
// messages between processes are such sequences.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <vector>

namespace kiln {

/// Appends the bytes of a value. requires: T is trivially copyable and has no padding.
template <class T>
void appendValue(std::vector<std::byte>& out, const T& value) {
  const std::size_t at = out.size();
  out.resize(at + sizeof value);
  std::memcpy(out.data() + at, &value, sizeof value);
}

/// Appends a text and a terminating 0. requires: the text holds no 0.
inline void appendText(std::vector<std::byte>& out, const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text.c_str(), text.size() + 1));
  out.insert(out.end(), bytes.begin(), bytes.end());
}

/// Appends the number of values in a list (u64), then the values. requires: as appendValue.
template <class T>
void appendList(std::vector<std::byte>& out, const std::vector<T>& list) {
  appendValue(out, static_cast<std::uint64_t>(list.size()));
  const auto bytes = std::as_bytes(std::span(list));
  out.insert(out.end(), bytes.begin(), bytes.end());
}

/// Reads values from the front of a byte sequence. `ok` becomes false at the first value beyond the end and stays
/// false.
struct ByteTaker {
  std::span<const std::byte> left;
  bool ok = true;

  template <class T>
  T take() {
    T value{};
    if (left.size() < sizeof value) return ok = false, value;
    std::memcpy(&value, left.data(), sizeof value);
    left = left.subspan(sizeof value);
    return value;
  }
  /// Reads an unsigned number that was written with its highest byte first.
  template <class T>
  T takeBigEndian() {
    T value = 0;
    for (const std::byte byte : takeBytes(sizeof value)) value = static_cast<T>(value << 8 | std::to_integer<T>(byte));
    return value;
  }
  std::span<const std::byte> takeBytes(std::uint64_t count) {
    if (left.size() < count) return ok = false, std::span<const std::byte>();
    const std::span<const std::byte> out = left.first(count);
    left = left.subspan(count);
    return out;
  }
  template <class T>
  std::vector<T> takeList() {
    const auto count = take<std::uint64_t>();
    if (count > left.size() / sizeof(T)) return ok = false, std::vector<T>();
    std::vector<T> out(count);
    const std::span<const std::byte> bytes = takeBytes(count * sizeof(T));
    if (!bytes.empty()) std::memcpy(out.data(), bytes.data(), bytes.size());
    return out;
  }
  std::string takeText() {
    const auto* first = reinterpret_cast<const char*>(left.data());
    const std::size_t length = strnlen(first, left.size());
    if (length == left.size()) return ok = false, std::string();
    left = left.subspan(length + 1);
    return std::string(first, length);
  }
};

}  // namespace kiln
