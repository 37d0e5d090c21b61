// A call of the program's main function in a child of a server (tool_server.h), as a message on the server's socket.
// Needs no library, so that a process that only calls starts within 2 ms.
#pragma once

#include <sys/resource.h>
#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

namespace kiln::test {

/// A call of the program's main function.
struct ToolCall {
  static constexpr std::uint64_t kNoLimit = std::numeric_limits<std::uint64_t>::max();

  std::vector<std::string> arguments;    // the program's name first
  std::vector<std::string> environment;  // variables besides the caller's; shape: NAME=VALUE
  std::filesystem::path directory;       // empty: the caller's
  int in, out, err;                      // descriptors of the standard streams
  /// Limits that the child sets before its main function: size of a file, number of open files, and addresses beyond
  /// those of its start. unit: bytes; files; bytes.
  std::uint64_t file_bytes = kNoLimit, open_files = kNoLimit, more_address_bytes = kNoLimit;
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

/// Starts a call by a message on `server`. threads: any. throws: std::runtime_error if the server is gone.
CalledTool callTool(int server, const ToolCall& call);

/// A received call, with descriptors of the receiver, and the socket for the answers: the process's number, its end.
struct ReceivedCall {
  ToolCall call;
  int answers;
};

/// Returns false at the end of the stream.
bool receiveCall(int server, ReceivedCall& out);

/// Variable of the environment with the descriptor of the server's socket, for programs that a test executes.
constexpr const char* kServerVariable = "KILN_TEST_SERVER";

}  // namespace kiln::test
