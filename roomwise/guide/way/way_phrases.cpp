#include "roomwise/guide/way/way_phrases.h"

#include <cmath>

#include "roomwise/guide/way/legs.h"

namespace roomwise::guide {
namespace {

// Hours of a clock are 30 degrees wide; a quarter of a turn and half a one have names of their own,
// and what is less than an hour is "a little".
constexpr double kLittle_rad = 25 * kDegree_rad;
constexpr double kAround_rad = 135 * kDegree_rad;

std::string hour_of(double turn) {
  const auto clockwise = static_cast<int>(std::lround(-turn / (30 * kDegree_rad)));
  return fmt::format("{}", clockwise <= 0 ? clockwise + 12 : clockwise);
}

bool is_quarter(double turn) {
  return std::abs(std::abs(turn) - 90 * kDegree_rad) < 15 * kDegree_rad;
}

Nouns list_of(const Noun& noun) {
  return {noun};
}

}  // namespace

Phrase turn_phrase(double turn) {
  const bool is_left = turn > 0;
  if (std::abs(turn) < kLittle_rad) return {is_left ? "guide.little_left" : "guide.little_right"};
  if (std::abs(turn) > kAround_rad) return {"guide.turn_around"};
  if (is_quarter(turn)) return {is_left ? "guide.turn_left" : "guide.turn_right"};
  return {is_left ? "guide.turn_hour_left" : "guide.turn_hour_right", {{"hour", hour_of(turn)}}};
}

Phrase soon_turn_phrase(double turn, const std::string& distance,
                        const std::optional<Noun>& place) {
  Phrase phrase{"guide.soon_hour", {{"distance", distance}}};
  if (std::abs(turn) > kAround_rad) {
    phrase.message_id = "guide.soon_around";
  } else if (is_quarter(turn)) {
    phrase.message_id = turn > 0 ? "guide.soon_left" : "guide.soon_right";
  } else {
    phrase.values["hour"] = hour_of(turn);
  }
  if (place) {
    phrase.message_id += "_at";
    phrase.values["place"] = list_of(*place);
  }
  return phrase;
}

Phrase stairs_phrase(const StairsOnWay& way, const Phrasebook& phrases) {
  Phrase phrase{way.is_up ? "stairs.up" : "stairs.down"};
  if (way.stairs.steps == 0) return phrase;
  phrase.values["steps"] = phrases.count("stair", way.stairs.steps);
  // Left and right are those of who walks.
  const bool has_left = way.is_up ? way.stairs.has_left_rail : way.stairs.has_right_rail;
  const bool has_right = way.is_up ? way.stairs.has_right_rail : way.stairs.has_left_rail;
  phrase.message_id += has_left && has_right ? "_both"
                       : has_left            ? "_left"
                       : has_right           ? "_right"
                                             : "_counted";
  return phrase;
}

std::string stairs_message(const std::string& message, const StairsOnWay& way) {
  return message + (way.is_up ? "_up" : "_down");
}

Phrase walk_phrase(const std::string& distance, const std::optional<Noun>& place,
                   const std::string& side) {
  if (!place) return {"guide.walk", {{"distance", distance}}};
  return {"guide.walk_to" + side, {{"distance", distance}, {"place", list_of(*place)}}};
}

Phrase more_phrase(const std::string& distance, const std::optional<Noun>& place,
                   const std::string& side) {
  if (!place) return {"guide.more", {{"distance", distance}}};
  return {"guide.more_to" + side, {{"distance", distance}, {"place", list_of(*place)}}};
}

DoorWidth width_of(const rooms::Doorway& door) {
  constexpr double kNarrow_m = 0.75, kWide_m = 1;
  if (door.width_m == 0) return DoorWidth::kUsual;
  return door.width_m < kNarrow_m ? DoorWidth::kNarrow
         : door.width_m > kWide_m ? DoorWidth::kWide
                                  : DoorWidth::kUsual;
}

std::string width_text(double width_m, const Phrasebook& phrases) {
  return phrases.count("centimetre", 5 * std::round(100 * width_m / 5));
}

Noun door_noun(const rooms::Doorway& door) {
  const DoorWidth width = width_of(door);
  return {Noun::Kind::kThing, width == DoorWidth::kNarrow ? "narrow door"
                              : width == DoorWidth::kWide ? "wide door"
                                                          : "door"};
}

std::string with_side(const std::string& message, const Eigen::Vector2d& point_plan,
                      const Pose& pose) {
  const Eigen::Vector2d towards = point_plan - pose.position_plan;
  const double turn = turn_rad(pose.heading_rad, std::atan2(towards.y(), towards.x()));
  if (std::abs(turn) <= 45 * kDegree_rad) return message + "_ahead";
  if (std::abs(turn) >= 135 * kDegree_rad) return message + "_behind";
  return message + (turn > 0 ? "_left" : "_right");
}

std::string height_message(double height_m) {
  // Of a grown person who stands: ankle, knee to thigh, hip, chest and shoulder, head.
  if (height_m < 0.3) return "guide.height_floor";
  if (height_m < 0.7) return "guide.height_knee";
  if (height_m < 1.05) return "guide.height_hip";
  if (height_m < 1.45) return "guide.height_chest";
  return "guide.height_head";
}

std::optional<Phrase> rooms_phrase(const Goal& goal, const std::vector<std::string>& rooms) {
  if (!goal.room) return std::nullopt;
  if (goal.kind == Goal::Kind::kRoom) {
    if (rooms.size() < 2) return Phrase{"guide.there_room", {{"room", room(*goal.room)}}};
    if (rooms.size() == 2) return Phrase{"guide.room_next", {{"goal", list_of(goal.noun)}}};
    return Phrase{
        "guide.room_through",
        {{"goal", list_of(goal.noun)}, {"via", room_list({rooms.begin() + 1, rooms.end() - 1})}}};
  }
  Phrase phrase{"where.here", {{"thing", list_of(goal.noun)}}};
  if (rooms.size() < 2) return phrase;
  phrase.values["room"] = room(*goal.room);
  phrase.message_id = "where.next_room";
  if (rooms.size() > 2) {
    phrase.message_id = "where.through";
    phrase.values["via"] = room_list({rooms.begin() + 1, rooms.end() - 1});
  }
  return phrase;
}

}  // namespace roomwise::guide
