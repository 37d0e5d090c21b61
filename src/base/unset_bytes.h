// Bytes that are not set to zero first, for buffers of some MiB whose every byte is written anyway: of decoding a brick
// it would be a tenth.
#pragma once

#include <cstddef>
#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace kiln {

/// As std::allocator, but elements that are not given a value have none.
template <class T>
struct UnsetAllocator : std::allocator<T> {
  template <class U>
  struct rebind {
    using other = UnsetAllocator<U>;
  };
  template <class U>
  void construct(U* at) {
    ::new (static_cast<void*>(at)) U;
  }
  template <class U, class... Args>
  void construct(U* at, Args&&... args) {
    std::construct_at(at, std::forward<Args>(args)...);
  }
};

using UnsetBytes = std::vector<std::byte, UnsetAllocator<std::byte>>;

}  // namespace kiln
