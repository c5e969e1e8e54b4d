#include "roomwise/live/device/walk_watch.h"

#include <numbers>

namespace roomwise::live {
namespace {

constexpr std::size_t kMaxSaid = 20;
constexpr std::chrono::milliseconds kPictureGap{500};

}  // namespace

double to_ms(WalkWatch::Time time) {
  return std::chrono::duration<double, std::milli>(time.time_since_epoch()).count();
}

void WalkWatch::say(std::span<const guide::Prompt> prompts, Time now) {
  for (const guide::Prompt& prompt : prompts) {
    // Answers to what they ask beside it are theirs.
    if (prompt.replace_key != "guide" && prompt.priority != guide::Priority::kHazard) continue;
    // Who stands before something is warned with every picture.
    if (!said_.empty() && said_.back().text == prompt.text) continue;
    said_.push_back({to_ms(now), prompt.text});
    if (said_.size() > kMaxSaid) said_.pop_front();
    ++said_count_;
  }
}

void WalkWatch::place(const CameraPose& pose, Time came) {
  const guide::Pose at = pose.on_floor();
  person_ = {to_ms(came), at.position_plan.x(), at.position_plan.y(),
             at.heading_rad * 180 / std::numbers::pi, pose.sigma_m};
}

service::WatchedWalk WalkWatch::shown(service::WatchedWalk walk) const {
  walk.person = person_;
  walk.said.assign(said_.begin(), said_.end());
  return walk;
}

bool WalkWatch::is_due(const service::WatchedWalk& walk, bool is_over, Time now) const {
  if (!shown_at_ || walk.state != shown_state_ || said_count_ != said_shown_) return true;
  return !is_over && now - *shown_at_ >= kPictureGap;
}

void WalkWatch::was_shown(const service::WatchedWalk& walk, Time now) {
  shown_state_ = walk.state;
  said_shown_ = said_count_;
  shown_at_ = now;
}

std::vector<std::string> WalkWatch::to_tell(std::span<const service::Identity> watchers) {
  bool is_new = false;
  std::vector<std::string> names;
  for (const service::Identity& one : watchers) {
    is_new |= told_.insert(one.device).second;
    names.push_back(one.name);
  }
  return is_new ? names : std::vector<std::string>();
}

}  // namespace roomwise::live
