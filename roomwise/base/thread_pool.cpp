#include "roomwise/base/thread_pool.h"

#include <algorithm>
#include <system_error>

namespace roomwise {

ThreadPool::ThreadPool(std::size_t threads) {
  const std::size_t asked = std::max<std::size_t>(1, threads);
  workers_.reserve(asked);
  try {
    while (workers_.size() < asked) workers_.emplace_back([this] { work(); });
  } catch (const std::system_error&) {
    // The system gives no more: those that there are do the work.
    if (workers_.empty()) throw;
  }
}

ThreadPool::~ThreadPool() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  wake_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

void ThreadPool::parallel_for(std::size_t count, const std::function<void(std::size_t)>& body) {
  std::vector<std::future<void>> done;
  done.reserve(count);
  for (std::size_t i = 0; i < count; ++i) done.push_back(submit([&body, i] { body(i); }));
  for (const auto& future : done) future.wait();
  for (auto& future : done) future.get();
}

std::size_t ThreadPool::default_size() {
  return std::max<std::size_t>(1, std::thread::hardware_concurrency());
}

void ThreadPool::enqueue(std::function<void()> job) {
  {
    const std::lock_guard lock(mutex_);
    jobs_.push_back(std::move(job));
  }
  wake_.notify_one();
}

void ThreadPool::work() {
  for (;;) {
    std::function<void()> job;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [this] { return closing_ || !jobs_.empty(); });
      if (jobs_.empty()) return;
      job = std::move(jobs_.front());
      jobs_.pop_front();
    }
    job();
  }
}

}  // namespace roomwise
