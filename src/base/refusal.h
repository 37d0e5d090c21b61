// Failures of the machine beneath a library's exception: no more memory, no more threads. No file is at fault.
#pragma once

#include <exception>

namespace kiln {

enum class Refusal {
  kNone,
  kMemory,   // an allocation failed
  kThreads,  // a thread could not be started
};

/// Returns what the system refused, kNone for any other failure. Exceptions of TBB, and those that OpenEXR's threads
/// hand on, have no type of their own: the message decides. thread: safe.
Refusal refusalOf(const std::exception& error) noexcept;

/// Rethrows the exception being handled if it is a refusal of the system. Called before an exception of a library
/// becomes the Error of a file. requires: an exception is being handled.
void rethrowRefusal();

}  // namespace kiln
