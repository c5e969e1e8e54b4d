#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "roomwise/home/home.h"
#include "roomwise/pipeline/run_context.h"

namespace roomwise::pipeline {

// Key-frames whose pictures are stored and cannot be read again. One of them need not end the work
// on all: it goes on as if that key-frame had shown nothing, and what is known of it otherwise (its
// place, its edges, what was found in it) stays. Thread-safe.
class LostPictures {
 public:
  // Whether to go on without them; else the first ends the work. `tell`: of each, once.
  explicit LostPictures(
      bool leave_out, std::function<void(const Error&)> tell = [](const Error&) {})
      : leave_out_(leave_out), tell_(std::move(tell)) {}

  // Notes the key-frame, once. Fails with `why` where it is not to be left out.
  [[nodiscard]] Expected<void> note(home::KeyframeId id, const Error& why);
  // By key-frame, why, naming the home and the key-frame.
  [[nodiscard]] std::map<home::KeyframeId, std::string> all() const;
  // Whether it failed: who asked may be told how to go on without the picture.
  [[nodiscard]] bool is_stopped() const { return is_stopped_; }

 private:
  bool leave_out_;
  std::atomic<bool> is_stopped_ = false;
  std::function<void(const Error&)> tell_;
  mutable std::mutex mutex_;
  std::map<home::KeyframeId, std::string> lost_;
};

// What to do where a key-frame's picture cannot be read, which `why` tells: success is to go on
// without it. Never where all are locked, nor where the user interrupts; nor in work to which
// nobody gave LostPictures.
[[nodiscard]] Expected<void> go_on_without(const home::Home& home, home::KeyframeId id, Error why,
                                           const std::shared_ptr<LostPictures>& lost);

}  // namespace roomwise::pipeline
