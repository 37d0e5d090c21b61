#include "tool_server.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <tbb/cache_aligned_allocator.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <string>
#include <vector>

// The program's main function, in tests that link the program.
__attribute__((weak)) int kilnToolMain(int argc, char** argv);

namespace kiln::test {
namespace {

// The socket for requests; -1 without a server.
int& serverSocket() {
  static int socket = -1;
  return socket;
}

// Returns the limit of all addresses of this process that leaves `more_bytes` beyond its present addresses.
std::uint64_t addressLimit(std::uint64_t more_bytes) {
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE)) + more_bytes;
}

void limitTo(__rlimit_resource resource, std::uint64_t most) {
  const rlimit limit{static_cast<rlim_t>(most), static_cast<rlim_t>(most)};
  ::setrlimit(resource, &limit);
}

// Runs the program in this process, which has no other descriptor than those of `call`.
[[noreturn]] void runMain(const ToolCall& call) {
  const std::array<int, 3> streams = {call.in, call.out, call.err};
  for (int i = 0; i < 3; ++i) ::dup2(streams[static_cast<std::size_t>(i)], i);
  for (const int stream : streams) ::close(stream);
  if (::chdir(call.directory.c_str()) != 0) ::_exit(127);
  ::clearenv();
  for (const std::string& variable : call.environment) {
    const std::size_t equals = variable.find('=');
    ::setenv(variable.substr(0, equals).c_str(), variable.substr(equals + 1).c_str(), 1);
  }
  std::vector<std::string> words = call.arguments;
  std::vector<char*> raw;
  for (std::string& word : words) raw.push_back(word.data());
  raw.push_back(nullptr);
  if (call.file_bytes != ToolCall::kNoLimit) limitTo(RLIMIT_FSIZE, call.file_bytes);
  if (call.more_address_bytes != ToolCall::kNoLimit) limitTo(RLIMIT_AS, addressLimit(call.more_address_bytes));
  if (call.open_files != ToolCall::kNoLimit) limitTo(RLIMIT_NOFILE, call.open_files);
  const int exit_code = kilnToolMain(static_cast<int>(words.size()), raw.data());
  std::fflush(nullptr);
  ::_exit(exit_code);
}

// Answers each request with the process's number, and after its end with its status.
[[noreturn]] void serve(int requests) {
  const int null = ::open("/dev/null", O_RDWR);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::dup2(null, stream);
  if (null > STDERR_FILENO) ::close(null);
  sigset_t child_ended, before;
  sigemptyset(&child_ended);
  sigaddset(&child_ended, SIGCHLD);
  sigprocmask(SIG_BLOCK, &child_ended, &before);
  const int ends = ::signalfd(-1, &child_ended, SFD_CLOEXEC | SFD_NONBLOCK);
  std::map<pid_t, int> answers;
  for (;;) {
    std::array<pollfd, 2> events = {pollfd{requests, POLLIN, 0}, pollfd{ends, POLLIN, 0}};
    if (::poll(events.data(), events.size(), -1) < 0 && errno != EINTR) ::_exit(1);
    if (events[1].revents != 0) {
      signalfd_siginfo signal{};
      while (::read(ends, &signal, sizeof signal) > 0) {
      }
      ToolEnd end{};
      for (pid_t ended; (ended = ::wait4(-1, &end.status, WNOHANG, &end.usage)) > 0;) {
        const auto answer = answers.find(ended);
        if (answer == answers.end()) continue;
        ::send(answer->second, &end, sizeof end, MSG_NOSIGNAL);
        ::close(answer->second);
        answers.erase(answer);
      }
    }
    if (events[0].revents == 0) continue;
    ReceivedCall received{};
    if (!receiveCall(requests, received)) ::_exit(0);
    const pid_t child = ::fork();
    if (child == 0) {
      sigprocmask(SIG_SETMASK, &before, nullptr);
      for (const auto& [process, answer] : answers) ::close(answer);
      ::close(requests), ::close(ends);
      ::close(received.answers);
      runMain(received.call);
    }
    ::send(received.answers, &child, sizeof child, MSG_NOSIGNAL);
    for (const int stream : {received.call.in, received.call.out, received.call.err}) ::close(stream);
    if (child > 0)
      answers[child] = received.answers;
    else
      ::close(received.answers);
  }
}

// Forks the server before the first test, when all static objects exist. Threads that libraries have started by then
// are idle (log4cplus, behind OpenVDB), and a child needs none.
class ToolServer : public ::testing::Environment {
 public:
  void SetUp() override {
    std::array<int, 2> sockets{};
    if (kilnToolMain == nullptr || serverSocket() >= 0) return;
    if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, sockets.data()) != 0) return;
    loadForChildren();
    std::fflush(nullptr);  // the server's children would write buffered text again
    process_ = ::fork();
    if (process_ < 0) {  // children execute the program
      ::close(sockets[0]), ::close(sockets[1]);
      return;
    }
    if (process_ == 0) {
      ::close(sockets[0]);
      serve(sockets[1]);
    }
    ::close(sockets[1]);
    serverSocket() = sockets[0];
  }
  void TearDown() override {
    if (serverSocket() < 0) return;
    ::shutdown(serverSocket(), SHUT_RDWR);  // a program that a script left behind may have the socket, too
    ::close(serverSocket());
    serverSocket() = -1;
    ::waitpid(process_, nullptr, 0);
  }

 private:
  pid_t process_ = -1;
};

[[maybe_unused]] const ::testing::Environment* const kRegistered = ::testing::AddGlobalTestEnvironment(new ToolServer);

}  // namespace

int toolServer() { return serverSocket(); }

void loadForChildren() {
  // TBB loads its allocator at the first allocation.
  tbb::cache_aligned_allocator<char> allocator;
  allocator.deallocate(allocator.allocate(1), 1);
}

}  // namespace kiln::test
