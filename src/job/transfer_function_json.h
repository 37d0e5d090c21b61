// The `transferFunction` of a job, and the same object as a file of its own.
#pragma once

#include "job/job_json.h"
#include "scene/transfer/transfer_function.h"

namespace kiln {

/// {unit, colorSpace, points, gradientOpacity}. throws: Error kUsage naming the point where values are not sorted or
/// out of range.
TransferFunction transferFunctionFrom(const JobObject& object);

}  // namespace kiln
