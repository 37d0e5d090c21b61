// The options of a job with a flag on the command line, for programs that parse command lines.
#pragma once

#include <array>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace kiln {

struct RenderJob;

/// The groups of options in help and manual, in their order.
enum class OptionGroup {
  kOutput,
  kCamera,
  kTransferFunction,
  kLight,
  kShown,
  kAnnotations,
  kQuality,
  kCost,
  kFrames,
  kRanks,
  kForeign
};
inline constexpr std::array<std::string_view, 11> kOptionGroupNames = {
    "Output",  "Camera",           "Transfer function", "Light",         "What is shown", "Annotations",
    "Quality", "Memory and speed", "Many frames",       "Many machines", "Foreign files"};

struct JobFlag {
  /// kSeveral, kList: the flag is repeatable; kList: an argument may also be a list, "a,b".
  enum class Arguments { kNone, kOne, kSeveral, kList };
  std::string flag;  // "--fov", "-o,--output"
  OptionGroup group;
  Arguments arguments;
  std::string value_name;          // "DEGREES"
  std::string help;                // with the legal range and the default
  std::vector<std::string> words;  // if the value is one of a few
  bool may_be_empty = false;       // an empty text clears the text of the job
  /// Numbers: returns "expected …, found …" for a text that is no number, else an empty text. Empty for other kinds.
  std::function<std::string(const std::string& text)> refusal;
  /// Replaces the option in the job by `texts`. throws: Error kUsage naming the flag.
  std::function<void(const std::vector<std::string>& texts, RenderJob&)> apply;
};

/// All flags of a job, in the order of application.
const std::vector<JobFlag>& jobFlags();

}  // namespace kiln
