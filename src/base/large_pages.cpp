#include "base/large_pages.h"

#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <cstring>

namespace kiln {

// The address sanitizer knows the ends of what operator new gives, and not of pages.
#ifdef __SANITIZE_ADDRESS__

void* takePages(std::size_t bytes) { return ::operator new(bytes, std::align_val_t(kLargePage)); }
void* takeZeroPages(std::size_t bytes) { return std::memset(takePages(bytes), 0, bytes); }
void giveBackPages(void* pages, std::size_t) noexcept { ::operator delete(pages, std::align_val_t(kLargePage)); }

#else

namespace {

std::atomic<std::size_t> held_pages = 0;

bool isPaged(const void* at) { return reinterpret_cast<std::uintptr_t>(at) % kLargePage == 0; }

// From the heap, at a place that no large page begins at; the byte before it says how far it is from the beginning.
void* takeFromHeap(std::size_t bytes) {
  constexpr std::size_t kRoom = 64;
  char* const room = static_cast<char*>(::operator new(bytes + 2 * kRoom));
  const std::size_t offset = isPaged(room + kRoom) ? 2 * kRoom : kRoom;
  room[offset - 1] = static_cast<char>(offset);
  return room + offset;
}

void giveBackToHeap(void* at) {
  char* const bytes = static_cast<char*>(at);
  ::operator delete(bytes - static_cast<unsigned char>(bytes[-1]));
}

// Null where the system has none.
void* map(std::size_t bytes) {
  const std::size_t room = bytes + kLargePage;
  void* const found = ::mmap(nullptr, room, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (found == MAP_FAILED) return nullptr;
  const auto small_page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
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

}  // namespace

void* takePages(std::size_t bytes) {
  if (held_pages.fetch_add(1, std::memory_order_relaxed) < kMostPaged) {
    if (void* const pages = map(bytes)) return pages;
  }
  held_pages.fetch_sub(1, std::memory_order_relaxed);
  return takeFromHeap(bytes);
}

// What the system maps is zero.
void* takeZeroPages(std::size_t bytes) {
  void* const pages = takePages(bytes);
  if (!isPaged(pages)) return std::memset(pages, 0, bytes);
#ifdef MADV_POPULATE_WRITE
  // The system gives a processor first what it has given back: a frame's picture gets the last one's pages.
  if (bytes <= kZerosAtOnce) ::madvise(pages, bytes, MADV_POPULATE_WRITE);
#endif
  return pages;
}

void giveBackPages(void* pages, std::size_t bytes) noexcept {
  if (!isPaged(pages)) return giveBackToHeap(pages);
  ::munmap(pages, bytes);
  held_pages.fetch_sub(1, std::memory_order_relaxed);
}

#endif

}  // namespace kiln
