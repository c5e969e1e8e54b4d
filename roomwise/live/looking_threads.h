#pragma once

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <set>
#include <thread>
#include <vector>

#include "roomwise/live/device.h"

namespace roomwise::live {

// Threads that look at what devices send: each device in its turn, so that many of them share the
// processor evenly.
class LookingThreads {
 public:
  explicit LookingThreads(std::size_t threads);
  ~LookingThreads();  // drops what waits, finishes what is in work
  LookingThreads(const LookingThreads&) = delete;
  LookingThreads& operator=(const LookingThreads&) = delete;

  // The device's work() will be called; once, however often this is called before.
  void add(std::shared_ptr<Device> device);

 private:
  void run();

  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<std::shared_ptr<Device>> queue_;  // each device once
  bool closing_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace roomwise::live
