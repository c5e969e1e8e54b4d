#include "roomwise/live/device/frame_workers.h"

#include <fmt/format.h>

#include <exception>

namespace roomwise::live {

FrameWorkers::~FrameWorkers() {
  const std::scoped_lock lock(mutex_);
  closing_ = true;
}

void FrameWorkers::add(std::shared_ptr<Device> device) {
  const std::scoped_lock lock(mutex_);
  if (closing_ || !waiting_.insert(device).second) return;
  (void)pool_.submit([this, device = std::move(device)] { work(device); });
}

void FrameWorkers::work(const std::shared_ptr<Device>& device) {
  {
    const std::scoped_lock lock(mutex_);
    waiting_.erase(device);
    if (closing_) return;
  }
  // The pool's future, in which a fault would be kept, is asked by nobody.
  try {
    if (device->work()) add(device);
  } catch (const std::exception& fault) {
    report_(Error{fmt::format("internal error, please report it: {}", fault.what())});
  }
}

}  // namespace roomwise::live
