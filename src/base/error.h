// The only exception type of Kiln, for bad input, disk failures, too small budgets and cancellation.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

namespace kiln {

enum class ErrorCode {
  kUsage,        // the command line or a job is invalid
  kNotFound,     // a file or directory does not exist
  kExists,       // an output exists and replacing was not requested
  kFormat,       // a file violates its format (truncated header, wrong sizes, unknown type)
  kUnsupported,  // a valid file that Kiln does not read (vector data, an unknown encoding)
  kDamaged,      // a store file does not match its checksum
  kReplaced,     // another store has the name of the store that the command opened
  kBudget,       // the memory budget is too small for the work
  kIo,           // the operating system failed a read or a write
  kNoSpace,      // the disk or the quota is full
  kCancelled,    // the user interrupted
};

/// A failure the user can act on. `what()` is one line: "PATH: PLACE: constraint (found X); remedy".
class Error : public std::runtime_error {
 public:
  /// `place` (a byte offset, a key, a line) may be empty, and `path` if no file is involved.
  Error(ErrorCode code, const std::filesystem::path& path, const std::string& place, const std::string& what);
  /// An error without a file.
  Error(ErrorCode code, const std::string& what);

  ErrorCode code() const { return code_; }
  const std::filesystem::path& path() const { return path_; }
  /// The process exit code of this error: 2 for kUsage, 1 otherwise.
  int exitCode() const { return code_ == ErrorCode::kUsage ? 2 : 1; }

 private:
  ErrorCode code_;
  std::filesystem::path path_;
};

/// Returns the error for a failed system call. ENOSPC, EDQUOT and EFBIG become kNoSpace, ENOENT kNotFound, EEXIST
/// kExists, any further number kIo. `doing` names the attempted action ("writing 2.1 MB").
Error systemError(int error_number, const std::filesystem::path& path, const std::string& doing);

}  // namespace kiln
