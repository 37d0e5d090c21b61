#include "scene_arguments.h"

#include <fmt/format.h>

#include "base/error.h"
#include "scene/presets.h"
#include "source_arguments.h"

namespace kiln::tool {

TransferFunctionChoice transferFunctionNamed(const std::string& text, const char* option) {
  if (isPreset(text)) return text;
  std::error_code ignored;
  if (std::filesystem::exists(fileOf(text), ignored)) return std::filesystem::path(text);
  throw Error(ErrorCode::kUsage, fmt::format("{}: '{}' is neither a file nor one of {}", option, text, presetList()));
}

Window parseWindow(const std::string& text, const char* option) {
  constexpr const char* kExpected = "CENTRE,WIDTH, the width above 0";
  const std::vector<double> values = parseNumbers(text, ',', option, kExpected);
  if (values.size() != 2 || !(values[1] > 0))
    throw Error(ErrorCode::kUsage, fmt::format("{}: expected {}, found '{}'", option, kExpected, text));
  return {values[0], values[1]};
}

}  // namespace kiln::tool
