#include <algorithm>

#include "roomwise/guide/answers/spot_prompts.h"
#include "roomwise/live/device/owner.h"
#include "roomwise/live/home/live_home.h"

// Places that people mark in a home that is open.
namespace roomwise::live {
namespace {

// A place of the map beside the key-frame that is nearest.
Expected<home::EditPlace> anchored(const HomeView& view, const Eigen::Vector3d& place_plan) {
  if (!view.map) return fail("the map is not ready");
  std::vector<home::Keyframe> keyframes;
  for (const ViewedKeyframe& one : view.keyframes) keyframes.push_back(one.keyframe);
  return pipeline::spot_place_on_plan(keyframes, view.map->frame, place_plan);
}

// The device's own of that name; else, for a helper, the computer's.
const pipeline::MarkedSpot* find_spot_of(const service::Identity& who, const std::string& name,
                                         std::span<const pipeline::MarkedSpot> spots) {
  const auto is_meant = [&](const std::string& owner) {
    return [&name, owner](const pipeline::MarkedSpot& one) {
      return one.owner == owner && one.name == name;
    };
  };
  auto found = std::ranges::find_if(spots, is_meant(owner_of(who)));
  if (found == spots.end() && who.role == service::Role::kHelper) {
    found = std::ranges::find_if(spots, is_meant(""));
  }
  return found == spots.end() ? nullptr : &*found;
}

}  // namespace

std::vector<ViewedSpot> LiveHome::spots_for(const service::Identity& who) const {
  std::vector<ViewedSpot> spots;
  const auto is_there = [&](const std::string& name) {
    return std::ranges::any_of(spots, [&](const auto& one) { return one.thing.name == name; });
  };
  // Their own before the computer's of the same name.
  for (const bool is_taught : {true, false}) {
    for (const ViewedSpot& one : view_->marked) {
      const bool may_know = one.stored.is_known_to(owner_of(who));
      const bool fits = (one.stored.owner == owner_of(who)) == is_taught;
      if (may_know && fits && !is_there(one.thing.name)) spots.push_back(one);
    }
  }
  if (const auto start = set_out_.find(who.device); start != set_out_.end()) {
    const pipeline::MarkedSpot spot{.name = {}, .owner = owner_of(who), .place = start->second};
    spots.push_back(view_spot(spot, guide::kStartingPlace, *view_));
  }
  return spots;
}

void LiveHome::sets_out(const service::Identity& who, const Eigen::Vector3d& place_plan) {
  const auto now = view();
  const auto place = anchored(*now, place_plan);
  if (!place) return;  // then nobody is led by the map either
  const std::scoped_lock lock(view_mutex_);
  if (!view_->map) return;  // it is made anew meanwhile
  set_out_[who.device] = *place;
  views_of_devices_.erase(who.device);
}

Expected<void> LiveHome::change_spots(const std::function<Expected<void>(home::Home&)>& change) {
  const std::scoped_lock one_by_one(changes_mutex_);
  const std::unique_lock lock(home_mutex_, std::try_to_lock);
  if (!lock.owns_lock()) return fail("the computer is busy; wait until it is done, or stop it");
  ROOMWISE_RETURN_IF_ERROR(watched("a change", change(home_)));
  auto changed = std::make_shared<HomeView>(*view());
  ROOMWISE_RETURN_IF_ERROR(view_spots(home_, *changed));
  ROOMWISE_TRY(changed->owes_erasing, home_.owes_erasing());
  {
    const std::scoped_lock view_lock(view_mutex_);
    views_of_devices_.clear();
    view_ = std::move(changed);
  }
  for (const auto& device : all_devices()) device->home_changed();
  return {};
}

Expected<void> LiveHome::mark_spot(const service::Identity& who, const std::string& name,
                                   const Eigen::Vector3d& place_plan) {
  return change_spots([&](home::Home& home) -> Expected<void> {
    ROOMWISE_TRY(const home::EditPlace place, anchored(*view(), place_plan));
    return pipeline::mark_spot(home, {0, name, owner_of(who), options_.clock(), place})
        .map([](home::EditId) {});
  });
}

Expected<void> LiveHome::change_spot(const service::Identity& who, const std::string& name,
                                     const std::optional<std::string>& new_name) {
  return change_spots([&](home::Home& home) -> Expected<void> {
    ROOMWISE_TRY(const auto spots, pipeline::marked_spots(home));
    const pipeline::MarkedSpot* const spot = find_spot_of(who, name, spots);
    if (spot == nullptr) {
      return fail_with(ErrorCode::kRefused, "'{}' was not marked by this device", name);
    }
    if (new_name) return pipeline::rename_spot(home, spot->id, *new_name);
    return pipeline::forget_spot(home, spot->id);
  });
}

}  // namespace roomwise::live
