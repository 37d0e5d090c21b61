#include "open_browser.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <thread>

#include "base/find_program.h"

extern char** environ;

namespace kiln::tool {

namespace {

// Writes a page that no other user can read at any time. Returns false on failure.
bool writePage(const std::filesystem::path& page, const std::string& address) {
  const std::string text =
      "<!doctype html><meta charset=\"utf-8\"><title>Kiln</title>"
      "<meta http-equiv=\"refresh\" content=\"0;url=" +
      address + "\">\n";
  const int file = ::open(page.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (file < 0) return false;
  const bool whole = ::write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  return ::close(file) == 0 && whole;
}

}  // namespace

OpenedBrowser::OpenedBrowser(const std::string& address) {
  const bool desktop = std::getenv("DISPLAY") != nullptr || std::getenv("WAYLAND_DISPLAY") != nullptr;
  const char* const folder = std::getenv("XDG_RUNTIME_DIR");
  if (!desktop || folder == nullptr || *folder != '/' || ::isatty(STDOUT_FILENO) == 0) return;
  const std::filesystem::path program = findProgram("xdg-open");
  if (program.empty()) return;
  page_ = std::filesystem::path(folder) / ("kiln-view-" + std::to_string(::getpid()) + ".html");
  ::unlink(page_.c_str());  // an earlier process may have had this number
  if (!writePage(page_, address)) return;
  std::string name = program.string(), argument = page_.string();
  char* const arguments[] = {name.data(), argument.data(), nullptr};
  posix_spawn_file_actions_t files;
  if (::posix_spawn_file_actions_init(&files) != 0) return;
  for (const int file : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    ::posix_spawn_file_actions_addopen(&files, file, "/dev/null", O_RDWR, 0);
  pid_t child = 0;
  const bool started = ::posix_spawn(&child, program.c_str(), &files, nullptr, arguments, environ) == 0;
  ::posix_spawn_file_actions_destroy(&files);
  // Other children of the program are waited for elsewhere, so SIGCHLD must not be ignored.
  if (started) std::thread([child] { ::waitpid(child, nullptr, 0); }).detach();
}

OpenedBrowser::~OpenedBrowser() {
  if (!page_.empty()) ::unlink(page_.c_str());
}

bool terminalIsGone() {
  static const bool kTerminal = ::isatty(STDOUT_FILENO) != 0;
  if (!kTerminal) return false;
  pollfd one{STDOUT_FILENO, 0, 0};
  return ::poll(&one, 1, 0) > 0 && (one.revents & (POLLHUP | POLLERR | POLLNVAL)) != 0;
}

}  // namespace kiln::tool
