// Commands as text, for a user to copy into a shell.
#pragma once

#include <string>
#include <string_view>

namespace kiln {

/// Returns the argument as a shell reads it: in quotation marks if it has other characters than those of plain names.
std::string shellText(std::string_view argument);

}  // namespace kiln
