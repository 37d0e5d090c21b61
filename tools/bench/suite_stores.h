// The stores of a suite. A store is used as it is. Other volumes are converted once, in the report's directory; the
// store is reused while it matches the volume.
#pragma once

#include <filesystem>
#include <string>

#include "base/progress.h"

namespace kiln {

struct SuiteStore {
  std::filesystem::path path;
  double convert_s = 0;  // 0 if the store existed
};

enum class SuiteLevels { kFinest, kAll };

/// `command` and `time` are for a new store's manifest. throws: as openSource and convert.
SuiteStore suiteStore(const std::string& volume, SuiteLevels levels, const std::filesystem::path& stores,
                      const std::string& command, const std::string& time, Progress& progress);

}  // namespace kiln
