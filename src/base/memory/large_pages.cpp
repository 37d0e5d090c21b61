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

namespace kiln {

// The address sanitizer knows the ends of what operator new gives, and not of pages.
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

std::size_t roundedUp(std::size_t bytes, std::size_t step) { return (bytes + step - 1) / step * step; }

// What is mapped for so many bytes: files of bricks have a few such sizes and not one each, so that what one had is
// enough for another. What is not touched costs nothing.
std::size_t mappedFor(std::size_t bytes) { return roundedUp(bytes, std::size_t{1} << 20); }

// Null where the system has none.
void* map(std::size_t bytes) {
  const std::size_t mapped = mappedFor(bytes), room = mapped + kLargePage;
  void* const found = ::mmap(nullptr, room, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (found == MAP_FAILED) return nullptr;
  const auto small_page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  const std::size_t before = (kLargePage - reinterpret_cast<std::uintptr_t>(found) % kLargePage) % kLargePage;
  char* const pages = static_cast<char*>(found) + before;
  if (before > 0) ::munmap(found, before);
  if (before + mapped < room) ::munmap(pages + mapped, room - before - mapped);
  // Only those that it fills: more would be charged to nobody. Where the system has none, they are small.
  const std::size_t filled = bytes / kLargePage * kLargePage;
#ifdef MADV_HUGEPAGE
  ::madvise(pages, filled, MADV_HUGEPAGE);
#endif
#ifdef MADV_POPULATE_WRITE
  // The rest at once instead of fault by fault.
  const std::size_t used = roundedUp(bytes, small_page);
  if (used > filled) ::madvise(pages + filled, used - filled, MADV_POPULATE_WRITE);
#endif
  return pages;
}

// Null where all that are to be had at a time are.
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

// What is kept for whoever needs as much next.
class SparePages {
 public:
  // Keeping takes no memory.
  SparePages() { spare_.reserve(kMostSpare / kLargePage + 1); }

  // Null where there are none for so many bytes.
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

  // Those that were spared first go.
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

// Never destroyed: what is static may be given back last of all.
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

// What the system maps is zero.
void* takeZeroPages(std::size_t bytes) {
  void* const pages = takeMapped(bytes);
  if (pages == nullptr) return std::memset(takeFromHeap(bytes), 0, bytes);
#ifdef MADV_POPULATE_WRITE
  // The system gives a processor first what it has given back: a frame's picture gets the last one's pages.
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
