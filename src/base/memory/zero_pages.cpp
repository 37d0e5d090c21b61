#include "base/memory/zero_pages.h"

#include "base/memory/large_pages.h"

namespace kiln {

void* takeZeros(std::size_t bytes) {
  if (bytes < kLargePage) return std::memset(::operator new(bytes), 0, bytes);
  return takeZeroPages(bytes);
}

void giveBackZeros(void* zeros, std::size_t bytes) noexcept {
  if (bytes < kLargePage) return ::operator delete(zeros);
  sparePages(zeros, bytes);
}

}  // namespace kiln
