// The published schema of a job.
#pragma once

#include <string>

namespace kiln {

/// JSON Schema (draft 2020-12) of a job. Jobs may have comments, which a schema cannot describe.
std::string jobSchemaText();

}  // namespace kiln
