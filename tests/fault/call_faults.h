// System calls that fail when a test says so. The test executable defines read, open, rename and the like, so that the
// calls of every library that it loads (libstdc++, libtiff, OpenEXR, libpng, zlib, OpenVDB, GDCM) come here first.
// Not reached are calls inside libc: stdio's writes to standard output and error, posix_spawn, the dynamic loader.
// fopen, fclose, opendir and readdir are replaced as a whole.
#pragma once

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
  kInterrupted,  // EINTR, of calls that a signal may interrupt
  kShort,        // half of the bytes, of reads and writes
  kEnd,          // no byte, of reads: another program has cut the file
  kNoSpace,      // ENOSPC, of calls that write
};

struct CallFault {
  CallFailure failure = CallFailure::kNone;
  /// Calls of that kind that succeed before the one that fails. The default never fails.
  std::uint64_t after_calls = std::numeric_limits<std::uint64_t>::max();
};

struct ToolUnderFault {
  /// The exit code of the program; minus the number of the signal that ended it.
  int exit_code = 0;
  /// The failed call and its file, "pread /tmp/a.nrrd"; empty where none failed.
  std::string failed_call;
  /// Calls that could have failed in the same way.
  std::uint64_t calls = 0;
  std::string out, err;
};

/// Runs the program's main with `arguments` in a process of its own, in which the calls on files below `watched` and on
/// sockets meet `fault`. Synchronisation with the disk is left out there, the time of day stands still,
/// and programs are looked for in `watched`/bin first.
/// requires: called inside a test. throws: std::runtime_error where no process can be started.
ToolUnderFault runUnderFault(const std::vector<std::string>& arguments, const std::filesystem::path& watched,
                             const CallFault& fault = {});

}  // namespace kiln::test
