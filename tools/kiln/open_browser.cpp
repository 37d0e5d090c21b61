#include "open_browser.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>

#include "find_program.h"
#include "terminal_progress.h"

extern char** environ;

namespace kiln::tool {

void openBrowser(const std::string& address) {
  const bool desktop = std::getenv("DISPLAY") != nullptr || std::getenv("WAYLAND_DISPLAY") != nullptr;
  if (!desktop || ::isatty(STDOUT_FILENO) == 0) return;
  const std::filesystem::path program = findProgram("xdg-open");
  if (program.empty()) return;
  std::string name = program.string(), argument = address;
  char* const arguments[] = {name.data(), argument.data(), nullptr};
  posix_spawn_file_actions_t files;
  if (::posix_spawn_file_actions_init(&files) != 0) return;
  for (const int file : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    ::posix_spawn_file_actions_addopen(&files, file, "/dev/null", O_RDWR, 0);
  // The system takes the exit code of the browser.
  std::signal(SIGCHLD, SIG_IGN);
  pid_t child = 0;
  ::posix_spawn(&child, program.c_str(), &files, nullptr, arguments, environ);
  ::posix_spawn_file_actions_destroy(&files);
}

void endWithTerminal() {
  struct sigaction now {};
  if (::sigaction(SIGHUP, nullptr, &now) == 0 && now.sa_handler == SIG_IGN) return;
  now = {};
  now.sa_handler = requestStop;
  ::sigaction(SIGHUP, &now, nullptr);
}

bool terminalIsGone() {
  static const bool kTerminal = ::isatty(STDOUT_FILENO) != 0;
  if (!kTerminal) return false;
  pollfd one{STDOUT_FILENO, 0, 0};
  return ::poll(&one, 1, 0) > 0 && (one.revents & (POLLHUP | POLLERR | POLLNVAL)) != 0;
}

}  // namespace kiln::tool
