#include "roomwise/live/frame_workers.h"

#include <algorithm>

namespace roomwise::live {

FrameWorkers::FrameWorkers(std::size_t threads) {
  for (std::size_t i = 0; i < std::max<std::size_t>(1, threads); ++i) {
    threads_.emplace_back([this] { run(); });
  }
}

FrameWorkers::~FrameWorkers() {
  {
    const std::scoped_lock lock(mutex_);
    closing_ = true;
    queue_.clear();
  }
  wake_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void FrameWorkers::add(std::shared_ptr<Device> device) {
  {
    const std::scoped_lock lock(mutex_);
    if (closing_ || std::ranges::find(queue_, device) != queue_.end()) return;
    queue_.push_back(std::move(device));
  }
  wake_.notify_one();
}

void FrameWorkers::run() {
  for (;;) {
    std::shared_ptr<Device> device;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [this] { return closing_ || !queue_.empty(); });
      if (closing_) return;
      device = std::move(queue_.front());
      queue_.pop_front();
    }
    if (device->work()) add(std::move(device));
  }
}

}  // namespace roomwise::live
