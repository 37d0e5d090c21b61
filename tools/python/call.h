// Work of the library on behalf of a call from Python.
//
// Method. The work has a thread of its own. The calling thread waits without the interpreter's lock, and looks for
// signals and progress 20 times a second, because no other thread may run Python's handlers. A handler that raises
// cancels the work. Sentences for the user become warnings and log records after the work.
#pragma once

#include <pybind11/pybind11.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "base/error.h"
#include "base/progress.h"

namespace kiln::python {

namespace py = pybind11;

/// An error that an exception of Python's caused; the exception becomes the error's `__cause__`.
class CausedError : public Error {
 public:
  /// requires: the lock is held.
  CausedError(const Error& error, const py::error_already_set& cause);
  const py::object& cause() const { return *cause_; }

 private:
  std::shared_ptr<py::object> cause_;  // released with the lock held, by any thread
};

/// Returns a path as os.fsdecode does. requires: the lock is held.
py::str textOfPath(const std::filesystem::path& path);

/// Registers kiln.Error, with `code` and `path`, and kiln.Warning.
void bindErrors(py::module_& module);

/// Runs `work` and waits for its end. `on_progress`: None, or called with (step, done, total). requires: the lock is
/// held. throws: exceptions of `work` and of `on_progress`; KeyboardInterrupt.
void runForCall(const py::object& on_progress, const std::function<void(Progress&)>& work);

/// As runForCall, and returns the result.
template <class Work>
auto resultForCall(const py::object& on_progress, const Work& work) {
  std::optional<decltype(work(std::declval<Progress&>()))> out;
  runForCall(on_progress, [&](Progress& progress) { out.emplace(work(progress)); });
  return std::move(*out);
}

/// Deletes an object without the interpreter's lock: its threads may wait for the lock.
struct DeleteUnlocked {
  template <class T>
  void operator()(T* object) const {
    const py::gil_scoped_release unlocked;
    delete object;
  }
};
template <class T>
using UnlockedPointer = std::unique_ptr<T, DeleteUnlocked>;

}  // namespace kiln::python
