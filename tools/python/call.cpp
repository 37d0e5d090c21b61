#include "python/call.h"

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "base/error.h"
#include "base/text.h"

namespace kiln::python {
namespace {

constexpr auto kLookEvery = std::chrono::milliseconds(50);

// Owned by the module, which is never unloaded.
PyObject* error_type = nullptr;
PyObject* warning_type = nullptr;

// In the order of ErrorCode.
constexpr std::array<std::string_view, 11> kCodes = {"usage",       "not_found", "exists",   "format",
                                                     "unsupported", "damaged",   "replaced", "budget",
                                                     "io",          "no_space",  "cancelled"};

void raise(const Error& error) {
  const py::object instance = py::reinterpret_borrow<py::object>(error_type)(utf8Of(error.what()));
  instance.attr("code") = kCodes[static_cast<std::size_t>(error.code())];
  if (error.path().empty())
    instance.attr("path") = py::none();
  else
    instance.attr("path") = textOfPath(error.path());
  if (const auto* const caused = dynamic_cast<const CausedError*>(&error))
    PyException_SetCause(instance.ptr(), py::object(caused->cause()).release().ptr());
  PyErr_SetObject(error_type, instance.ptr());
}

class CallProgress final : public Progress {
 public:
  void advance(const char* step, const char*, std::uint64_t done, std::uint64_t total) override {
    const std::lock_guard lock(mutex_);
    latest_ = Latest{step, done, total};
  }
  void note(const std::string& sentence) override { keep(false, sentence); }
  void warn(const std::string& sentence) override { keep(true, sentence); }
  bool cancelled() const override { return cancelled_; }

  void cancel() { cancelled_ = true; }
  void end() {
    {
      const std::lock_guard lock(mutex_);
      ended_ = true;
    }
    changed_.notify_all();
  }
  // Returns true once the work has ended.
  bool wait() {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, kLookEvery, [&] { return ended_; });
  }

  // Calls `on_progress` with the news since the last call.
  void report(const py::object& on_progress) {
    std::optional<Latest> latest;
    {
      const std::lock_guard lock(mutex_);
      latest = std::exchange(latest_, std::nullopt);
    }
    if (latest && !on_progress.is_none()) on_progress(latest->step, latest->done, latest->total);
  }
  void passSentencesOn() {
    for (const auto& [warns, sentence] : sentences_) {
      if (!warns)
        py::module_::import("logging").attr("getLogger")("kiln").attr("info")("%s", utf8Of(sentence));
      else if (PyErr_WarnEx(warning_type, utf8Of(sentence).c_str(), 2) != 0)
        throw py::error_already_set();
    }
  }

 private:
  struct Latest {
    std::string step;
    std::uint64_t done, total;
  };
  void keep(bool warns, const std::string& sentence) {
    const std::lock_guard lock(mutex_);
    sentences_.emplace_back(warns, sentence);
  }

  std::atomic<bool> cancelled_ = false;
  std::mutex mutex_;  // guards the members below until the work has ended
  std::condition_variable changed_;
  bool ended_ = false;
  std::optional<Latest> latest_;
  std::vector<std::pair<bool, std::string>> sentences_;
};

// The calls under way. At Python's end a thread of Python that waits for the lock ends in the middle of its functions,
// so that all calls must have ended before.
class Calls {
 public:
  void add(CallProgress& call) {
    const std::lock_guard lock(mutex_);
    calls_.insert(&call);
    if (ending_) call.cancel();
  }
  void remove(CallProgress& call) {
    const std::lock_guard lock(mutex_);
    calls_.erase(&call);
    changed_.notify_all();
  }
  void end() {
    const py::gil_scoped_release unlocked;
    std::unique_lock lock(mutex_);
    ending_ = true;
    for (CallProgress* call : calls_) call->cancel();
    changed_.wait_for(lock, kLongestEnd, [&] { return calls_.empty(); });
  }

 private:
  static constexpr auto kLongestEnd = std::chrono::seconds(10);
  std::mutex mutex_;  // guards the members below
  std::condition_variable changed_;
  std::set<CallProgress*> calls_;
  bool ending_ = false;
};

Calls& calls() {
  static Calls* const out = new Calls();  // used until the process ends
  return *out;
}

class CallUnderWay {
 public:
  explicit CallUnderWay(CallProgress& progress) : progress_(progress) { calls().add(progress_); }
  ~CallUnderWay() { calls().remove(progress_); }
  CallUnderWay(const CallUnderWay&) = delete;
  CallUnderWay& operator=(const CallUnderWay&) = delete;

 private:
  CallProgress& progress_;
};

}  // namespace

CausedError::CausedError(const Error& error, const py::error_already_set& cause)
    : Error(error), cause_(new py::object(cause.value()), [](py::object* object) {
        const py::gil_scoped_acquire locked;
        delete object;
      }) {
  if (cause.trace()) PyException_SetTraceback(cause_->ptr(), cause.trace().ptr());
}

py::str textOfPath(const std::filesystem::path& path) {
  const std::string& bytes = path.native();
  PyObject* const text = PyUnicode_DecodeFSDefaultAndSize(bytes.data(), static_cast<Py_ssize_t>(bytes.size()));
  if (text == nullptr) throw py::error_already_set();
  return py::reinterpret_steal<py::str>(text);
}

void bindErrors(py::module_& module) {
  error_type = PyErr_NewExceptionWithDoc(
      "kiln.Error",
      "A failure that the caller can act on.\n\n"
      "code: 'usage', 'not_found', 'exists', 'format', 'unsupported', 'damaged', 'replaced', 'budget', 'io',\n"
      "'no_space' or 'cancelled'. path: the file or folder, or None.",
      nullptr, nullptr);
  warning_type =
      PyErr_NewExceptionWithDoc("kiln.Warning", "A result that differs from the request.", PyExc_UserWarning, nullptr);
  if (error_type == nullptr || warning_type == nullptr) throw py::error_already_set();
  module.attr("Error") = py::reinterpret_borrow<py::object>(error_type);
  module.attr("Warning") = py::reinterpret_borrow<py::object>(warning_type);
  py::module_::import("atexit").attr("register")(py::cpp_function([] { calls().end(); }));
  py::register_exception_translator([](std::exception_ptr failure) {
    try {
      if (failure) std::rethrow_exception(failure);
    } catch (const Error& error) {
      raise(error);
    }
  });
}

void runForCall(const py::object& on_progress, const std::function<void(Progress&)>& work) {
  CallProgress progress;
  const CallUnderWay under_way(progress);
  std::exception_ptr failure;
  std::thread worker([&] {
    try {
      work(progress);
    } catch (...) {
      failure = std::current_exception();
    }
    progress.end();
  });
  std::optional<py::error_already_set> raised;
  for (bool ended = false; !ended;) {
    {
      const py::gil_scoped_release unlocked;
      ended = progress.wait();
    }
    if (raised) continue;
    try {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      progress.report(on_progress);
    } catch (const py::error_already_set& error) {
      raised = error;
      progress.cancel();
    }
  }
  {
    const py::gil_scoped_release unlocked;
    worker.join();
  }
  if (raised) throw py::error_already_set(*raised);
  if (failure) {
    // Notes report the files that a failed call left. The call's error wins over a warning that a filter made an error.
    try {
      progress.passSentencesOn();
    } catch (const py::error_already_set&) {
    }
    std::rethrow_exception(failure);
  }
  progress.passSentencesOn();
}

}  // namespace kiln::python
