// What ranks say to each other, as bytes: numbers and lists of them as they are in memory, because all ranks are the
// same program on the same kind of machine.
#pragma once

#include <cstddef>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/error.h"

namespace kiln {

class ParcelWriter {
 public:
  template <class T>
  requires std::is_trivially_copyable_v<T>
  void put(const T& value) { putBytes(std::as_bytes(std::span(&value, 1))); }
  void put(const std::string& text) { putList(std::span(text)); }
  template <class T>
  void put(const std::vector<T>& list) {
    putList(std::span(list));
  }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  template <class T>
  void putList(std::span<T> list) {
    put(list.size());
    putBytes(std::as_bytes(list));
  }
  void putBytes(std::span<const std::byte> bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }
  std::vector<std::byte> bytes_;
};

class ParcelReader {
 public:
  explicit ParcelReader(std::span<const std::byte> bytes) : bytes_(bytes) {}
  template <class T>
  requires std::is_trivially_copyable_v<T> T get() {
    T out{};
    copyTo(std::as_writable_bytes(std::span(&out, 1)));
    return out;
  }
  std::string getText() {
    std::string out(get<std::size_t>(), '\0');
    copyTo(std::as_writable_bytes(std::span(out)));
    return out;
  }
  template <class T>
  std::vector<T> getList() {
    std::vector<T> out(get<std::size_t>());
    copyTo(std::as_writable_bytes(std::span(out)));
    return out;
  }

 private:
  void copyTo(std::span<std::byte> out) {
    if (out.size() > bytes_.size())
      throw Error(ErrorCode::kIo, "a message between ranks is cut short; are all of them the same version of Kiln?");
    std::memcpy(out.data(), bytes_.data(), out.size());
    bytes_ = bytes_.subspan(out.size());
  }
  std::span<const std::byte> bytes_;
};

}  // namespace kiln
