#include "terminal_progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdio>

namespace kiln::tool {
namespace {

std::atomic<bool> interrupted = false;
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler writes it");

void onInterrupt(int signal) {
  interrupted = true;
  std::signal(signal, SIG_DFL);
}

// "1.25 G", "310 k", "12".
std::string scaled(double amount) {
  if (amount >= 1e9) return fmt::format("{:.2f} G", amount / 1e9);
  if (amount >= 1e6) return fmt::format("{:.1f} M", amount / 1e6);
  if (amount >= 1e4) return fmt::format("{:.0f} k", amount / 1e3);
  return fmt::format("{:.4g} ", amount);
}

}  // namespace

void installInterruptHandler() {
  std::signal(SIGINT, onInterrupt);
  std::signal(SIGTERM, onInterrupt);
}

TerminalProgress::TerminalProgress() : terminal_(isatty(STDERR_FILENO) != 0) {}

TerminalProgress::~TerminalProgress() { clear(); }

bool TerminalProgress::cancelled() const { return interrupted; }

void TerminalProgress::advance(const char* step, const char* unit, std::uint64_t done, std::uint64_t total) {
  using namespace std::chrono_literals;
  const auto now = Clock::now();
  if (step_ != step) {
    step_ = step;
    begin_ = last_ = now;
    done_before_ = done;  // a resumed conversion begins in the middle
    return;
  }
  if (silent_ || now - last_ < (terminal_ ? 200ms : 10s)) return;
  last_ = now;
  const double seconds = std::chrono::duration<double>(now - begin_).count();
  const double rate = static_cast<double>(done - done_before_) / seconds;
  const double left = rate > 0 ? static_cast<double>(total - done) / rate : 0;
  const std::string line = fmt::format("{}: {:.0f} % of {}{}, {}{}/s, {:.0f} s left", step,
                                       100.0 * static_cast<double>(done) / static_cast<double>(total),
                                       scaled(static_cast<double>(total)), unit, scaled(rate), unit, left);
  if (terminal_) {
    fmt::print(stderr, "\r\033[K{}", line);
    drawn_ = true;
  } else {
    fmt::print(stderr, "{}\n", line);
  }
  std::fflush(stderr);
}

void TerminalProgress::show(const std::string& line) {
  using namespace std::chrono_literals;
  const auto now = Clock::now();
  if (silent_ || (!terminal_ && now - shown_ < 10s)) return;
  shown_ = now;
  if (terminal_)
    fmt::print(stderr, "\r\033[K{}", line);
  else
    fmt::print(stderr, "{}\n", line);
  drawn_ = terminal_;
  std::fflush(stderr);
}

void TerminalProgress::note(const std::string& sentence) {
  clear();
  fmt::print(stderr, "{}{}\n", speaker_, sentence);
}

void TerminalProgress::speakAsRank(int rank) {
  silent_ = true;
  speaker_ = fmt::format("kiln: rank {}: ", rank);
}

void TerminalProgress::clear() {
  if (drawn_) fmt::print(stderr, "\r\033[K");
  drawn_ = false;
}

}  // namespace kiln::tool
