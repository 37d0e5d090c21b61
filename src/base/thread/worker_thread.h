// A thread that does one thing at a time while its owner goes on with another.
#pragma once

#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

namespace kiln {

class WorkerThread {
 public:
  /// `name` is what a trace calls it. requires: a literal.
  explicit WorkerThread(const char* name);
  /// Waits for what was begun; what it threw is lost.
  ~WorkerThread();
  WorkerThread(const WorkerThread&) = delete;
  WorkerThread& operator=(const WorkerThread&) = delete;

  /// requires: what was begun before has been waited for.
  void begin(std::function<void()> work);
  /// Until what was begun is done. throws: what that threw.
  void wait();

 private:
  void run();

  std::mutex mutex_;  // guards what follows
  std::condition_variable changed_;
  std::function<void()> work_;  // empty where there is nothing to do
  std::exception_ptr failure_;
  bool closing_ = false;
  std::thread thread_;
};

}  // namespace kiln
