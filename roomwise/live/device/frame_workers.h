#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <set>

#include "roomwise/base/expected.h"
#include "roomwise/base/thread_pool.h"
#include "roomwise/live/device/device.h"

namespace roomwise::live {

// Threads that look at what devices send: each device in its turn, so that many of them share the
// processor evenly.
class FrameWorkers {
 public:
  // `report` is told, on one of the threads, of a fault in a device's work: the device is looked at
  // again when its next frame comes.
  FrameWorkers(std::size_t threads, std::function<void(const Error&)> report)
      : report_(std::move(report)), pool_(threads) {}
  ~FrameWorkers();  // drops what waits, finishes what is in work
  FrameWorkers(const FrameWorkers&) = delete;
  FrameWorkers& operator=(const FrameWorkers&) = delete;

  // The device's work() will be called; once, however often this is called before.
  void add(std::shared_ptr<Device> device);

 private:
  void work(const std::shared_ptr<Device>& device);

  std::function<void(const Error&)> report_;
  std::mutex mutex_;
  std::set<std::shared_ptr<Device>> waiting_;
  bool closing_ = false;
  ThreadPool pool_;  // last, so that it ends first
};

}  // namespace roomwise::live
