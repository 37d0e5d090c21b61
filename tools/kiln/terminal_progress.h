// Progress for people: one line with rate and ETA that is drawn over on a terminal, a plain line every ten seconds
// otherwise. SIGINT asks the work to stop; the work says when it has.
#pragma once

#include <chrono>
#include <string>

#include "base/progress.h"

namespace kiln::tool {

class TerminalProgress : public Progress {
 public:
  TerminalProgress();
  ~TerminalProgress() override;

  void advance(const char* step, const char* unit, std::uint64_t done, std::uint64_t total) override;
  void note(const std::string& sentence) override;
  bool cancelled() const override;
  /// A line of the caller's own, drawn over on a terminal; otherwise now and then.
  void show(const std::string& line);
  /// Shows no progress from here on, or plain lines also on a terminal.
  void silence() { silent_ = true; }
  /// As `silence`, and notes say whose they are.
  void speakAsRank(int rank);
  void plain() { terminal_ = false; }
  /// Ends a line that is being drawn over.
  void clear();

 private:
  using Clock = std::chrono::steady_clock;
  bool terminal_;
  bool silent_ = false;
  std::string speaker_ = "kiln: ";
  std::string step_;
  Clock::time_point begin_, last_;
  std::uint64_t done_before_ = 0;
  bool drawn_ = false;
  Clock::time_point shown_ = Clock::now();  // when `show` last did
};

/// Makes SIGINT and SIGTERM ask instead of kill; a second one kills.
void installInterruptHandler();

}  // namespace kiln::tool
