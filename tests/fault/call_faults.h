// System calls that fail on demand. The test executable defines read, open, rename and similar functions, so that all
// its libraries call these definitions (libstdc++, libtiff, OpenEXR, libpng, zlib, OpenVDB, GDCM). Not covered are
// calls inside libc: stdio's writes to standard output and error, posix_spawn, the dynamic loader. fopen, fclose,
// opendir and readdir are replaced as a whole.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

namespace kiln::test {

/// The failures of a call.
enum class CallFailure {
  kNone,
  kIo,           // EIO, of every call
  kInterrupted,  // EINTR, for calls that a signal may interrupt
  kShort,        // half of the bytes, of reads and writes
  kEnd,          // reads return no byte: another program has truncated the file
  kNoSpace,      // ENOSPC, for calls that write
};
constexpr std::size_t kCallFailures = 6;

struct CallFault {
  CallFailure failure = CallFailure::kNone;
  /// Number of successful calls of this kind before the failing call. The default never fails.
  std::uint64_t after_calls = std::numeric_limits<std::uint64_t>::max();
};

struct ToolUnderFault {
  /// Exit code of the program; minus the number of a terminating signal.
  int exit_code = 0;
  /// The failed call and its file, "pread /tmp/a.nrrd"; empty if none failed.
  std::string failed_call;
  /// Number of calls that could have failed in each way. shape: by CallFailure.
  std::array<std::uint64_t, kCallFailures> calls{};
  std::uint64_t callsOf(CallFailure failure) const { return calls[static_cast<std::size_t>(failure)]; }
  std::string out, err;
};

/// Runs the program's main with `arguments` in a separate process, where calls on files below `watched` and on sockets
/// meet `fault`. Disk synchronisation is skipped there, the time of day is constant, and programs are searched in
/// `watched`/bin first.
/// requires: called inside a test. throws: std::runtime_error if no process can be started.
ToolUnderFault runUnderFault(const std::vector<std::string>& arguments, const std::filesystem::path& watched,
                             const CallFault& fault = {});

}  // namespace kiln::test
