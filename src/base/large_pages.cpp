#include "base/large_pages.h"

#include <sys/mman.h>

#include <cstdint>

namespace kiln {

// The address sanitizer knows the ends of what operator new gives, and not of pages.
#ifdef __SANITIZE_ADDRESS__

void* takePages(std::size_t bytes) { return ::operator new(bytes, std::align_val_t(kLargePage)); }
void giveBackPages(void* pages, std::size_t) noexcept { ::operator delete(pages, std::align_val_t(kLargePage)); }

#else

void* takePages(std::size_t bytes) {
  const std::size_t room = bytes + kLargePage;
  void* const found = ::mmap(nullptr, room, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (found == MAP_FAILED) throw std::bad_alloc();
  const std::size_t small_page = 4096;
  const std::size_t before = (kLargePage - reinterpret_cast<std::uintptr_t>(found) % kLargePage) % kLargePage;
  char* const pages = static_cast<char*>(found) + before;
  if (before > 0) ::munmap(found, before);
  const std::size_t used = (bytes + small_page - 1) / small_page * small_page;
  if (before + used < room) ::munmap(pages + used, room - before - used);
  // Only those that it fills: more would be charged to nobody. Where the system has none, they are small.
  const std::size_t filled = bytes / kLargePage * kLargePage;
#ifdef MADV_HUGEPAGE
  ::madvise(pages, filled, MADV_HUGEPAGE);
#endif
#ifdef MADV_POPULATE_WRITE
  // The rest at once instead of fault by fault.
  if (used > filled) ::madvise(pages + filled, used - filled, MADV_POPULATE_WRITE);
#endif
  return pages;
}

void giveBackPages(void* pages, std::size_t bytes) noexcept { ::munmap(pages, bytes); }

#endif

}  // namespace kiln
