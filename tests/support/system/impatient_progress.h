// Progress of a user who cancels after a number of polls.
#pragma once

#include <atomic>

#include "base/progress.h"

namespace kiln::test {

/// Cancels at the `polls` + 1st call. thread: any.
class ImpatientProgress : public Progress {
 public:
  explicit ImpatientProgress(int polls) : left_(polls) {}
  bool cancelled() const override { return left_-- <= 0; }

 private:
  mutable std::atomic<int> left_;
};

}  // namespace kiln::test
