// Large buffers have pages of their own. Freed pages are kept for the next buffer up to a bound; the rest returns to
// the system.
#include "base/memory/large_pages.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <memory>
#include <new>
#include <numeric>
#include <utility>
#include <vector>

#include "base/memory/spare_pages.h"
#include "base/memory/zero_pages.h"

namespace kiln {
namespace {

// Sanitizers keep freed memory to detect late uses, use shadow memory for all touched pages, and end the program when
// memory runs out. Tests of resident memory are left out there.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define KILN_OWN_PAGES
std::size_t residentBytes() {
  std::ifstream file("/proc/self/statm");
  std::size_t all = 0, resident = 0;
  file >> all >> resident;
  return resident * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}
#endif

TEST(LargePages, OfAnySizeAreAllTheirs) {
  for (const std::size_t bytes : {kLargePage - 1, kLargePage, kLargePage + 1, 3 * kLargePage + 12345}) {
    std::vector<ZeroPages<std::uint8_t>> held;
    for (std::uint8_t i = 0; i < 4; ++i) {
      held.emplace_back(bytes);
      EXPECT_EQ(std::accumulate(held.back().begin(), held.back().end(), std::size_t{0}), 0u);
      std::fill(held.back().begin(), held.back().end(), i);
    }
    for (std::size_t i = 0; i < held.size(); ++i) {
      EXPECT_EQ(std::accumulate(held[i].begin(), held[i].end(), std::size_t{0}), i * bytes);
      if (bytes >= kLargePage) {
        EXPECT_EQ(reinterpret_cast<std::uintptr_t>(held[i].data()) % kLargePage, 0u);
      }
    }
  }
}

TEST(LargePages, GrowAsAnyVectorDoes) {
  std::vector<std::uint32_t, UnsetAllocator<std::uint32_t>> values;
  for (std::uint32_t i = 0; i < (5u << 20) / 4; ++i) values.push_back(i);
  for (std::uint32_t i = 0; i < values.size(); ++i) ASSERT_EQ(values[i], i);
  const auto copy = values;
  values.clear();
  values.shrink_to_fit();
  EXPECT_EQ(copy.back(), copy.size() - 1);
}

TEST(LargePages, OfTheNextOnesAreNobodyElses) {
  using Numbers = std::vector<std::size_t, UnsetAllocator<std::size_t>>;
  std::vector<Numbers> held(6);
  for (std::size_t i = 0; i < 40; ++i) {
    Numbers& numbers = held[i * 5 % held.size()];
    if (!numbers.empty()) {
      EXPECT_EQ(std::count(numbers.begin(), numbers.end(), numbers[0]), static_cast<std::ptrdiff_t>(numbers.size()));
    }
    numbers = Numbers();
    numbers.resize((kLargePage + i * 7919 % 11 * 500'000) / sizeof i);
    std::fill(numbers.begin(), numbers.end(), i);
    const ZeroPages<std::size_t> zeros(numbers.size());
    ASSERT_EQ(std::count(zeros.begin(), zeros.end(), 0u), static_cast<std::ptrdiff_t>(zeros.size()));
  }
}

// New pages of the system are zero. Pages of a freed array are kept and cleared for the next array.
TEST(LargePages, OfAFreedArrayAreZeroInTheNext) {
  for (const std::size_t bytes : {kLargePage, 2 * kLargePage + 1, 8 * kLargePage - 12345}) {
    for (int round = 0; round < 4; ++round) {
      ZeroPages<std::uint8_t> array(bytes);
      ASSERT_EQ(std::count(array.begin(), array.end(), 0), static_cast<std::ptrdiff_t>(bytes)) << round;
      std::fill(array.begin(), array.end(), std::uint8_t{255});
    }
  }
}

TEST(LargePages, KeepWhatTheyHaveWhenTheirNumberChanges) {
  for (const std::size_t count : {std::size_t{5}, kLargePage / 4 - 1, kLargePage / 4, 3 * kLargePage / 4 + 17}) {
    ZeroPages<std::uint32_t> values(count, 7);
    values.resize(2 * count);
    ASSERT_EQ(values.size(), 2 * count);
    EXPECT_EQ(std::count(values.begin(), values.end(), 7u), static_cast<std::ptrdiff_t>(count));
    EXPECT_EQ(values[count - 1], 7u);
    EXPECT_EQ(values[count], 0u);
    values.back() = 9;
    const ZeroPages<std::uint32_t> copy = values;
    values.resize(3);
    EXPECT_EQ(values, (ZeroPages<std::uint32_t>{7, 7, 7}));
    // Elements removed by a smaller size are zero when the vector grows again.
    values.resize(2 * count);
    EXPECT_EQ(values.back(), 0u);
    EXPECT_NE(values, copy);
    values = copy;
    EXPECT_EQ(values, copy);
    const ZeroPages<std::uint32_t> moved = std::move(values);
    EXPECT_EQ(moved, copy);
    EXPECT_TRUE(values.empty());
  }
}

TEST(LargePages, MoreThanThereIsIsRefused) {
  const std::size_t most = static_cast<std::size_t>(-1) / 2;
  EXPECT_THROW(UnsetAllocator<std::uint64_t>().allocate(most), std::bad_alloc);
  EXPECT_THROW(static_cast<void>(ZeroPages<std::uint64_t>(most)), std::bad_alloc);
#ifdef KILN_OWN_PAGES
  EXPECT_THROW(takePages(most), std::bad_alloc);
#endif
}

#ifdef KILN_OWN_PAGES
// More buffers than the system's limit of mappings for a process: the heap supplies the rest, and each buffer returns
// to its origin.
TEST(LargePages, AreTheHeapsWhereThereAreTooMany) {
  std::vector<ZeroPages<std::byte>> few;
  std::vector<void*> many;
  for (std::size_t i = 0; i < kMostPaged + 20; ++i) {
    many.push_back(takePages(kLargePage));
    if (i % 1000 == 0 || i >= kMostPaged - 4) static_cast<char*>(many.back())[0] = static_cast<char>(i);
  }
  // Memory from the heap may have been used before.
  std::vector<std::unique_ptr<char[]>> used;
  for (int i = 0; i < 4; ++i) {
    used.push_back(std::make_unique_for_overwrite<char[]>(kLargePage + 128));
    std::fill_n(used.back().get(), kLargePage + 128, 'x');
  }
  used.clear();
  for (int i = 0; i < 4; ++i) {
    few.emplace_back(kLargePage + 5);
    EXPECT_EQ(std::count(few.back().begin(), few.back().end(), std::byte{0}), std::ptrdiff_t{kLargePage + 5});
    std::fill(few.back().begin(), few.back().end(), std::byte{7});
  }
  for (std::size_t i = kMostPaged - 4; i < many.size(); ++i)
    EXPECT_EQ(static_cast<char*>(many[i])[0], static_cast<char>(i));
  for (void* const pages : many) giveBackPages(pages, kLargePage);
  for (const ZeroPages<std::byte>& bytes : few) EXPECT_EQ(bytes.back(), std::byte{7});
  EXPECT_NE(reinterpret_cast<std::uintptr_t>(few.front().data()) % kLargePage, 0u);
  few.clear();
  const ZeroPages<std::byte> again(kLargePage);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(again.data()) % kLargePage, 0u);
}

TEST(LargePages, GoBackToTheSystem) {
  constexpr std::size_t kBytes = 37 * kLargePage + 4711;
  const std::size_t before = residentBytes();
  for (int i = 0; i < 8; ++i) {
    const ZeroPages<std::byte> bytes(kBytes, std::byte{1});
    EXPECT_GE(residentBytes(), before + kBytes / 10 * 9);
    // No page more than the buffer needs, apart from other activity of the process.
    EXPECT_LE(residentBytes(), before + kBytes + kLargePage / 2);
  }
  EXPECT_LE(residentBytes(), before + kLargePage / 2);
}

TEST(LargePages, AreSparedUpToABound) {
  using Numbers = std::vector<std::size_t, UnsetAllocator<std::size_t>>;
  constexpr std::size_t kBytes = 2 * kLargePage + 4712;
  // Frees the pages of earlier buffers of the process, and sets the bound anew.
  boundSparePages(0);
  boundSparePages(kMostSpare);
  const std::size_t before = residentBytes();
  std::vector<Numbers> held(12);
  for (int round = 0; round < 2; ++round) {
    for (Numbers& numbers : held) {
      numbers.resize(kBytes / sizeof(std::size_t));
      std::fill(numbers.begin(), numbers.end(), 1u);
    }
    EXPECT_LE(residentBytes(), before + held.size() * kBytes + kLargePage);
    for (Numbers& numbers : held) numbers = Numbers();
    EXPECT_LE(residentBytes(), before + kMostSpare);
    EXPECT_GE(residentBytes(), before + kMostSpare - 2 * kBytes);
  }
  // The next buffer reuses the kept pages: no new page becomes resident.
  const std::size_t spared = residentBytes();
  held.front().resize(kBytes / sizeof(std::size_t));
  std::fill(held.front().begin(), held.front().end(), 2u);
  EXPECT_LE(residentBytes(), spared + kLargePage / 4);
  // A buffer larger than the bound is not kept.
  held.front() = Numbers();
  held.front().resize((kMostSpare + kLargePage) / sizeof(std::size_t));
  std::fill(held.front().begin(), held.front().end(), 2u);
  held.front() = Numbers();
  EXPECT_LE(residentBytes(), before + kMostSpare);
}

TEST(LargePages, OfZerosComeWhenTheyAreTouched) {
  constexpr std::size_t kBytes = 37 * kLargePage + 4711;
  const std::size_t before = residentBytes();
  ZeroPages<std::byte> bytes(kBytes);
  EXPECT_LE(residentBytes(), before + kLargePage / 2);
  bytes[20 * kLargePage] = std::byte{1};
  EXPECT_LE(residentBytes(), before + 2 * kLargePage);
  EXPECT_EQ(std::count(bytes.begin(), bytes.end(), std::byte{0}), std::ptrdiff_t{kBytes - 1});
}
#endif

}  // namespace
}  // namespace kiln
