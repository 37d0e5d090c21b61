#include "base/memory/large_pages.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <mutex>
#include <vector>

#include "base/memory/spare_pages.h"
#include "base/thread/parallel.h"

namespace kiln {

// The address sanitizer checks bounds of operator new, not of mapped pages.
#ifdef __SANITIZE_ADDRESS__

void* takePages(std::size_t bytes) { return ::operator new(bytes, std::align_val_t(kLargePage)); }
void* takeZeroPages(std::size_t bytes) { return std::memset(takePages(bytes), 0, bytes); }
void giveBackPages(void* pages, std::size_t) noexcept { ::operator delete(pages, std::align_val_t(kLargePage)); }
void sparePages(void* pages, std::size_t bytes) noexcept { giveBackPages(pages, bytes); }
void boundSparePages(std::size_t) noexcept {}

#else

namespace {

std::atomic<std::size_t> held_pages = 0;

bool isPaged(const void* at) { return reinterpret_cast<std::uintptr_t>(at) % kLargePage == 0; }

// Allocates from the heap at an address that is no multiple of kLargePage. The byte before the address holds the offset
// from the start of the allocation.
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

std::size_t roundedUp(std::size_t bytes, std::size_t step) { return (bytes + step - 1) / step * step; }

// Size of the mapping for a buffer. Rounding up gives brick files few distinct sizes, so a spared mapping fits the next
// file. Untouched pages cost nothing.
std::size_t mappedFor(std::size_t bytes) { return roundedUp(bytes, std::size_t{1} << 20); }

// Returns null if the system has no memory.
void* map(std::size_t bytes) {
  const std::size_t mapped = mappedFor(bytes), room = mapped + kLargePage;
  void* const found = ::mmap(nullptr, room, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (found == MAP_FAILED) return nullptr;
  const auto small_page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  const std::size_t before = (kLargePage - reinterpret_cast<std::uintptr_t>(found) % kLargePage) % kLargePage;
  char* const pages = static_cast<char*>(found) + before;
  if (before > 0) ::munmap(found, before);
  if (before + mapped < room) ::munmap(pages + mapped, room - before - mapped);
  // Only full large pages: the rest of a last one would be memory outside the budget. The system may substitute small
  // pages.
  const std::size_t filled = bytes / kLargePage * kLargePage;
#ifdef MADV_HUGEPAGE
  ::madvise(pages, filled, MADV_HUGEPAGE);
#endif
#ifdef MADV_POPULATE_WRITE
  // Populates the remaining small pages at once instead of fault by fault.
  const std::size_t used = roundedUp(bytes, small_page);
  if (used > filled) ::madvise(pages + filled, used - filled, MADV_POPULATE_WRITE);
#endif
  return pages;
}

// Returns null if kMostPaged buffers exist or the system has no memory.
void* takeMapped(std::size_t bytes) {
  if (held_pages.fetch_add(1, std::memory_order_relaxed) < kMostPaged) {
    if (void* const pages = map(bytes)) return pages;
  }
  held_pages.fetch_sub(1, std::memory_order_relaxed);
  return nullptr;
}

void unmap(void* pages, std::size_t bytes) {
  ::munmap(pages, mappedFor(bytes));
  held_pages.fetch_sub(1, std::memory_order_relaxed);
}

// Mappings kept for the next buffers of equal size.
class SparePages {
 public:
  // Reserved now, so `keep` never allocates.
  SparePages() { spare_.reserve(kMostSpare / kLargePage + 1); }

  // Returns null if no kept mapping has this size.
  void* take(std::size_t bytes) {
    const std::lock_guard lock(mutex_);
    const auto last = std::find_if(spare_.rbegin(), spare_.rend(),
                                   [&](const Spare& spare) { return spare.mapped == mappedFor(bytes); });
    if (last == spare_.rend()) return nullptr;
    void* const pages = last->pages;
    held_bytes_ -= last->mapped;
    spare_.erase(std::next(last).base());
    return pages;
  }

  // Keeps a mapping and drops the oldest mappings beyond the bound.
  void keep(void* pages, std::size_t bytes) {
    const std::size_t mapped = mappedFor(bytes);
    const std::lock_guard lock(mutex_);
    if (mapped > most_bytes_) return unmap(pages, mapped);
    dropBeyond(most_bytes_ - mapped);
    spare_.push_back({pages, mapped});
    held_bytes_ += mapped;
  }

  void bound(std::size_t bytes) {
    const std::lock_guard lock(mutex_);
    most_bytes_ = std::min(bytes, kMostSpare);
    dropBeyond(most_bytes_);
  }

 private:
  void dropBeyond(std::size_t bytes) {
    auto kept = spare_.begin();
    for (; held_bytes_ > bytes; ++kept) {
      held_bytes_ -= kept->mapped;
      unmap(kept->pages, kept->mapped);
    }
    spare_.erase(spare_.begin(), kept);
  }

  struct Spare {
    void* pages;
    std::size_t mapped;
  };
  std::mutex mutex_;
  std::vector<Spare> spare_;
  std::size_t held_bytes_ = 0, most_bytes_ = kMostSpare;
};

// Clears memory by all threads.
void clearTogether(void* at, std::size_t bytes) {
  constexpr std::size_t kChunk = std::size_t{256} << 10;
  parallelFor((bytes + kChunk - 1) / kChunk, [&](std::size_t i) {
    std::memset(static_cast<char*>(at) + i * kChunk, 0, std::min(kChunk, bytes - i * kChunk));
  });
}

// Never destroyed: static objects may free buffers after all destructors.
SparePages& sparedPages() {
  static SparePages& spared = *new SparePages;
  return spared;
}

}  // namespace

void* takePages(std::size_t bytes) {
  if (void* const pages = sparedPages().take(bytes)) return pages;
  if (void* const pages = takeMapped(bytes)) return pages;
  return takeFromHeap(bytes);
}

// New mapped pages are zero; spared ones are cleared by all threads.
void* takeZeroPages(std::size_t bytes) {
  if (void* const spared = sparedPages().take(bytes)) {
    clearTogether(spared, bytes);
    return spared;
  }
  void* const pages = takeMapped(bytes);
  if (pages == nullptr) return std::memset(takeFromHeap(bytes), 0, bytes);
#ifdef MADV_POPULATE_WRITE
  // Populated now: the system reuses the pages that this processor freed last.
  if (bytes <= kZerosAtOnce) ::madvise(pages, bytes, MADV_POPULATE_WRITE);
#endif
  return pages;
}

void giveBackPages(void* pages, std::size_t bytes) noexcept {
  if (isPaged(pages))
    unmap(pages, bytes);
  else
    giveBackToHeap(pages);
}

void sparePages(void* pages, std::size_t bytes) noexcept {
  if (isPaged(pages))
    sparedPages().keep(pages, bytes);
  else
    giveBackPages(pages, bytes);
}

void boundSparePages(std::size_t bytes) noexcept { sparedPages().bound(bytes); }

#endif

}  // namespace kiln
