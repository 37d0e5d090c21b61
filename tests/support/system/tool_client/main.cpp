// Stands for the program in a script: calls the program's main function in a child of the test's server, and ends as
// the child does. Executes the viewer, which scripts end by signals, and every command if the server's socket is
// closed, as in a rank of mpirun.
#include <fcntl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>

#include "support/system/tool_call.h"

namespace {

// Returns -1 without a server.
int serverSocket() {
  const char* const text = std::getenv(kiln::test::kServerVariable);
  int type = 0;
  socklen_t bytes = sizeof type;
  if (text == nullptr || ::getsockopt(std::atoi(text), SOL_SOCKET, SO_TYPE, &type, &bytes) != 0) return -1;
  return type == SOCK_SEQPACKET ? std::atoi(text) : -1;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace kiln::test;
  const int server = serverSocket();
  if (server < 0 || (argc > 1 && std::strcmp(argv[1], "view") == 0)) {
    if (server >= 0) ::fcntl(server, F_SETFD, FD_CLOEXEC);
    ::execv(KILN_TOOL, argv);
    std::perror(KILN_TOOL);
    return 127;
  }
  try {
    ToolCall call{};
    call.arguments.assign(argv, argv + argc);
    call.arguments.front() = KILN_TOOL;
    call.in = STDIN_FILENO, call.out = STDOUT_FILENO, call.err = STDERR_FILENO;
    const int status = callTool(server, call).wait().status;
    if (WIFEXITED(status)) return WEXITSTATUS(status);
    ::signal(WTERMSIG(status), SIG_DFL);
    ::raise(WTERMSIG(status));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
  }
  return 127;
}
