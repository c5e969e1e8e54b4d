#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "roomwise/guide/words/prompt.h"
#include "roomwise/live/device/frame_processor.h"
#include "roomwise/service/credentials/identity.h"
#include "roomwise/service/protocol/messages.h"

namespace roomwise::live {

// What helpers are shown of one walk on which somebody is led, and who was told that they are. In
// memory alone. Times are of any steady clock.
class WalkWatch {
 public:
  using Time = std::chrono::steady_clock::time_point;

  // Of these prompts what the guide said or warns of.
  void say(std::span<const guide::Prompt> prompts, Time now);
  // By a picture that came then.
  void place(const CameraPose& pose, Time came);

  // With the place and what was said; of `walk` the rest.
  [[nodiscard]] service::WatchedWalk shown(service::WatchedWalk walk) const;
  // Whether it tells something new; of pictures alone two a second do. `is_over`: where they go
  // after that is nobody's business.
  [[nodiscard]] bool is_due(const service::WatchedWalk& walk, bool is_over, Time now) const;
  void was_shown(const service::WatchedWalk& walk, Time now);

  // The names of all who watch where the person was not told of each of them on this walk, which
  // counts as done then; else none. Of all, since the newest sentence takes the place of one that
  // still waits.
  [[nodiscard]] std::vector<std::string> to_tell(std::span<const service::Identity> watchers);
  [[nodiscard]] bool was_told_of(const service::Identity& watcher) const {
    return told_.contains(watcher.device);
  }

 private:
  std::optional<service::WatchedWalk::Person> person_;
  std::deque<service::WatchedWalk::Said> said_;
  std::uint64_t said_count_ = 0, said_shown_ = 0;
  std::string shown_state_;
  std::optional<Time> shown_at_;
  std::set<std::int64_t> told_;  // devices
};

// Milliseconds of that clock, as the protocol has them.
[[nodiscard]] double to_ms(WalkWatch::Time time);

}  // namespace roomwise::live
