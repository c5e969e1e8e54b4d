#pragma once

#include <array>
#include <string>
#include <string_view>
#include <utility>

namespace roomwise::guide {

// What may be asked in one's own words.
enum class QuestionType {
  kWhereAmI,
  kAroundMe,
  kWhereIs,
  kWayTo,
  kTakeMeTo,
  kTakeMeOut,  // of the home
  kWhatIsOn,
  kWhatIsIn,
  kWhichRooms,
  kWhichWay,
  kWhatIsAhead,
  kWhatIsLeft,  // of who asks
  kWhatIsRight,
  kWhatIsBehind,
  kWhereToSit,
  kSomethingAhead,  // that there is something, or whether: a guide hears kBlocked
  kWhatChanged,
  kDescribeRoom,
  kRepeat,
  kPause,  // to whoever leads, down to kEnd
  kResume,
  kHowFar,
  kNext,
  kBlocked,
  kEnd,
  kWhatCanIAsk,
  kHelp,         // of whatever kind
  kEmergency,    // somebody fell, or it burns
  kSettings,     // to speak otherwise
  kTeachThing,   // a thing is to be shown
  kForgetThing,  // that was taught
  kShareThing,   // with all people of the home
  kKeepThing,    // its owner's alone
  kMarkSpot,     // where one stands is to be remembered
  kTakeMeBack,   // to where one was
  kWhichSpots,
  kForgetSpot,
  kWhoIsHere,  // whether somebody is in the picture
  kIsItLight,  // in the picture
  kShowWalks,  // to helpers
  kHideWalks,
  kYes,  // to "Did you mean ...?"
  kNo,
  kFirst,  // of those that were offered, down to kOther
  kSecond,
  kThird,
  kNearest,
  kLeftOne,
  kRightOne,
  kOther,       // than was chosen
  kThere,       // to be led to what was named last
  kAlso,        // the same of another
  kNamed,       // a name alone
  kCannotTell,  // what no picture and no map can answer
};

// As catalogues call them.
constexpr std::array<std::pair<std::string_view, QuestionType>, 54> kQuestionTypes{
    {{"where_am_i", QuestionType::kWhereAmI},
     {"around_me", QuestionType::kAroundMe},
     {"where_is", QuestionType::kWhereIs},
     {"way_to", QuestionType::kWayTo},
     {"take_me_to", QuestionType::kTakeMeTo},
     {"take_me_out", QuestionType::kTakeMeOut},
     {"what_is_on", QuestionType::kWhatIsOn},
     {"what_is_in", QuestionType::kWhatIsIn},
     {"which_rooms", QuestionType::kWhichRooms},
     {"which_way", QuestionType::kWhichWay},
     {"what_is_ahead", QuestionType::kWhatIsAhead},
     {"what_is_left", QuestionType::kWhatIsLeft},
     {"what_is_right", QuestionType::kWhatIsRight},
     {"what_is_behind", QuestionType::kWhatIsBehind},
     {"where_to_sit", QuestionType::kWhereToSit},
     {"something_ahead", QuestionType::kSomethingAhead},
     {"what_changed", QuestionType::kWhatChanged},
     {"describe_room", QuestionType::kDescribeRoom},
     {"repeat", QuestionType::kRepeat},
     {"pause", QuestionType::kPause},
     {"resume", QuestionType::kResume},
     {"how_far", QuestionType::kHowFar},
     {"next", QuestionType::kNext},
     {"blocked", QuestionType::kBlocked},
     {"end", QuestionType::kEnd},
     {"what_can_i_ask", QuestionType::kWhatCanIAsk},
     {"help", QuestionType::kHelp},
     {"emergency", QuestionType::kEmergency},
     {"settings", QuestionType::kSettings},
     {"yes", QuestionType::kYes},
     {"no", QuestionType::kNo},
     {"first", QuestionType::kFirst},
     {"second", QuestionType::kSecond},
     {"third", QuestionType::kThird},
     {"nearest", QuestionType::kNearest},
     {"left_one", QuestionType::kLeftOne},
     {"right_one", QuestionType::kRightOne},
     {"other", QuestionType::kOther},
     {"there", QuestionType::kThere},
     {"also", QuestionType::kAlso},
     {"named", QuestionType::kNamed},
     {"cannot_tell", QuestionType::kCannotTell},
     {"teach_thing", QuestionType::kTeachThing},
     {"who_is_here", QuestionType::kWhoIsHere},
     {"is_it_light", QuestionType::kIsItLight},
     // Before things that are shared: a walk is none.
     {"show_walks", QuestionType::kShowWalks},
     {"hide_walks", QuestionType::kHideWalks},
     {"mark_spot", QuestionType::kMarkSpot},
     {"take_me_back", QuestionType::kTakeMeBack},
     {"which_spots", QuestionType::kWhichSpots},
     // Before things: a spot is somebody's own.
     {"forget_spot", QuestionType::kForgetSpot},
     {"forget_thing", QuestionType::kForgetThing},
     {"share_thing", QuestionType::kShareThing},
     {"keep_thing", QuestionType::kKeepThing}}};

}  // namespace roomwise::guide
