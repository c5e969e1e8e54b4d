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
class FrameWorkers {
 public:
  explicit FrameWorkers(std::size_t threads);
  ~FrameWorkers();  // drops what waits, finishes what is in work
  FrameWorkers(const FrameWorkers&) = delete;
  FrameWorkers& operator=(const FrameWorkers&) = delete;

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
