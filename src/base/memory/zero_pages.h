// A large array that begins as zeros, which nobody writes: the system's pages are zero when they come. Of a very large
// one they come one by one to whoever writes in them first, so that threads that fill it together share that cost, too,
// and what stays empty costs nothing. To write 550 MiB of sub-pixels full of zeros before any thread draws took 0.05 s
// of each frame, of a first one 1.6 s, as a virtual machine's pages are its host's to find.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <initializer_list>
#include <memory>
#include <type_traits>
#include <utility>

#include "base/memory/large_pages.h"

namespace kiln {

/// What std::vector is to a reader; its size changes by `resize` alone. requires: T's zero is all of its bytes zero.
template <class T>
class ZeroPages {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  using value_type = T;
  using size_type = std::size_t;
  using iterator = T*;
  using const_iterator = const T*;

  ZeroPages() = default;
  /// throws: std::bad_alloc, std::bad_array_new_length.
  explicit ZeroPages(std::size_t count) : pages_(take(count)), size_(count) {}
  ZeroPages(std::size_t count, T value) : ZeroPages(count) { std::fill(begin(), end(), value); }
  ZeroPages(std::initializer_list<T> values) : ZeroPages(values.size()) {
    std::copy(values.begin(), values.end(), begin());
  }
  ZeroPages(const ZeroPages& other) : ZeroPages(other.size_) { copyFrom(other); }
  ZeroPages(ZeroPages&& other) noexcept : pages_(std::move(other.pages_)), size_(std::exchange(other.size_, 0)) {}
  ZeroPages& operator=(ZeroPages other) noexcept {
    swap(other);
    return *this;
  }
  ~ZeroPages() = default;

  void swap(ZeroPages& other) noexcept {
    std::swap(pages_, other.pages_);
    std::swap(size_, other.size_);
  }
  void clear() { *this = ZeroPages(); }
  /// Those there are stay, those beyond them are zero. cost: both of its sizes, for a moment.
  void resize(std::size_t count) {
    ZeroPages out(count);
    out.copyFrom(*this);
    swap(out);
  }

  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  T* data() { return pages_.get(); }
  const T* data() const { return pages_.get(); }
  T* begin() { return data(); }
  T* end() { return data() + size_; }
  const T* begin() const { return data(); }
  const T* end() const { return data() + size_; }
  T& operator[](std::size_t i) { return data()[i]; }
  const T& operator[](std::size_t i) const { return data()[i]; }
  T& front() { return data()[0]; }
  const T& front() const { return data()[0]; }
  T& back() { return data()[size_ - 1]; }
  const T& back() const { return data()[size_ - 1]; }

  bool operator==(const ZeroPages& other) const {
    return size_ == other.size_ && std::equal(begin(), end(), other.begin());
  }

 private:
  struct GiveBack {
    std::size_t count = 0;
    void operator()(T* pages) const noexcept { UnsetAllocator<T>().deallocateZeros(pages, count); }
  };
  using Pages = std::unique_ptr<T, GiveBack>;

  static Pages take(std::size_t count) {
    return count == 0 ? Pages() : Pages(UnsetAllocator<T>().allocateZeros(count), GiveBack{count});
  }
  void copyFrom(const ZeroPages& other) {
    if (const std::size_t count = std::min(size_, other.size_); count > 0)
      std::memcpy(data(), other.data(), count * sizeof(T));
  }

  Pages pages_;
  std::size_t size_ = 0;
};

}  // namespace kiln
