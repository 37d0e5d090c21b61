// The input is a socket, not a pipe: only a socket has a flag (MSG_NOSIGNAL) for writes to an ended program without a
// signal.
#include "base/process.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <thread>
#include <utility>

#include "base/error.h"
#include "base/work_count.h"

extern char** environ;

namespace kiln {
namespace {

constexpr int kWait_ms = 100;  // between two calls of a handler that waits

}  // namespace

std::string hostName() {
  char name[256] = {};
  return ::gethostname(name, sizeof name - 1) == 0 && name[0] != 0 ? name : "an unknown host";
}

std::uint64_t mostOpenFiles() {
  rlimit limit;
  return ::getrlimit(RLIMIT_NOFILE, &limit) == 0 ? limit.rlim_cur : RLIM_INFINITY;
}

ChildProcess::ChildProcess(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                           bool answers)
    : program_(program) {
  int ends[2] = {-1, -1};
  error_output_ = ::memfd_create("error output", MFD_CLOEXEC);
  if (error_output_ < 0 || ::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) {
    const int error = errno;
    if (error_output_ >= 0) ::close(error_output_);
    throw systemError(error, program, "starting the program");
  }
  std::string name = program.string();
  std::vector<std::string> copies = arguments;
  std::vector<char*> raw = {name.data()};
  for (std::string& argument : copies) raw.push_back(argument.data());
  raw.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_adddup2(&actions, ends[1], STDIN_FILENO);
  if (answers)
    ::posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  else
    ::posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  ::posix_spawn_file_actions_adddup2(&actions, error_output_, STDERR_FILENO);
  pid_t process = -1;
  const int error = ::posix_spawn(&process, name.c_str(), &actions, nullptr, raw.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  ::close(ends[1]);
  if (error != 0) {
    ::close(ends[0]);
    ::close(error_output_);
    throw systemError(error, program, "starting the program");
  }
  socket_ = ends[0];
  process_ = process;
}

ChildProcess::~ChildProcess() {
  closeSocket();
  if (process_ >= 0) {
    ::kill(process_, SIGKILL);
    while (::waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
    }
  }
  ::close(error_output_);
}

void ChildProcess::closeSocket() {
  if (socket_ >= 0) ::close(std::exchange(socket_, -1));
}

bool ChildProcess::hasEnded(std::string& how) {
  if (process_ < 0) return true;
  int status = 0;
  const pid_t ended = ::waitpid(process_, &status, WNOHANG);
  if (ended == 0) return false;
  process_ = -1;
  if (ended < 0)
    how = "cannot be waited for";
  else if (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU)
    how = "took more processor time than its limit";
  else if (!WIFEXITED(status))
    how = "was ended by signal " + std::to_string(WTERMSIG(status));
  else
    how = WEXITSTATUS(status) == 0 ? "" : "failed with exit code " + std::to_string(WEXITSTATUS(status));
  return true;
}

std::string ChildProcess::awaitEnd(const std::function<void()>& waiting) {
  using namespace std::chrono_literals;
  std::string how;
  while (!hasEnded(how)) {
    countWork();
    waiting();
    std::this_thread::sleep_for(20ms);
  }
  return how;
}

std::string ChildProcess::lastError() const {
  std::array<char, 2000> buffer;
  const off_t size = ::lseek(error_output_, 0, SEEK_END);
  const off_t from = size > static_cast<off_t>(buffer.size()) ? size - static_cast<off_t>(buffer.size()) : 0;
  const ssize_t got = ::pread(error_output_, buffer.data(), buffer.size(), from);
  std::string line(buffer.data(), got > 0 ? static_cast<std::size_t>(got) : 0);
  while (!line.empty() && (line.back() == '\n' || line.back() == '\r')) line.pop_back();
  line.erase(0, line.find_last_of('\n') + 1);
  return line;
}

void ChildProcess::fail(const std::string& what) const {
  const std::string last = lastError();
  throw Error(ErrorCode::kIo, program_, "", what + (last.empty() ? "" : ": " + last));
}

std::optional<std::string> outputOf(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                                    std::size_t most_bytes, const std::function<void()>& waiting) {
  ChildProcess child(program, arguments, true);
  ::shutdown(child.socket(), SHUT_WR);  // ends the program's input
  std::string out;
  std::array<char, 4096> buffer;
  while (true) {
    pollfd answer{child.socket(), POLLIN, 0};
    if (::poll(&answer, 1, kWait_ms) <= 0) {
      countWork();
      waiting();
      continue;
    }
    const ssize_t got = ::recv(child.socket(), buffer.data(), buffer.size(), MSG_DONTWAIT);
    if (got < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (got <= 0) break;  // the program has closed its output
    out.append(buffer.data(), static_cast<std::size_t>(got));
    if (out.size() > most_bytes) return std::nullopt;
  }
  if (!child.awaitEnd(waiting).empty() || !child.lastError().empty()) return std::nullopt;
  return out;
}

void FedProcess::write(std::span<const std::byte> data, const WaitHandler& waiting) {
  while (!data.empty()) {
    pollfd room{child_.socket(), POLLOUT, 0};
    if (::poll(&room, 1, kWait_ms) <= 0) {
      countWork();
      waiting();
      continue;
    }
    const ssize_t put = ::send(child_.socket(), data.data(), data.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (put < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (put < 0) child_.fail("takes no more input");
    data = data.subspan(static_cast<std::size_t>(put));
  }
}

void FedProcess::finish(const WaitHandler& waiting) {
  child_.closeSocket();
  if (const std::string how = child_.awaitEnd(waiting); !how.empty()) child_.fail(how);
}

}  // namespace kiln
