// A pool of open files for threads to borrow. A stack has thousands of files and a process may hold about a thousand
// open. The pool keeps idle files and closes the least recently used first; a borrowed file belongs to one thread.
#pragma once

#include <algorithm>
#include <cstdint>
#include <exception>
#include <list>
#include <memory>
#include <mutex>

#include "base/process.h"

namespace kiln {

template <class T>
class HandlePool {
 public:
  /// Keeps `idle_limit` handles, at most a quarter of the process's limit of open files. The default covers the slices
  /// of one brick with its aprons.
  explicit HandlePool(std::size_t idle_limit = 160)
      : idle_limit_(static_cast<std::size_t>(std::min<std::uint64_t>(idle_limit, mostOpenFiles() / 4))) {}

  class Lease {
   public:
    Lease(HandlePool& pool, std::size_t key, std::unique_ptr<T> handle)
        : pool_(pool), key_(key), handle_(std::move(handle)) {}
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;
    // Drops the handle after an exception: its state is unknown.
    ~Lease() {
      if (std::uncaught_exceptions() == exceptions_) pool_.giveBack(key_, std::move(handle_));
    }
    T& operator*() const { return *handle_; }
    T* operator->() const { return handle_.get(); }

   private:
    HandlePool& pool_;
    std::size_t key_;
    std::unique_ptr<T> handle_;
    int exceptions_ = std::uncaught_exceptions();
  };

  /// Returns an idle handle of `key`, or a new handle by `open`, which returns std::unique_ptr<T>. thread: any.
  template <class Open>
  Lease take(std::size_t key, Open&& open) {
    {
      const std::scoped_lock lock(mutex_);
      for (auto it = idle_.begin(); it != idle_.end(); ++it) {
        if (it->first != key) continue;
        std::unique_ptr<T> handle = std::move(it->second);
        idle_.erase(it);
        return Lease(*this, key, std::move(handle));
      }
    }
    return Lease(*this, key, open());
  }

 private:
  void giveBack(std::size_t key, std::unique_ptr<T> handle) {
    std::unique_ptr<T> closing;  // destroyed after the lock is released
    const std::scoped_lock lock(mutex_);
    idle_.emplace_front(key, std::move(handle));
    if (idle_.size() <= idle_limit_) return;
    closing = std::move(idle_.back().second);
    idle_.pop_back();
  }

  std::size_t idle_limit_;
  std::mutex mutex_;
  std::list<std::pair<std::size_t, std::unique_ptr<T>>> idle_;  // most recently used first
};

}  // namespace kiln
