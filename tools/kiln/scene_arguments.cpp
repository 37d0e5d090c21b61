#include "scene_arguments.h"

#include <fmt/format.h>

#include "base/error.h"
#include "base/file/path_status.h"
#include "job/option_kinds.h"
#include "scene/transfer/presets.h"
#include "source_arguments.h"

namespace kiln::tool {

TransferFunctionChoice transferFunctionNamed(const std::string& text, const char* option) {
  try {
    if (auto written = writtenChoice(text)) return *std::move(written);
  } catch (const Error& error) {
    throw Error(ErrorCode::kUsage, fmt::format("{}: {}", option, error.what()));
  }
  std::error_code ignored;
  if (std::filesystem::is_directory(fileOf(text), ignored))
    throw Error(ErrorCode::kUsage, fmt::format("{}: '{}' is a folder; name a file of a transfer function or one of {}",
                                               option, text, presetList()));
  if (isThere(fileOf(text))) {
    refuseVolumeFile(fileOf(text), "a transfer function");
    return std::filesystem::path(text);
  }
  throw Error(ErrorCode::kUsage,
              fmt::format("{}: '{}' is neither a file nor points VALUE:OPACITY[:COLOR],... nor one of {}{}", option,
                          text, presetList(), presetHint(text)));
}

Window parseWindow(const std::string& text, const char* option) {
  return *valueOfFlag<std::optional<Window>>(ValueWindow(), text, option);
}

}  // namespace kiln::tool
