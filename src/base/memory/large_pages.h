// Memory in pages of 2 MiB, for buffers of some MiB: a page costs a fault when it is first touched, and on virtual
// machines 512 small ones cost up to twenty times what one large one does. Of a cold frame that was a third.
#pragma once

#include <cstddef>
#include <cstring>
#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace kiln {

/// Buffers of at least this are worth pages of their own. unit: bytes.
inline constexpr std::size_t kLargePage = std::size_t{2} << 20;

/// So many have them at a time; the rest is the heap's, as systems bound what a process maps (Linux to 65,530 pieces,
/// of which each may be two).
inline constexpr std::size_t kMostPaged = 16384;

/// unit: bytes.
inline constexpr std::size_t kZerosAtOnce = std::size_t{64} << 20;

/// So much of what is spared stays with the process: some bricks' voxels and files. unit: bytes.
inline constexpr std::size_t kMostSpare = std::size_t{32} << 20;

/// Bytes in large pages, as far as they fill them and where the system has them; it gets them back when they are given
/// back. Those of takeZeroPages are zero; up to kZerosAtOnce they are there at once, of more each comes to the thread
/// that touches it first. thread: safe. throws: std::bad_alloc.
void* takePages(std::size_t bytes);
void* takeZeroPages(std::size_t bytes);
void giveBackPages(void* pages, std::size_t bytes) noexcept;
/// The same, but up to kMostSpare stay for the next takePages of as much, as they are: where bricks come and go, the
/// system would clear each page again.
void sparePages(void* pages, std::size_t bytes) noexcept;

/// As std::allocator, but what is large has pages of its own, and elements that are not given a value have none: for
/// what is written anyway. Of decoding a brick setting its bytes to zero first would be a tenth.
template <class T>
struct UnsetAllocator {
  using value_type = T;
  UnsetAllocator() = default;
  template <class U>
  UnsetAllocator(const UnsetAllocator<U>&) {}

  T* allocate(std::size_t count) {
    return isSmall(count) ? std::allocator<T>().allocate(count) : static_cast<T*>(takePages(bytesOf(count)));
  }
  /// All of their bytes are zero.
  T* allocateZeros(std::size_t count) {
    void* const at = isSmall(count) ? std::memset(allocate(count), 0, bytesOf(count)) : takeZeroPages(bytesOf(count));
    return static_cast<T*>(at);
  }
  void deallocate(T* at, std::size_t count) noexcept { giveBack(at, count, sparePages); }
  /// Those of allocateZeros.
  void deallocateZeros(T* at, std::size_t count) noexcept { giveBack(at, count, giveBackPages); }
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
  static void giveBack(T* at, std::size_t count, void (*giveBackLarge)(void*, std::size_t) noexcept) noexcept {
    if (isSmall(count)) return std::allocator<T>().deallocate(at, count);
    giveBackLarge(at, count * sizeof(T));
  }
};

using UnsetBytes = std::vector<std::byte, UnsetAllocator<std::byte>>;

}  // namespace kiln
