// Expects errors by their code and a part of their text.
#pragma once

#include <functional>
#include <string>

#include "base/error.h"

namespace kiln::test {

/// Expects a text of a single line.
void expectOneLine(const Error& error);
/// Expects that `call` throws Error with `code` and a single line that contains `part`.
void expectError(const std::function<void()>& call, ErrorCode code, const std::string& part);

}  // namespace kiln::test
