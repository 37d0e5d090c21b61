// Memory in pages of 2 MiB, for buffers of some MiB.
// The first touch of a page costs a page fault. On virtual machines 512 small faults cost up to 20 times as much as one
// large fault: a third of a cold frame.
#pragma once

#include <cstddef>
#include <cstring>
#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace kiln {

/// Least size of a buffer with pages of its own; smaller buffers come from the heap. unit: bytes.
inline constexpr std::size_t kLargePage = std::size_t{2} << 20;

/// Upper bound of buffers with pages of their own; further buffers come from the heap. Linux limits a process to 65,530
/// mappings, and a buffer may take two.
inline constexpr std::size_t kMostPaged = 16384;

/// New zeroed buffers up to this size are populated when taken; larger ones page by page at the first touch. unit:
/// bytes.
inline constexpr std::size_t kZerosAtOnce = std::size_t{64} << 20;

/// Upper bound of spared memory that stays with the process: voxels and files of some bricks. unit: bytes.
inline constexpr std::size_t kMostSpare = std::size_t{32} << 20;

/// Allocate memory in large pages, as far as a buffer fills them and the system has them; `giveBackPages` returns them.
/// Memory of takeZeroPages is zero: all threads clear spared pages, new ones are zero; beyond kZerosAtOnce the thread
/// that touches a new page first pays its fault. requires: the caller holds no lock that tasks of other threads need.
/// thread: safe. throws: std::bad_alloc.
void* takePages(std::size_t bytes);
void* takeZeroPages(std::size_t bytes);
void giveBackPages(void* pages, std::size_t bytes) noexcept;
/// Keeps up to kMostSpare bytes for the next buffer of equal size in MiB, with their contents. A renderer replaces
/// bricks and pictures all the time, and the system would clear each page again.
void sparePages(void* pages, std::size_t bytes) noexcept;

/// An allocator as std::allocator, but large buffers have pages of their own, and elements without a value stay
/// uninitialized. Use for buffers that are overwritten anyway: zeroing them first is a tenth of the time to decode a
/// brick.
template <class T>
struct UnsetAllocator {
  using value_type = T;
  UnsetAllocator() = default;
  template <class U>
  UnsetAllocator(const UnsetAllocator<U>&) {}

  T* allocate(std::size_t count) {
    return isSmall(count) ? std::allocator<T>().allocate(count) : static_cast<T*>(takePages(bytesOf(count)));
  }
  void deallocate(T* at, std::size_t count) noexcept {
    if (isSmall(count)) return std::allocator<T>().deallocate(at, count);
    sparePages(at, count * sizeof(T));
  }
  template <class U>
  void construct(U* at) {
    ::new (static_cast<void*>(at)) U;
  }
  template <class U, class... Args>
  void construct(U* at, Args&&... args) {
    std::construct_at(at, std::forward<Args>(args)...);
  }
  template <class U>
  bool operator==(const UnsetAllocator<U>&) const {
    return true;
  }

 private:
  static bool isSmall(std::size_t count) { return count < kLargePage / sizeof(T); }
  static std::size_t bytesOf(std::size_t count) {
    if (count > static_cast<std::size_t>(-1) / 2 / sizeof(T)) throw std::bad_array_new_length();
    return count * sizeof(T);
  }
};

using UnsetBytes = std::vector<std::byte, UnsetAllocator<std::byte>>;

}  // namespace kiln
