// Progress for people: one line with rate and ETA that is drawn over on a terminal, a plain line every ten seconds
// otherwise. SIGINT asks the work to stop; the work says when it has.
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
  /// Notes the sentence, counts it, and hands it to the listener of warnings.
  void warn(const std::string& sentence) override;
  /// The number of warnings so far.
  std::uint64_t warnings() const { return warnings_; }
  /// Called with each warning.
  void tellWarnings(std::function<void(const std::string&)> listener) { warning_listener_ = std::move(listener); }
  bool cancelled() const override;
  /// A line of the caller's own, drawn over on a terminal; otherwise now and then. `before_steps`, which is shorter, is
  /// said before what steps say from here on.
  void show(const std::string& line, const std::string& before_steps);
  /// A step's numbers, for machines; before there is a rate, nobody knows what is left.
  struct Numbers {
    std::string unit;
    std::uint64_t done, total;
    std::optional<double> seconds_left;
  };
  /// Told how far a step is instead of people, a few times a second, and of the end of one that it was told of.
  void tell(std::function<void(const Numbers&)> listener) { listener_ = std::move(listener); }
  /// Shows no progress from here on, or plain lines also on a terminal.
  void silence() { silent_ = true; }
  /// As `silence`; notes begin with the number of the rank.
  void speakAsRank(int rank);
  void plain() { terminal_ = false; }
  /// Ends a line that is being drawn over.
  void clear();

 private:
  using Clock = std::chrono::steady_clock;
  /// Returns whether it is time for another line, and then counts the line as printed now.
  bool due(bool at_end);
  void print(const std::string& line);

  bool terminal_;
  bool silent_ = false;
  std::string speaker_ = "kiln: ";
  std::function<void(const Numbers&)> listener_;
  std::function<void(const std::string&)> warning_listener_;
  std::atomic<std::uint64_t> warnings_ = 0;
  std::string overall_;  // before what steps say
  std::string step_;
  Clock::time_point begin_, last_ = Clock::now();
  std::uint64_t done_before_ = 0;
  bool told_ = false;  // whether the step was reported
  bool drawn_ = false;
};

/// Makes SIGINT and SIGTERM ask instead of kill; a second one kills.
void installInterruptHandler();

}  // namespace kiln::tool
