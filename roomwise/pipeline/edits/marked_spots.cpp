#include "roomwise/pipeline/edits/marked_spots.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "roomwise/pipeline/objects/own_things.h"
#include "roomwise/pipeline/stored/stored_edits.h"

namespace roomwise::pipeline {
namespace {

using Json = nlohmann::ordered_json;

std::string without_capitals(std::string name) {
  for (char& letter : name) {
    if (letter >= 'A' && letter <= 'Z') letter = static_cast<char>(letter - 'A' + 'a');
  }
  return name;
}

bool is_called(const MarkedSpot& spot, const std::string& name) {
  return without_capitals(spot.name) == without_capitals(name);
}

home::Edit row_of(const MarkedSpot& spot) {
  return {.id = spot.id,
          .made_s = spot.marked_s,
          .made_by = spot.owner,
          .what = std::string(kSpotRow),
          .change = Json{{"name", spot.name}}.dump(),
          .before = "{}",
          .places = {spot.place}};
}

Expected<MarkedSpot> spot_of(const home::Home& home, home::Edit row) {
  const Json change = Json::parse(row.change, nullptr, false);
  const auto name = change.is_object() ? change.find("name") : change.end();
  if (name == change.end() || !name->is_string() || row.places.size() != 1) {
    return fail("{}: is damaged: spot {} cannot be read; put back a copy of it", home.file(),
                row.id);
  }
  return MarkedSpot{row.id, name->get<std::string>(), std::move(row.made_by), row.made_s,
                    std::move(row.places.front())};
}

Expected<MarkedSpot> find_spot(std::span<const MarkedSpot> spots, home::EditId id) {
  const auto found = std::ranges::find(spots, id, &MarkedSpot::id);
  if (found == spots.end()) return fail("there is no spot {} any more; list them anew", id);
  return *found;
}

}  // namespace

Expected<std::vector<MarkedSpot>> marked_spots(const home::Home& home) {
  std::vector<MarkedSpot> spots;
  ROOMWISE_TRY(auto rows, home.edits());
  for (home::Edit& row : rows) {
    if (row.what != kSpotRow) continue;
    ROOMWISE_TRY(MarkedSpot spot, spot_of(home, std::move(row)));
    spots.push_back(std::move(spot));
  }
  std::ranges::stable_sort(spots, {}, &MarkedSpot::name);
  return spots;
}

Expected<home::EditPlace> spot_place(std::span<const home::Keyframe> keyframes,
                                     const Eigen::Vector3d& point_world) {
  geometry::OrientedBox point;
  point.world_from_box.translation = point_world;
  point.size_m = Eigen::Vector3d::Zero();
  return place_in(keyframes, 0, point);
}

std::optional<Eigen::Vector3d> point_world(const home::EditPlace& place,
                                           std::span<const home::Keyframe> keyframes) {
  const auto point = box_world(place, keyframes);
  if (!point || keyframes[*place.keyframe].pose.component != 0) return std::nullopt;
  return point->center();
}

Expected<home::EditPlace> spot_place_on_plan(std::span<const home::Keyframe> keyframes,
                                             const fusion::GravityAlignedFrame& frame,
                                             const Eigen::Vector3d& point_plan) {
  return spot_place(keyframes, frame.world_from_plan(point_plan));
}

std::optional<Eigen::Vector3d> point_on_plan(const home::EditPlace& place,
                                             std::span<const home::Keyframe> keyframes,
                                             const fusion::GravityAlignedFrame& frame) {
  const auto world = point_world(place, keyframes);
  return world ? std::optional<Eigen::Vector3d>(frame.on_plan(*world)) : std::nullopt;
}

Expected<void> check_spot_name(const home::Home& home, const std::string& name) {
  if (const auto valid = validate_spoken_name(name); !valid) {
    return fail_with(ErrorCode::kRefused, "{}", valid.error().message);
  }
  ROOMWISE_TRY(const auto taught, home.own_things());
  if (std::ranges::find(taught, name, &home::OwnThing::name) != taught.end()) {
    return fail_with(ErrorCode::kRefused, "{} is a thing that was taught; name the place otherwise",
                     name);
  }
  return check_own_thing_name(home, name);
}

Expected<home::EditId> mark_spot(home::Home& home, const MarkedSpot& spot) {
  if (!spot.name.empty()) ROOMWISE_RETURN_IF_ERROR(check_spot_name(home, spot.name));
  ROOMWISE_TRY(const auto spots, marked_spots(home));
  const auto earlier = std::ranges::find_if(spots, [&](const MarkedSpot& one) {
    return one.owner == spot.owner && is_called(one, spot.name);
  });
  if (earlier == spots.end() && spots.size() >= kMaxSpots) {
    return fail("{} places are marked; forget one first", spots.size());
  }
  home::EditId id = 0;
  ROOMWISE_RETURN_IF_ERROR(home.atomically([&]() -> Expected<void> {
    if (earlier != spots.end()) ROOMWISE_RETURN_IF_ERROR(home.remove_edit(earlier->id));
    ROOMWISE_TRY(id, home.add_edit(row_of(spot)));
    return {};
  }));
  return id;
}

Expected<void> rename_spot(home::Home& home, home::EditId id, const std::string& name) {
  ROOMWISE_RETURN_IF_ERROR(check_spot_name(home, name));
  ROOMWISE_TRY(const auto spots, marked_spots(home));
  ROOMWISE_TRY(MarkedSpot spot, find_spot(spots, id));
  const bool is_taken = std::ranges::any_of(spots, [&](const MarkedSpot& one) {
    return one.id != id && one.owner == spot.owner && is_called(one, name);
  });
  if (is_taken) {
    return fail_with(ErrorCode::kRefused, "another place is called {}; choose another name", name);
  }
  spot.name = name;
  return home.replace_edit(row_of(spot));
}

Expected<void> forget_spot(home::Home& home, home::EditId id) {
  ROOMWISE_TRY(const auto spots, marked_spots(home));
  ROOMWISE_RETURN_IF_ERROR(find_spot(spots, id));
  return home.atomically([&]() -> Expected<void> {
    ROOMWISE_RETURN_IF_ERROR(home.remove_edit(id));
    return home.owe_erasing();
  });
}

}  // namespace roomwise::pipeline
