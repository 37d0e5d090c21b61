// The `transferFunction` of a job, which may also be a file of its own.
#pragma once

#include "job/json/job_json.h"
#include "scene/transfer/transfer_function.h"

namespace kiln {

/// {kiln, unit, colorSpace, points, gradientOpacity} or {kiln, unit, colorSpace, labels}. throws: Error kUsage naming
/// the point where values are not sorted or out of range.
TransferFunction transferFunctionFrom(const JobObject& object);

/// Returns the text of a transfer function file, from which `transferFunctionFrom` reads the same function bit for bit.
std::string transferFunctionText(const TransferFunction& function);

}  // namespace kiln
