// Runs a suite: a list of measurements, case by case.
#pragma once

#include <functional>

#include "bench/measurements.h"

namespace kiln {

struct BenchOptions {
  std::filesystem::path stores;  // where volumes that are no stores are converted to
  std::string command, time;     // for the report and for the stores' manifests
};

/// Draws what the suite asks for and keeps every number. Bricks are in memory before anything is timed, what loading is
/// left is taken off, and the methods take turns view by view, so that whatever else the machine does meets them alike.
/// `on_run` is called after each case, size and projection. throws: what conversions and frames throw, Error
/// kCancelled.
Measurements runSuite(const Suite& suite, const BenchOptions& options, Progress& progress,
                      const std::function<void(const Measurements&, const MeasuredRun&)>& on_run);

}  // namespace kiln
