#include "base/memory/memory.h"

#include <fmt/format.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>

#include "base/error.h"

namespace kiln {

std::uint64_t machineMemoryBytes() {
  const long pages = ::sysconf(_SC_PHYS_PAGES), page_bytes = ::sysconf(_SC_PAGESIZE);
  return pages > 0 && page_bytes > 0 ? static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page_bytes) : 0;
}

std::uint64_t peakResidentBytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

void keepFreedMemory() {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 32 << 20);  // the greatest accepted value
  mallopt(M_TRIM_THRESHOLD, 256 << 20);
#endif
}

void shareHeaps() {
#ifdef __GLIBC__
  constexpr int kHeaps = 4;
  mallopt(M_ARENA_MAX, kHeaps);
#endif
}

void keepFreedBuffers(std::uint64_t budget_bytes) {
#ifdef __GLIBC__
  // Larger buffers mostly have pages of their own (large_pages.h). A reserve of 64 MiB saves no more page faults.
  constexpr std::uint64_t kFirstValue = 128 << 10;  // of glibc, for both
  constexpr std::uint64_t kLargestBuffer = 2 << 20, kReserve = 4 << 20;
  mallopt(M_MMAP_THRESHOLD, static_cast<int>(std::clamp(budget_bytes / 32, kFirstValue, kLargestBuffer)));
  mallopt(M_TRIM_THRESHOLD, static_cast<int>(std::clamp(budget_bytes / 16, kFirstValue, kReserve)));
#else
  static_cast<void>(budget_bytes);
#endif
}

void returnFreedMemory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

std::uint64_t parseBytes(std::string_view text, std::string_view option) {
  const auto refuse = [&] {
    return Error(ErrorCode::kUsage, std::string(option) + (option.empty() ? "'" : ": '") + std::string(text) +
                                        "' is not an amount of memory; write 512M, 2G or bytes");
  };
  double number = 0;
  const auto [rest, status] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (status != std::errc() || !(number >= 0)) throw refuse();
  std::string unit;
  for (const char* c = rest; c != text.data() + text.size(); ++c) {
    unit += static_cast<char>(std::toupper(static_cast<unsigned char>(*c)));
  }
  if (unit.ends_with("IB"))
    unit.resize(unit.size() - 2);
  else if (unit.ends_with("B"))
    unit.resize(unit.size() - 1);
  static constexpr std::array<std::string_view, 5> kUnits = {"", "K", "M", "G", "T"};
  for (std::size_t power = 0; power < kUnits.size(); ++power) {
    if (unit != kUnits[power]) continue;
    const double bytes = std::ldexp(number, static_cast<int>(10 * power));
    if (bytes >= 9e18) throw refuse();
    return static_cast<std::uint64_t>(bytes);
  }
  throw refuse();
}

std::string formatBytes(std::uint64_t bytes) {
  static constexpr std::array<const char*, 5> kUnits = {"bytes", "KiB", "MiB", "GiB", "TiB"};
  double amount = static_cast<double>(bytes);
  std::size_t unit = 0;
  while (amount >= 1024 && unit + 1 < kUnits.size()) {
    amount /= 1024;
    ++unit;
  }
  if (unit == 0) return fmt::format("{} bytes", bytes);
  return fmt::format("{:.{}f} {}", amount, amount < 10 ? 2 : 1, kUnits[unit]);
}

std::string roundedUpBytes(std::uint64_t bytes) {
  constexpr std::uint64_t kMega = 1u << 20;
  return fmt::format("{}M", bytes / kMega + (bytes % kMega > 0 ? 1 : 0));
}

}  // namespace kiln
