// An error of a temporary file or folder under the name that the user gave.
#pragma once

#include "base/error.h"

namespace kiln {

/// Returns the error with `to` for `from` as its path; an error of another path is returned unchanged.
Error renamed(const Error& error, const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace kiln
