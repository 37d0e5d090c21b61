// Runs a suite: measures case by case.
#pragma once

#include <functional>

#include "bench/measurements.h"

namespace kiln {

struct BenchOptions {
  std::filesystem::path stores;  // folder for stores of volumes that must be converted
  std::string command, time;     // for the report and the stores' manifests
};

/// Draws the suite and returns every number. Bricks are in memory before anything is timed, and remaining load times
/// are subtracted. Methods take turns view by view, so that disturbances by other programs affect all methods alike.
/// Calls `on_run` after each case, size and projection.
/// throws: the exceptions of conversions and frames, Error kCancelled.
Measurements runSuite(const Suite& suite, const BenchOptions& options, Progress& progress,
                      const std::function<void(const Measurements&, const MeasuredRun&)>& on_run);

}  // namespace kiln
