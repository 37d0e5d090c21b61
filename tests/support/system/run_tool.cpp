#include "run_tool.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <stdexcept>

#include "tool_server.h"

namespace kiln::test {
namespace {

// A pipe from the child to the test; optionally a pseudo-terminal.
struct Pipe {
  explicit Pipe(unsigned short terminal_columns = 0) {
    if (terminal_columns > 0)
      openTerminal(terminal_columns);
    else if (::pipe2(ends, O_CLOEXEC) != 0)
      throw std::runtime_error("pipe2 failed");
  }
  ~Pipe() {
    closeWriter();
    ::close(ends[0]);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  void openTerminal(unsigned short columns) {
    ends[0] = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
    if (ends[0] < 0 || ::grantpt(ends[0]) != 0 || ::unlockpt(ends[0]) != 0)
      throw std::runtime_error("no terminal can be opened");
    const winsize size{24, columns, 0, 0};
    ends[1] = ::open(::ptsname(ends[0]), O_RDWR | O_NOCTTY | O_CLOEXEC);
    if (ends[1] < 0 || ::ioctl(ends[1], TIOCSWINSZ, &size) != 0) throw std::runtime_error("a terminal has no size");
  }
  void closeWriter() {
    if (ends[1] >= 0) ::close(ends[1]);
    ends[1] = -1;
  }
  int ends[2] = {-1, -1};
};

// A child whose addresses are limited from its start, or under mpirun, executes the program.
bool callsMain(const ToolOptions& options) {
  return toolServer() >= 0 && !options.fresh && options.address_bytes == ToolCall::kNoLimit && options.ranks == 0;
}

// An input without bytes.
int nullInput() {
  static const int null = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  return null;
}

// Executes `arguments`: the program's name and arguments, and a null pointer. Between fork and exec of a process with
// threads, only async-signal-safe calls are allowed.
[[noreturn]] void becomeTool(char* const* arguments, const Pipe& out, const Pipe& err, const ToolOptions& options) {
  const int null = ::open("/dev/null", O_RDONLY);
  if (null >= 0) ::dup2(null, STDIN_FILENO);
  ::dup2(out.ends[1], STDOUT_FILENO);
  ::dup2(err.ends[1], STDERR_FILENO);
  if (!options.directory.empty() && ::chdir(options.directory.c_str()) != 0) ::_exit(127);
  const auto limitTo = [](auto resource, std::uint64_t most) {
    if (most == ToolCall::kNoLimit) return;
    const rlimit limit{static_cast<rlim_t>(most), static_cast<rlim_t>(most)};
    ::setrlimit(resource, &limit);
  };
  limitTo(RLIMIT_FSIZE, options.file_bytes);
  limitTo(RLIMIT_AS, options.address_bytes);
  limitTo(RLIMIT_NOFILE, options.open_files);
  ::execvp(arguments[0], arguments);
  ::_exit(127);
}

// Appends all available bytes. Returns false at the end of the stream.
bool drain(int descriptor, std::string& into) {
  std::array<char, 4096> buffer;
  const ssize_t got = ::read(descriptor, buffer.data(), buffer.size());
  if (got > 0) into.append(buffer.data(), static_cast<std::size_t>(got));
  return got > 0 || (got < 0 && errno == EINTR);
}

// The tests' own machine: more ranks than cores, perhaps as root of a container, and no binding to cores.
std::vector<std::string> launcherOf(int ranks) {
  if (ranks == 0) return {};
  ::setenv("OMPI_ALLOW_RUN_AS_ROOT", "1", 1);
  ::setenv("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1", 1);
  return {"mpirun", "--oversubscribe", "--bind-to", "none", "-n", std::to_string(ranks)};
}

}  // namespace

bool canRunRanks() {
#ifdef KILN_TEST_RANKS
  return std::system("mpirun --version > /dev/null 2>&1") == 0;
#else
  return false;
#endif
}

std::vector<std::string> ToolResult::errorLines() const {
  std::vector<std::string> lines;
  std::istringstream in(err);
  for (std::string line; std::getline(in, line);) {
    if (line.find(" s left") == std::string::npos) lines.push_back(line);
  }
  return lines;
}

namespace {

// A child that executes the program, with the words of mpirun or env before it.
class ExecutedTool {
 public:
  ExecutedTool(const std::vector<std::string>& arguments, const Pipe& out, const Pipe& err,
               const ToolOptions& options) {
    std::vector<std::string> words;
    if (!options.environment.empty()) {
      words.emplace_back("/usr/bin/env");
      words.insert(words.end(), options.environment.begin(), options.environment.end());
    }
    for (const std::string& word : launcherOf(options.ranks)) words.push_back(word);
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> raw;
    for (std::string& word : words) raw.push_back(word.data());
    raw.push_back(nullptr);
    process_ = ::fork();
    if (process_ < 0) throw std::runtime_error("fork failed");
    if (process_ == 0) becomeTool(raw.data(), out, err, options);
  }
  pid_t process() const { return process_; }
  ToolEnd wait() const {
    ToolEnd end{};
    while (::wait4(process_, &end.status, 0, &end.usage) < 0 && errno == EINTR) {
    }
    return end;
  }

 private:
  pid_t process_;
};

// Reads both streams until the child has closed them, and sends the signals that `options` describes.
ToolResult readStreams(Pipe& out, Pipe& err, pid_t child, const ToolOptions& options) {
  out.closeWriter();
  err.closeWriter();
  ToolResult result;
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(options.seconds);
  std::array<pollfd, 2> streams = {pollfd{out.ends[0], POLLIN, 0}, pollfd{err.ends[0], POLLIN, 0}};
  while (streams[0].fd >= 0 || streams[1].fd >= 0) {
    ::poll(streams.data(), streams.size(), options.interrupt_when && !result.interrupted ? 1 : 50);
    if (streams[0].revents != 0 && !drain(out.ends[0], result.out)) streams[0].fd = -1;
    if (streams[1].revents != 0 && !drain(err.ends[0], result.err)) streams[1].fd = -1;
    const bool interrupt =
        (options.interrupt_when && options.interrupt_when()) || (options.interrupt_at && options.interrupt_at(result));
    if (interrupt && !result.interrupted) result.interrupted = ::kill(child, SIGINT) == 0;
    if (!result.timed_out && std::chrono::steady_clock::now() > deadline) {
      result.timed_out = true;
      ::kill(child, SIGKILL);
    }
  }
  return result;
}

}  // namespace

ToolResult runTool(const std::vector<std::string>& arguments, const ToolOptions& options) {
  std::vector<std::string> words = {KILN_TOOL};
  words.insert(words.end(), arguments.begin(), arguments.end());
  Pipe out, err(options.terminal_columns);
  const auto resultOf = [&](const auto& tool) {
    ToolResult result = readStreams(out, err, tool.process(), options);
    const ToolEnd end = tool.wait();
    result.peak_resident_bytes = static_cast<std::uint64_t>(end.usage.ru_maxrss) * 1024;
    result.exit_code = WIFEXITED(end.status) ? WEXITSTATUS(end.status) : -WTERMSIG(end.status);
    return result;
  };
  if (!callsMain(options)) {
    if (options.more_address_bytes != ToolCall::kNoLimit) throw std::runtime_error("the limit needs a server");
    return resultOf(ExecutedTool(words, out, err, options));
  }
  return resultOf(
      callTool(toolServer(), {words, options.environment, options.directory, nullInput(), out.ends[1], err.ends[1],
                              options.file_bytes, options.open_files, options.more_address_bytes}));
}

}  // namespace kiln::test
