// What the machine has and the process holds, as the operating system counts, and how amounts are read and written.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace kiln {

/// Of the machine; 0 where the system does not say. unit: bytes.
std::uint64_t machineMemoryBytes();

/// The largest resident memory of this process so far. unit: bytes.
std::uint64_t peakResidentBytes();

/// From here on freed memory stays with the process, up to some hundred MiB, instead of going back to the system, which
/// clears each page before it gives it again: for work whose buffers of a few MiB come and go all the time.
void keepFreedMemory();

/// From here on all threads together have few heaps: each heap keeps a few MiB of freed memory, which nobody counts.
/// For work whose threads seldom allocate.
void shareHeaps();

/// Gives freed memory back to the system: for work of another kind whose buffers are counted anew.
void returnFreedMemory();

/// "2G", "512M", "64K", "1.5GiB" or a plain number of bytes; K, M, G and T are powers of 1024.
/// throws: Error kUsage, which names `option` where there is one.
std::uint64_t parseBytes(std::string_view text, std::string_view option = {});

/// For people: "1.50 GiB", "32.0 MiB", "17 bytes".
std::string formatBytes(std::uint64_t bytes);

/// As an argument that asks for no less: "38M", whole megabytes.
std::string roundedUpBytes(std::uint64_t bytes);

}  // namespace kiln
