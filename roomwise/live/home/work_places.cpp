#include "roomwise/live/home/work_places.h"

#include <algorithm>
#include <chrono>

namespace roomwise::live {

WorkShare share_of_work(std::size_t processors, std::size_t threads) {
  const std::size_t for_work = std::max<std::size_t>(1, processors - 1);
  const std::size_t each = std::clamp<std::size_t>(threads, 1, for_work);
  return {for_work / each, each};
}

WorkPlaces::Place::~Place() {
  if (of_ != nullptr) of_->give_back();
}

std::size_t WorkPlaces::waiting() const {
  const std::scoped_lock lock(mutex_);
  return waiting_.size();
}

Expected<WorkPlaces::Place> WorkPlaces::take(Urgency urgency, const Interruption& interruption) {
  constexpr auto kBetweenLooks = std::chrono::milliseconds(100);  // at the interruption
  std::unique_lock lock(mutex_);
  const auto turn = waiting_.emplace(urgency, came_++).first;
  const auto is_my_turn = [&] { return free_ > 0 && waiting_.begin() == turn; };
  while (!is_my_turn()) {
    if (auto go_on = interruption.check("waiting for other work"); !go_on) {
      waiting_.erase(turn);
      changed_.notify_all();
      return Unexpected(std::move(go_on).error());
    }
    changed_.wait_for(lock, kBetweenLooks, is_my_turn);
  }
  waiting_.erase(turn);
  --free_;
  changed_.notify_all();
  return Place(this);
}

void WorkPlaces::give_back() {
  const std::scoped_lock lock(mutex_);
  ++free_;
  changed_.notify_all();
}

}  // namespace roomwise::live
