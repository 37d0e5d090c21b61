// A picture for standard output: drawn into a file of a temporary folder, then copied.
#pragma once

#include <filesystem>

#include "job/render_job.h"

namespace kiln::tool {

/// Returns whether an output's name stands for standard output: "-", a PNG, or "-" with the ending of another picture.
bool isStandardOutputName(const std::filesystem::path& name);

class StandardOutput {
 public:
  StandardOutput() = default;
  /// Removes the folder.
  ~StandardOutput();
  StandardOutput(const StandardOutput&) = delete;
  StandardOutput& operator=(const StandardOutput&) = delete;

  /// If the job's output is standard output, names a temporary file instead, and prints all text of the command to
  /// standard error from then on. throws: Error kUsage on a terminal, kIo.
  void take(OutputOptions& output);
  bool taken() const { return !file_.empty(); }
  /// Copies the picture to standard output, if the job's output is. throws: Error kIo, kNoSpace.
  void copy() const;

 private:
  std::filesystem::path folder_, file_;
};

}  // namespace kiln::tool
