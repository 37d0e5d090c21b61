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

extern char** environ;

namespace kiln {

std::string hostName() {
  char name[256] = {};
  return ::gethostname(name, sizeof name - 1) == 0 && name[0] != 0 ? name : "an unknown host";
}

std::uint64_t mostOpenFiles() {
  rlimit limit;
  return ::getrlimit(RLIMIT_NOFILE, &limit) == 0 ? limit.rlim_cur : RLIM_INFINITY;
}

FedProcess::FedProcess(const std::filesystem::path& program, const std::vector<std::string>& arguments)
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
  input_ = ends[0];
  process_ = process;
}

FedProcess::~FedProcess() {
  closeInput();
  if (process_ >= 0) {
    ::kill(process_, SIGKILL);
    while (::waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
    }
  }
  ::close(error_output_);
}

void FedProcess::closeInput() {
  if (input_ >= 0) ::close(std::exchange(input_, -1));
}

void FedProcess::write(std::span<const std::byte> data, const WaitHandler& waiting) {
  constexpr int kWait_ms = 100;
  while (!data.empty()) {
    pollfd room{input_, POLLOUT, 0};
    if (::poll(&room, 1, kWait_ms) <= 0) {
      waiting();
      continue;
    }
    const ssize_t put = ::send(input_, data.data(), data.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (put < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (put < 0) fail("takes no more input");
    data = data.subspan(static_cast<std::size_t>(put));
  }
}

void FedProcess::finish(const WaitHandler& waiting) {
  using namespace std::chrono_literals;
  closeInput();
  int status = 0;
  pid_t ended = 0;
  while ((ended = ::waitpid(process_, &status, WNOHANG)) == 0) {
    waiting();
    std::this_thread::sleep_for(20ms);
  }
  process_ = -1;
  if (ended < 0) fail("cannot be waited for");
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return;
  fail(WIFEXITED(status) ? "failed with exit code " + std::to_string(WEXITSTATUS(status))
                         : "was ended by signal " + std::to_string(WTERMSIG(status)));
}

void FedProcess::fail(const std::string& what) const {
  // Last line of standard error.
  std::array<char, 2000> buffer;
  const off_t size = ::lseek(error_output_, 0, SEEK_END);
  const off_t from = size > static_cast<off_t>(buffer.size()) ? size - static_cast<off_t>(buffer.size()) : 0;
  const ssize_t got = ::pread(error_output_, buffer.data(), buffer.size(), from);
  std::string last_line(buffer.data(), got > 0 ? static_cast<std::size_t>(got) : 0);
  while (!last_line.empty() && (last_line.back() == '\n' || last_line.back() == '\r')) last_line.pop_back();
  last_line.erase(0, last_line.find_last_of('\n') + 1);
  throw Error(ErrorCode::kIo, program_, "", what + (last_line.empty() ? "" : ": " + last_line));
}

}  // namespace kiln
