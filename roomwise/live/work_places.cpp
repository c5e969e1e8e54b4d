#include "roomwise/live/work_places.h"

#include <chrono>

namespace roomwise::live {

WorkPlaces::Place::~Place() {
  if (of_ != nullptr) of_->give_back();
}

Expected<void> WorkPlaces::Place::go_on_as(Urgency urgency, const Interruption& interruption) {
  WorkPlaces* const of = std::exchange(of_, nullptr);
  of->give_back();
  ROOMWISE_CHECK_OK(of->wait_for_place(urgency, interruption));
  of_ = of;
  return {};
}

Expected<WorkPlaces::Place> WorkPlaces::take(Urgency urgency, const Interruption& interruption) {
  ROOMWISE_CHECK_OK(wait_for_place(urgency, interruption));
  return Place(this);
}

std::size_t WorkPlaces::waiting() const {
  const std::scoped_lock lock(mutex_);
  return waiting_.size();
}

Expected<void> WorkPlaces::wait_for_place(Urgency urgency, const Interruption& interruption) {
  constexpr auto kBetweenLooks = std::chrono::milliseconds(100);  // at the interruption
  std::unique_lock lock(mutex_);
  const auto turn = waiting_.emplace(urgency, came_++).first;
  const auto is_my_turn = [&] { return free_ > 0 && waiting_.begin() == turn; };
  while (!is_my_turn()) {
    if (auto go_on = interruption.check("waiting for other work"); !go_on) {
      waiting_.erase(turn);
      changed_.notify_all();
      return go_on;
    }
    changed_.wait_for(lock, kBetweenLooks, is_my_turn);
  }
  waiting_.erase(turn);
  --free_;
  changed_.notify_all();
  return {};
}

void WorkPlaces::give_back() {
  const std::scoped_lock lock(mutex_);
  ++free_;
  changed_.notify_all();
}

}  // namespace roomwise::live
