// The share of a budget that a job's transfer functions take, beside what frameMemory counts.
#pragma once

#include "base/progress.h"
#include "frame/statistics.h"
#include "sequence/opened_job.h"

namespace kiln::test {

/// unit: bytes.
inline std::uint64_t functionBytesOf(RenderJob job) {
  job.speed.memory_bytes = std::uint64_t{1} << 30;
  Progress silent;
  RenderStatistics statistics;
  OpenedJob(job, silent).describeMemory(statistics);
  return statistics.functions_bytes;
}

}  // namespace kiln::test
