#include "terminal_progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <csignal>
#include <limits>

#include "base/duration_text.h"
#include "base/elapsed.h"
#include "say.h"

namespace kiln::tool {
namespace {

std::atomic<bool> interrupted = false;
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler writes it");

// "1.25 G", "310 k", "12".
std::string scaled(double amount) {
  if (amount >= 1e9) return fmt::format("{:.2f} G", amount / 1e9);
  if (amount >= 1e6) return fmt::format("{:.1f} M", amount / 1e6);
  if (amount >= 1e4) return fmt::format("{:.0f} k", amount / 1e3);
  return fmt::format("{:.4g} ", amount);
}

std::size_t columnsOfTerminal() {
  winsize size{};
  const bool known = ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1;
  return known ? size.ws_col : std::numeric_limits<std::size_t>::max();
}

void requestStop(int signal) {
  interrupted = true;
  // The end of a terminal may be signalled by the system and by a shell.
  if (signal != SIGHUP) std::signal(signal, SIG_DFL);
}

}  // namespace

void installInterruptHandler() {
  // Without SA_RESTART, a signal ends the wait for the reader of a pipe; the library repeats all other calls.
  struct sigaction action {};
  action.sa_handler = requestStop;
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);
  // A closing terminal interrupts, too, unless the program is to outlive it (nohup).
  struct sigaction hangup {};
  if (::sigaction(SIGHUP, nullptr, &hangup) == 0 && hangup.sa_handler != SIG_IGN) ::sigaction(SIGHUP, &action, nullptr);
}

TerminalProgress::TerminalProgress() : terminal_(isatty(STDERR_FILENO) != 0) {}

TerminalProgress::~TerminalProgress() { clear(); }

bool TerminalProgress::cancelled() const { return interrupted; }

// A resumed conversion begins in the middle: the rate counts this run's work.
void TerminalProgress::advance(const char* step, const char* unit, std::uint64_t done, std::uint64_t total) {
  if (step_ != step) {
    step_ = step;
    begin_ = Clock::now();
    done_before_ = done;
    told_ = false;
    if (listener_) last_ = begin_;  // shorter work shows no progress
    return;
  }
  if (!due(done == total)) return;
  told_ = true;
  const double seconds = secondsSince(begin_);
  const double rate = static_cast<double>(done - done_before_) / seconds;
  std::optional<double> left;
  if (rate > 0) left = static_cast<double>(total - done) / rate;
  if (listener_) {
    listener_({unit, done, total, left});
    return;
  }
  std::string line = fmt::format("{}: {:.0f} % of {}{}", step,
                                 std::floor(100.0 * static_cast<double>(done) / static_cast<double>(total)),
                                 scaled(static_cast<double>(total)), unit);
  if (left)
    line += fmt::format(", {}{}/s, {} left", rate < 100 ? fmt::format("{:.1f} ", rate) : scaled(rate), unit,
                        roughDurationText(*left));
  print(overall_.empty() ? line : overall_ + "; " + line);
}

bool TerminalProgress::due(bool at_end) {
  using namespace std::chrono_literals;
  const auto now = Clock::now();
  if (listener_ ? now - last_ < 250ms && !(at_end && told_) : silent_ || now - last_ < (terminal_ ? 200ms : 10s))
    return false;
  last_ = now;
  return true;
}

void TerminalProgress::show(const std::string& line, const std::string& before_steps) {
  overall_ = before_steps;
  if (listener_ || line.empty() || !(terminal_ ? !silent_ : due(false))) return;
  print(line);
}

// A redrawn line must fit into one row of the terminal.
void TerminalProgress::print(const std::string& line) {
  if (terminal_)
    drawLine(line, columnsOfTerminal() - 1);
  else
    complain("{}\n", line);
  drawn_ = terminal_;
}

void TerminalProgress::note(const std::string& sentence) {
  clear();
  complain("{}{}\n", speaker_, sentence);
}

void TerminalProgress::warn(const std::string& sentence) {
  ++warnings_;
  note("warning: " + sentence);
  if (warning_listener_) warning_listener_(sentence);
}

void TerminalProgress::speakAsRank(int rank) {
  silent_ = true;
  speaker_ = fmt::format("kiln: rank {}: ", rank);
}

void TerminalProgress::clear() {
  if (drawn_) clearLine();
  drawn_ = false;
}

}  // namespace kiln::tool
