#include "scene_arguments.h"

#include <fmt/format.h>

#include "base/error.h"
#include "base/path_status.h"
#include "job/option_kinds.h"
#include "scene/transfer/presets.h"
#include "source_arguments.h"

namespace kiln::tool {

TransferFunctionChoice transferFunctionNamed(const std::string& text, const char* option) {
  if (isPreset(text)) return text;
  if (isThere(fileOf(text))) {
    refuseVolumeFile(fileOf(text), "a transfer function");
    return std::filesystem::path(text);
  }
  throw Error(ErrorCode::kUsage, fmt::format("{}: '{}' is neither a file nor one of {}", option, text, presetList()));
}

Window parseWindow(const std::string& text, const char* option) {
  return *valueOfFlag<std::optional<Window>>(ValueWindow(), text, option);
}

}  // namespace kiln::tool
