// Memory of the machine and the process, as counted by the operating system, and byte counts as text.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace kiln {

/// Memory of the machine; 0 if unknown. unit: bytes.
std::uint64_t machineMemoryBytes();

/// The largest resident memory of this process so far. unit: bytes.
std::uint64_t peakResidentBytes();

/// From now on up to some hundred MiB of freed memory stay with the process. Otherwise the system clears each page
/// again. Use for work that allocates and frees buffers of a few MiB all the time.
void keepFreedMemory();

/// From now on all threads share few heaps. Each heap keeps a few MiB of freed memory outside the budget. Use for work
/// whose threads seldom allocate.
void shareHeaps();

/// From now on up to 4 MiB of freed buffers stay with each heap, less within small budgets. Otherwise the system clears
/// the pages of a picture's buffers again in each frame: 10 to 30 % of a warm frame of 512x512 pixels.
/// Two volumes within 24 MiB exceed the 50 MiB allowed above the budget by 3 MiB if heaps keep as much there.
void keepFreedBuffers(std::uint64_t budget_bytes);

/// Returns freed memory to the system, before other work whose buffers are counted anew.
void returnFreedMemory();

/// Parses "2G", "512M", "64K", "1.5GiB" or a plain number of bytes; K, M, G and T are powers of 1024.
/// throws: Error kUsage, which names `option` unless empty.
std::uint64_t parseBytes(std::string_view text, std::string_view option = {});

/// Formats for people: "1.50 GiB", "32.0 MiB", "17 bytes".
std::string formatBytes(std::uint64_t bytes);

/// Formats as an argument of at least `bytes`: "38M", whole megabytes.
std::string roundedUpBytes(std::uint64_t bytes);

}  // namespace kiln
