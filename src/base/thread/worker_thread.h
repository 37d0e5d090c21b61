// A thread that runs one task at a time beside its owner.
#pragma once

#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

namespace kiln {

class WorkerThread {
 public:
  /// `name` is the thread's name in a trace. requires: a literal.
  explicit WorkerThread(const char* name);
  /// Waits for the task; its exception is lost.
  ~WorkerThread();
  WorkerThread(const WorkerThread&) = delete;
  WorkerThread& operator=(const WorkerThread&) = delete;

  /// Starts a task. requires: the previous task has been waited for.
  void begin(std::function<void()> work);
  /// Waits for the task. throws: the exception of the task.
  void wait();

 private:
  void run();

  std::mutex mutex_;  // guards the members below
  std::condition_variable changed_;
  std::function<void()> work_;  // empty if there is no task
  std::exception_ptr failure_;
  bool closing_ = false;
  std::thread thread_;
};

}  // namespace kiln
