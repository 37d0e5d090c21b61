// Runs the real program as a child process and captures its output.
// Method. Tests that link the program's main function call it in a child of a server (tool_server.h); all other
// children execute KILN_TOOL.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "tool_call.h"

namespace kiln::test {

struct ToolResult;

struct ToolOptions {
  /// Time limit, after which the child is killed and `timed_out` is set. unit: seconds.
  double seconds = 600;
  /// Largest file the child may write: simulates a full disk for a single process. unit: bytes.
  std::uint64_t file_bytes = ToolCall::kNoLimit;
  /// Limits of the child, as set by `ulimit -v` and `ulimit -n`. unit: bytes; files.
  std::uint64_t address_bytes = ToolCall::kNoLimit;
  std::uint64_t open_files = ToolCall::kNoLimit;
  /// Limit of the addresses that the child adds after the start of its main function. requires: a server. unit: bytes.
  std::uint64_t more_address_bytes = ToolCall::kNoLimit;
  /// Working directory of the child; empty keeps the current directory.
  std::filesystem::path directory{};
  /// Variables of the environment to set for the child. shape: NAME=VALUE.
  std::vector<std::string> environment{};
  /// Executes KILN_TOOL, as measuring memory needs: a forked child begins with the memory of the server.
  bool fresh = false;
  /// Number of ranks under mpirun, on this machine; 0 runs without mpirun. requires: canRunRanks().
  int ranks = 0;
  /// Called every millisecond; once it returns true the child gets SIGINT.
  std::function<bool()> interrupt_when{};
  /// Called with all output so far whenever the child has printed something; once it returns true the child gets
  /// SIGINT.
  std::function<bool(const ToolResult&)> interrupt_at{};
  /// Columns of the terminal that is the child's stderr; 0: no terminal.
  unsigned short terminal_columns = 0;
};

struct ToolResult {
  /// Exit code of the child; minus the signal's number if a signal ended the child.
  int exit_code = 0;
  bool timed_out = false;
  bool interrupted = false;  // SIGINT was sent while the child ran
  std::string out, err;
  std::uint64_t peak_resident_bytes = 0;  // as counted by the system; under mpirun, of mpirun itself
  /// shape: the lines of `err`, without progress lines, which a slow machine prints every ten seconds.
  std::vector<std::string> errorLines() const;
};

/// Returns true if Kiln is built with MPI and mpirun is installed.
bool canRunRanks();

/// Runs the program with `arguments` and waits for its end. throws: std::runtime_error if no child can be started.
ToolResult runTool(const std::vector<std::string>& arguments, const ToolOptions& options = {});

}  // namespace kiln::test
