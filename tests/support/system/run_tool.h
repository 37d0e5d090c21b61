// Runs the real program as a child process: what a user types, and what they get to see.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace kiln::test {

struct ToolResult;

struct ToolOptions {
  /// After this the child is killed and `timed_out` is set. unit: seconds.
  double seconds = 600;
  /// The largest file the child may write: a full disk for one process. unit: bytes.
  std::uint64_t file_bytes = std::numeric_limits<std::uint64_t>::max();
  /// The child's limits, as `ulimit -v` and `ulimit -n` set them. unit: bytes; files.
  std::uint64_t address_bytes = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t open_files = std::numeric_limits<std::uint64_t>::max();
  /// The child's working directory; this process's if empty.
  std::filesystem::path directory{};
  /// Under mpirun with so many ranks, on this machine; 0 without. requires: canRunRanks().
  int ranks = 0;
  /// Asked every millisecond; once it says true the child gets SIGINT.
  std::function<bool()> interrupt_when;
  /// Asked whenever the child has said something, with all that it has said; once it says true the child gets SIGINT.
  std::function<bool(const ToolResult&)> interrupt_at;
  /// The child's stderr is a terminal of so many columns; 0: it is none.
  unsigned short terminal_columns = 0;
};

struct ToolResult {
  /// What the child returned; minus the signal's number where one ended it.
  int exit_code = 0;
  bool timed_out = false;
  bool interrupted = false;  // SIGINT was sent while it ran
  std::string out, err;
  std::uint64_t peak_resident_bytes = 0;  // as the system counted it; under mpirun, of mpirun itself
  /// shape: the lines of `err`, without those a slow machine adds: progress, one every ten seconds.
  std::vector<std::string> errorLines() const;
};

/// Whether Kiln is built with MPI and mpirun is there.
bool canRunRanks();

/// Runs KILN_TOOL with `arguments` and waits for its end. throws: std::runtime_error where no child can be started.
ToolResult runTool(const std::vector<std::string>& arguments, const ToolOptions& options = {});

}  // namespace kiln::test
