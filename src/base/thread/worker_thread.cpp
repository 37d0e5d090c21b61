#include "base/thread/worker_thread.h"

#include <cassert>
#include <utility>

#include "base/thread/trace.h"

namespace kiln {

WorkerThread::WorkerThread(const char* name)
    : thread_([this, name] {
        Trace::nameThread(name);
        run();
      }) {}

WorkerThread::~WorkerThread() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void WorkerThread::begin(std::function<void()> work) {
  {
    const std::lock_guard lock(mutex_);
    assert(!work_ && !failure_);
    work_ = std::move(work);
  }
  changed_.notify_all();
}

void WorkerThread::wait() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return !work_; });
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
}

void WorkerThread::run() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return work_ || closing_; });
    if (!work_) return;
    lock.unlock();
    std::exception_ptr failure;
    try {
      work_();
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    work_ = nullptr;
    failure_ = failure;
    changed_.notify_all();
  }
}

}  // namespace kiln
