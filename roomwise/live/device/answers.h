#pragma once

#include <optional>
#include <string>
#include <vector>

#include "roomwise/base/calendar_time.h"
#include "roomwise/guide/places/places.h"
#include "roomwise/guide/questions/understand.h"
#include "roomwise/guide/words/message_catalogue.h"
#include "roomwise/guide/words/prompt.h"
#include "roomwise/guide/words/wording.h"
#include "roomwise/live/device/frame_processor.h"
#include "roomwise/service/protocol/messages.h"

namespace roomwise::live {

// What an answer may rest on.
struct Situation {
  const HomeView& home;
  const FrameResult* result;  // null: there is no picture that is new enough
  const service::SpeakingSettings& settings;
  double now_t_ms;  // by the device's clock
  std::optional<CalendarTime> today = std::nullopt;
  // As somebody found it who was led over it a while ago; null: as the map has it.
  const fusion::FloorGrid* found_floor = nullptr;
  bool had_pictures = false;  // else the device sent none since it came
};

// A glance that is older than this at the time of a question is not answered by, ms: a direction
// holds for two seconds from its picture, and words take their time.
constexpr double kMaxFrameAge_ms = 800;

// How somebody is spoken to who wants that; English where their language is not known.
[[nodiscard]] guide::Wording wording_of(const service::SpeakingSettings& settings);
// What a picture tells of where somebody is; nothing of none.
[[nodiscard]] guide::UserLocation standing_of(const FrameResult* result);

// With a place less sure nobody would be brought back within reach of a spot: its standard
// deviation, m.
constexpr double kMaxSpotSigma_m = 0.3;
// The spot that is called so; null: none.
[[nodiscard]] const ViewedSpot* spot_called(const std::string& name, const HomeView& home);
// The spot that is asked for: of that name or, where the way out is, one whose name means that.
[[nodiscard]] const ViewedSpot* spot_asked_for(const service::Ask& ask, const HomeView& home,
                                               const guide::Phrasebook& phrases);
// Whether it is the way out: by the protocol's goal, or by a name of it that nothing else has.
[[nodiscard]] bool asks_for_way_out(const service::Ask& ask, const HomeView& home,
                                    const guide::Phrasebook& phrases);
// The name of what is asked for.
[[nodiscard]] std::string name_asked_for(const service::Ask& ask);
// Whether a name is one of a thing or a room of the home, as somebody may call it.
[[nodiscard]] bool means_something(const std::string& name, const HomeView& home,
                                   const guide::Wording& wording);
// What "take me back" means, as a spot of the view is called: where somebody asked that their place
// be remembered, not longer ago than half a day; else where they set out; else the first, though
// long ago. Nothing where none of these is known. `now_s`: since 1970.
[[nodiscard]] std::optional<std::string> way_back(const HomeView& home, std::int64_t now_s);

// The rooms of which one must be chosen before somebody can be led to a thing: several of its name
// stand in different rooms, and none where they are. Empty: nothing to choose.
[[nodiscard]] std::vector<std::string> rooms_to_choose(const service::Ask& ask,
                                                       const HomeView& home,
                                                       const guide::UserLocation& location,
                                                       const guide::Wording& wording);
// The doors that are asked for: of the rooms that were named with them. Nothing where no door is
// asked for, or where the home has a thing that is called so.
[[nodiscard]] std::optional<std::vector<rooms::Doorway>> doors_asked_for(
    const service::Ask& ask, const HomeView& home, const guide::Phrasebook& phrases);
// The rooms of which one must be chosen before somebody can be led to a door: doors of the room
// that was named lead to several, and none to where they are. Empty: nothing to choose.
[[nodiscard]] std::vector<std::string> doors_to_choose(const service::Ask& ask,
                                                       const HomeView& home,
                                                       const guide::UserLocation& location,
                                                       const guide::Wording& wording);
// Things of the home but those in other rooms than the one that was named. Where the way out is
// asked for, those whose name means that ("front door"), by the name kNameOfWayOut.
[[nodiscard]] std::vector<guide::KnownThing> things_asked_for(const service::Ask& ask,
                                                              const HomeView& home,
                                                              const guide::Phrasebook& phrases);

// The names of the home's things in the language that is spoken, each once, in order; answer()
// knows what is meant by them.
[[nodiscard]] std::vector<std::string> names_of_things(const HomeView& home,
                                                       const service::SpeakingSettings& settings);

// Of these names those of which several stand in different rooms, where all their rooms are known.
[[nodiscard]] std::vector<service::ThingInRooms> things_in_rooms(
    const HomeView& home, const service::SpeakingSettings& settings);

// What may be named in a question in one's own words. The home must outlive it.
[[nodiscard]] guide::HomeNames names_in(const HomeView& home);
// The question that was meant by one in words, as if it had been asked so; nothing where it is none
// that can be answered.
[[nodiscard]] std::optional<service::Ask> ask_of(const guide::Understood& heard,
                                                 const service::Ask& in_words);

// What is said to a question, the most important first; never nothing. The room of kNameRoom has
// been named already; kRepeat is asked here only where nothing was asked before,
// kInWords never.
[[nodiscard]] std::vector<guide::Prompt> answer(const service::Ask& ask,
                                                const Situation& situation);

// The answer where a picture is needed and there is none that is new enough.
[[nodiscard]] guide::Prompt no_picture(bool had_pictures, const guide::Wording& wording,
                                       double now_t_ms);
// The answer where a map is needed and there is none.
[[nodiscard]] guide::Prompt no_map(const guide::Wording& wording, double now_t_ms);

// Decides what is called out while a person walks and asks nothing: a room that was entered, and
// what stands ahead, a hazard with every picture that shows it: who speaks says it once in a while.
class Announcer {
 public:
  // After each glance, whether or not it is spoken. Obstacles only where nobody else judges them.
  [[nodiscard]] std::vector<guide::Prompt> after(const Situation& situation,
                                                 bool tells_obstacles = true);
  // After each answer: a room that it named is not called out as well.
  void answered(const Situation& situation, const std::vector<guide::Prompt>& prompts);

 private:
  // Who stands before something hears of it when it comes, when it comes nearer, when the side or
  // the name that they heard does not hold any more, and now and then.
  [[nodiscard]] bool is_obstacle_news(const FrameResult& result, bool is_named);

  std::string room_now_;     // by the last glance; empty: not sure
  std::string room_called_;  // the last that was called out, or named by an answer
  // What stands ahead and was told of; absent: nothing.
  struct Obstacle {
    double told_s = 0, seen_s = 0;  // by the pictures' clock: first told, seen last
    double told_m = 0;              // how far it was then
    guide::ObstacleAhead::Side side = guide::ObstacleAhead::Side::kAhead;
    bool was_named = false;
  };
  std::optional<Obstacle> obstacle_;
};

}  // namespace roomwise::live
