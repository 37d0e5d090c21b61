// Progress for people: on a terminal one line with rate and remaining time, redrawn in place; elsewhere a plain line
// every ten seconds. SIGINT requests a stop; the work polls `cancelled`.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "base/progress.h"

namespace kiln::tool {

class TerminalProgress : public Progress {
 public:
  TerminalProgress();
  ~TerminalProgress() override;

  void advance(const char* step, const char* unit, std::uint64_t done, std::uint64_t total) override;
  void note(const std::string& sentence) override;
  /// Prints the sentence, counts it, and passes it to the listener of warnings.
  void warn(const std::string& sentence) override;
  /// The number of warnings so far.
  std::uint64_t warnings() const { return warnings_; }
  /// Sets the function to call with each warning.
  void tellWarnings(std::function<void(const std::string&)> listener) { warning_listener_ = std::move(listener); }
  bool cancelled() const override;
  /// Shows the caller's line, redrawn in place on a terminal, otherwise now and then. `before_steps` is a shorter text
  /// to print before the lines of later steps.
  void show(const std::string& line, const std::string& before_steps);
  /// Progress of a step, for programs. The remaining time is absent before there is a rate.
  struct Numbers {
    std::string unit;
    std::uint64_t done, total;
    std::optional<double> seconds_left;
  };
  /// Sets a listener that gets the progress instead of the terminal, a few times a second. Each reported step is also
  /// reported at its end.
  void tell(std::function<void(const Numbers&)> listener) { listener_ = std::move(listener); }
  /// Shows no progress from here on, or plain lines also on a terminal.
  void silence() { silent_ = true; }
  /// As `silence`; notes begin with the number of the rank.
  void speakAsRank(int rank);
  void plain() { terminal_ = false; }
  /// Ends the line that is redrawn in place.
  void clear();

 private:
  using Clock = std::chrono::steady_clock;
  /// Returns true if a line is due, and counts the line as printed now.
  bool due(bool at_end);
  void print(const std::string& line);

  bool terminal_;
  bool silent_ = false;
  std::string speaker_ = "kiln: ";
  std::function<void(const Numbers&)> listener_;
  std::function<void(const std::string&)> warning_listener_;
  std::atomic<std::uint64_t> warnings_ = 0;
  std::string overall_;  // printed before the lines of steps
  std::string step_;
  Clock::time_point begin_, last_ = Clock::now();
  std::uint64_t done_before_ = 0;
  bool told_ = false;  // whether the step was reported
  bool drawn_ = false;
};

/// Makes SIGINT, SIGTERM and SIGHUP, which the end of a terminal sends, request a stop instead of ending the process. A
/// second SIGINT or SIGTERM ends the process; SIGHUP may come twice. A process that is to outlive its terminal (nohup)
/// ignores SIGHUP.
void installInterruptHandler();

}  // namespace kiln::tool
