#include "roomwise/guide/led/led_phrases.h"

#include "roomwise/guide/places/surfaces.h"
#include "roomwise/guide/way/way_phrases.h"

namespace roomwise::guide {

std::optional<Phrase> standing_phrase(const FollowedWay& way, const Pose& pose) {
  if (!way.has_legs() || way.leg().stairs) return std::nullopt;
  if (way.leg().ends_at_door()) {
    return Phrase{with_side("guide.place", way.leg().to, pose), {{"place", thing("door")}}};
  }
  const Eigen::Vector2d& here = pose.position_plan;
  const KnownThing* const nearest = nearest_sure_thing(here, 2 * kHand_m, way.map());
  if (nearest == nullptr) return std::nullopt;
  return Phrase{with_side("guide.place", outline_of(*nearest).nearest_to(here), pose),
                {{"place", thing(nearest->name)}}};
}

std::optional<Phrase> next_phrase(const FollowedWay& way, const std::string& left,
                                  const Phrasebook& phrases) {
  const Leg& leg = way.leg();
  if (leg.stairs) return stairs_phrase(*leg.stairs, phrases);
  if (way.is_last_leg()) {
    if (!way.leads_to_goal()) return Phrase{"guide.soon_end", {{"distance", left}}};
    return Phrase{"guide.soon_goal", {{"distance", left}, {"goal", Nouns{way.goal().noun}}}};
  }
  if (way.goes_over_stairs_next()) {
    return Phrase{stairs_message("stairs.soon", *way.next_leg().stairs), {{"distance", left}}};
  }
  const auto place = leg.ends_at_door() ? door_noun(*leg.doorway) : way.place_at_end();
  if (!way.goes_straight_on()) {
    const double turn = turn_rad(leg.heading_rad(), way.next_leg().heading_rad());
    return soon_turn_phrase(turn, left, place);
  }
  if (const auto into = way.room_beyond()) {
    return Phrase{"guide.soon_into", {{"distance", left}, {"room", room(*into)}}};
  }
  if (!leg.ends_at_door()) return std::nullopt;
  return Phrase{"guide.soon_through", {{"distance", left}, {"place", Nouns{*place}}}};
}

Phrase there_phrase(const Goal& goal, const Pose& pose) {
  if (goal.kind == Goal::Kind::kRoom) return {"guide.there_room", {{"room", room(*goal.room)}}};
  const Eigen::Vector2d touch = goal.kind == Goal::Kind::kDoor
                                    ? goal.outline->middle_plan
                                    : goal.outline->nearest_to(pose.position_plan);
  // Who stands on it, or between a door's jambs, has it on no side.
  const bool is_underfoot = !goal.is_solid() && (touch - pose.position_plan).norm() < kLegEnd_m;
  if (is_underfoot) return {"guide.there_here", {{"goal", Nouns{goal.noun}}}};
  return {with_side("guide.there", touch, pose), {{"goal", Nouns{goal.noun}}}};
}

std::vector<Phrase> at_goal_phrases(const Goal& goal, const Wording& wording) {
  std::vector<Phrase> phrases;
  if (goal.kind == Goal::Kind::kDoor && goal.outline && goal.outline->size_m.x() > 0) {
    phrases.push_back(
        {"guide.door_width", {{"width", width_text(goal.outline->size_m.x(), wording.phrases())}}});
  }
  if (goal.kind == Goal::Kind::kThing && !goal.on.empty()) {
    phrases.push_back({"where.on", {{"thing", thing(goal.on)}}});
  }
  if (goal.kind == Goal::Kind::kThing && goal.height_m) {
    phrases.push_back({height_message(*goal.height_m)});
  }
  if (!goal.note.empty()) phrases.push_back({"where.note", {{"note", as_sentence(goal.note)}}});
  return phrases;
}

}  // namespace roomwise::guide
