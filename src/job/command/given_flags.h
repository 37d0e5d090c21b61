// The options that a command line or a call gives beside a job.
#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "job/job_flags.h"
#include "job/render_job.h"

namespace kiln {

/// Returns the long name of a flag: "--output" of "-o,--output".
std::string nameOfFlag(std::string_view flag);

class GivenFlags {
 public:
  /// requires: the flags are added in the order of jobFlags().
  void add(const JobFlag& flag, std::vector<std::string> texts) { given_.push_back({&flag, std::move(texts)}); }
  /// Returns true if the flag, by its long name, is given.
  bool has(std::string_view flag) const { return text(flag).has_value(); }
  bool hasAny(std::initializer_list<std::string_view> flags) const;
  std::optional<std::string> text(std::string_view flag) const;
  /// Returns the first given flag that is none of these.
  std::optional<std::string> otherThan(std::initializer_list<std::string_view> flags) const;
  /// Replaces the given options of the job. throws: Error kUsage naming the flag.
  void apply(RenderJob& job) const;

 private:
  struct Given {
    const JobFlag* flag;
    std::vector<std::string> texts;
  };
  std::vector<Given> given_;
};

/// Replaces the given options of a job, and checks the picture. throws: Error kUsage for flags that contradict the job
/// or one another.
void applyGiven(const GivenFlags& flags, RenderJob& job);

/// Volumes beside the job's first, and the transfer functions of their first few.
struct AddedVolumes {
  std::vector<std::filesystem::path> added, labels;
  std::vector<TransferFunctionChoice> functions;
};
/// Adds volumes to the job, those of labels last. Given options of a volume replace the options of the first volume.
/// throws: Error kUsage for more functions than volumes.
void addVolumes(const AddedVolumes& more, const GivenFlags& flags, RenderJob& job);

}  // namespace kiln
