// Runs the program's main function in child processes of a server. The server is forked before the first test: after a
// fork, the child of a process with threads may only call async-signal-safe functions. Cost: a run begins after some
// 10 ms, and after 90 ms where a child executes the program, whose loader binds the 60,000 symbols of OpenVDB.
#pragma once

#include <sys/resource.h>
#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace kiln::test {

/// A call of the program's main function. `out` and `err` are the descriptors of its standard streams.
struct ToolCall {
  std::vector<std::string> arguments;    // the program's name first
  std::vector<std::string> environment;  // variables besides the test's; shape: NAME=VALUE
  std::filesystem::path directory;       // empty: the test's
  int out, err;
};

struct ToolEnd {
  int status;  // as wait() returns it
  rusage usage;
};

/// A running call.
class CalledTool {
 public:
  explicit CalledTool(int socket);
  ~CalledTool();
  CalledTool(const CalledTool&) = delete;
  CalledTool& operator=(const CalledTool&) = delete;
  pid_t process() const { return process_; }
  ToolEnd wait() const;

 private:
  int socket_;
  pid_t process_;
};

/// Returns true in tests that link the program's main function and run under GoogleTest.
bool hasToolServer();

/// Loads what each child would load at its first use. requires: called before a server is forked.
void loadForChildren();

/// Starts a call. threads: any. requires: hasToolServer(). throws: std::runtime_error if the server is gone.
CalledTool callTool(const ToolCall& call);

}  // namespace kiln::test
