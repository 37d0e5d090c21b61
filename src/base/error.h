// The one exception of Kiln: bad input, disk, budget and cancellation, with the place where it was found.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

namespace kiln {

enum class ErrorCode {
  kUsage,        // the command line or a job asks for something that makes no sense
  kNotFound,     // a file or directory is not there
  kExists,       // an output is there already and nobody said to replace it
  kFormat,       // a file is not what its format says (truncated header, wrong sizes, unknown type)
  kUnsupported,  // a legal file that Kiln does not read (vector data, an unknown encoding)
  kDamaged,      // a store file is not what its checksum says
  kReplaced,     // a store is another one now than when the command opened it
  kBudget,       // the memory the user named is too small for the work
  kIo,           // the operating system failed a read or a write
  kNoSpace,      // the disk or the quota is full
  kCancelled,    // the user interrupted
};

/// A failure the user can act on. `what()` is one line: "PATH: PLACE: what was found; what to do".
class Error : public std::runtime_error {
 public:
  /// `place` (a byte offset, a key, a line) may be empty; `path` too where no file is involved.
  Error(ErrorCode code, const std::filesystem::path& path, const std::string& place, const std::string& what);
  /// An error without a file.
  Error(ErrorCode code, const std::string& what);

  ErrorCode code() const { return code_; }
  const std::filesystem::path& path() const { return path_; }
  /// The process exit code that stands for this error: 2 for kUsage, 1 otherwise.
  int exitCode() const { return code_ == ErrorCode::kUsage ? 2 : 1; }

 private:
  ErrorCode code_;
  std::filesystem::path path_;
};

/// The error for a failed system call. shape: maps ENOSPC, EDQUOT and EFBIG to kNoSpace, ENOENT to kNotFound, EEXIST to
/// kExists and the rest to kIo; `doing` says what was being done ("writing 2.1 MB").
Error systemError(int error_number, const std::filesystem::path& path, const std::string& doing);

}  // namespace kiln
