#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <thread>
#include <type_traits>
#include <vector>

namespace roomwise {

// A fixed number of threads that carry out tasks in the order of their submission. With `threads` =
// 1 there is still one worker, so that a run takes the same path at any count. The destructor
// finishes what was submitted.
//
// Results never depend on the number of threads: a task owns its inputs, and callers read the
// futures in the order of submission.
class ThreadPool {
 public:
  explicit ThreadPool(std::size_t threads);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  [[nodiscard]] std::size_t size() const { return workers_.size(); }

  template <typename Task>
  [[nodiscard]] std::future<std::invoke_result_t<Task>> submit(Task task) {
    auto packaged =
        std::make_shared<std::packaged_task<std::invoke_result_t<Task>()>>(std::move(task));
    auto future = packaged->get_future();
    enqueue([packaged] { (*packaged)(); });
    return future;
  }

  // Calls body(i) for every i in [0, count) and returns when all are done; rethrows the first
  // exception. Not to be called from a task of the same pool.
  void parallel_for(std::size_t count, const std::function<void(std::size_t)>& body);

  // The machine's hardware threads, at least 1.
  static std::size_t default_size();

 private:
  void enqueue(std::function<void()> job);
  void work();

  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<std::function<void()>> jobs_;
  bool closing_ = false;
  std::vector<std::thread> workers_;
};

}  // namespace roomwise
