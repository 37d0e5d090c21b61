// The stores that a suite draws from: a store as it is, and of every other volume a conversion below the report's
// directory, made once and used again while it is the volume that the suite names.
#pragma once

#include <filesystem>
#include <string>

#include "base/progress.h"

namespace kiln {

struct SuiteStore {
  std::filesystem::path path;
  double convert_s = 0;  // 0 where it was there
};

enum class SuiteLevels { kFinest, kAll };

/// `command` and `time` are for a new store's manifest. throws: as openSource and convert.
SuiteStore suiteStore(const std::string& volume, SuiteLevels levels, const std::filesystem::path& stores,
                      const std::string& command, const std::string& time, Progress& progress);

}  // namespace kiln
