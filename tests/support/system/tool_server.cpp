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
#include <cstring>
#include <map>
#include <sstream>
#include <stdexcept>

// The program's main function, in tests that link the program.
__attribute__((weak)) int kilnToolMain(int argc, char** argv);

namespace kiln::test {
namespace {

constexpr std::size_t kMostRequestBytes = 128 << 10;  // below what a socket accepts
using Descriptors = std::array<int, 3>;               // standard output, standard error, the socket for the answers

// The socket for requests; -1 without a server.
int& serverSocket() {
  static int socket = -1;
  return socket;
}

// Variables of this process and, after them, those of the call.
std::vector<std::string> environmentOf(const ToolCall& call) {
  std::vector<std::string> out;
  for (char** variable = environ; *variable != nullptr; ++variable) out.emplace_back(*variable);
  out.insert(out.end(), call.environment.begin(), call.environment.end());
  return out;
}

// A request: numbers of arguments and variables, the directory, then all arguments and variables, each ended by NUL.
std::string requestOf(const ToolCall& call) {
  std::ostringstream out;
  const auto put = [&](const std::string& text) { out << text << '\0'; };
  const std::vector<std::string> environment = environmentOf(call);
  put(std::to_string(call.arguments.size()));
  put(std::to_string(environment.size()));
  put((call.directory.empty() ? std::filesystem::current_path() : call.directory).string());
  for (const std::string& argument : call.arguments) put(argument);
  for (const std::string& variable : environment) put(variable);
  return std::move(out).str();
}

ToolCall callOf(const std::string& request) {
  std::istringstream in(request);
  const auto next = [&] {
    std::string text;
    std::getline(in, text, '\0');
    return text;
  };
  ToolCall out{};
  out.arguments.resize(std::stoul(next()));
  out.environment.resize(std::stoul(next()));
  out.directory = next();
  for (std::string& argument : out.arguments) argument = next();
  for (std::string& variable : out.environment) variable = next();
  return out;
}

void sendRequest(int socket, const std::string& request, const Descriptors& descriptors) {
  iovec bytes{const_cast<char*>(request.data()), request.size()};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(Descriptors))> control{};
  msghdr message{};
  message.msg_iov = &bytes, message.msg_iovlen = 1;
  message.msg_control = control.data(), message.msg_controllen = control.size();
  cmsghdr* const header = CMSG_FIRSTHDR(&message);
  header->cmsg_level = SOL_SOCKET, header->cmsg_type = SCM_RIGHTS, header->cmsg_len = CMSG_LEN(sizeof(Descriptors));
  std::memcpy(CMSG_DATA(header), descriptors.data(), sizeof(Descriptors));
  if (request.size() > kMostRequestBytes || ::sendmsg(socket, &message, MSG_NOSIGNAL) < 0)
    throw std::runtime_error("the server of the program takes no request");
}

// Returns an empty text once the test's process has ended.
std::string receiveRequest(int socket, Descriptors& descriptors) {
  std::string request(kMostRequestBytes, '\0');
  iovec bytes{request.data(), request.size()};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(Descriptors))> control{};
  msghdr message{};
  message.msg_iov = &bytes, message.msg_iovlen = 1;
  message.msg_control = control.data(), message.msg_controllen = control.size();
  ssize_t got;
  do got = ::recvmsg(socket, &message, MSG_CMSG_CLOEXEC);
  while (got < 0 && errno == EINTR);
  const cmsghdr* const header = got > 0 ? CMSG_FIRSTHDR(&message) : nullptr;
  if (header == nullptr || header->cmsg_len != CMSG_LEN(sizeof(Descriptors))) return "";
  std::memcpy(descriptors.data(), CMSG_DATA(header), sizeof(Descriptors));
  request.resize(static_cast<std::size_t>(got));
  return request;
}

// Runs the program in this process, which has no other descriptor than `descriptors`.
[[noreturn]] void runMain(const ToolCall& call, const Descriptors& descriptors) {
  ::dup2(descriptors[0], STDOUT_FILENO);
  ::dup2(descriptors[1], STDERR_FILENO);
  for (const int descriptor : descriptors) ::close(descriptor);
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
    Descriptors descriptors{};
    const std::string request = receiveRequest(requests, descriptors);
    if (request.empty()) ::_exit(0);
    const pid_t child = ::fork();
    if (child == 0) {
      sigprocmask(SIG_SETMASK, &before, nullptr);
      for (const auto& [process, answer] : answers) ::close(answer);
      ::close(requests), ::close(ends);
      runMain(callOf(request), descriptors);
    }
    ::send(descriptors[2], &child, sizeof child, MSG_NOSIGNAL);
    ::close(descriptors[0]), ::close(descriptors[1]);
    if (child > 0)
      answers[child] = descriptors[2];
    else
      ::close(descriptors[2]);
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
    ::close(serverSocket());
    serverSocket() = -1;
    ::waitpid(process_, nullptr, 0);
  }

 private:
  pid_t process_ = -1;
};

[[maybe_unused]] const ::testing::Environment* const kRegistered = ::testing::AddGlobalTestEnvironment(new ToolServer);

}  // namespace

CalledTool::CalledTool(int socket) : socket_(socket), process_(-1) {
  if (::recv(socket_, &process_, sizeof process_, 0) != sizeof process_ || process_ < 0) {
    ::close(socket_);
    throw std::runtime_error("the server of the program starts no process");
  }
}

CalledTool::~CalledTool() { ::close(socket_); }

ToolEnd CalledTool::wait() const {
  ToolEnd end{};
  ssize_t got;
  do got = ::recv(socket_, &end, sizeof end, 0);
  while (got < 0 && errno == EINTR);
  if (got != sizeof end) throw std::runtime_error("the server of the program has ended");
  return end;
}

bool hasToolServer() { return serverSocket() >= 0; }

void loadForChildren() {
  // TBB loads its allocator at the first allocation.
  tbb::cache_aligned_allocator<char> allocator;
  allocator.deallocate(allocator.allocate(1), 1);
}

CalledTool callTool(const ToolCall& call) {
  std::array<int, 2> answers{};
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, answers.data()) != 0)
    throw std::runtime_error("socketpair failed");
  try {
    sendRequest(serverSocket(), requestOf(call), {call.out, call.err, answers[1]});
  } catch (...) {
    for (const int end : answers) ::close(end);
    throw;
  }
  ::close(answers[1]);
  return CalledTool(answers[0]);
}

}  // namespace kiln::test
