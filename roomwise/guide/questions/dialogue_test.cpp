#include "roomwise/guide/questions/dialogue.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "roomwise/guide/testing/sayings.h"
#include "roomwise/guide/words/message_catalogue.h"

namespace roomwise::guide {
namespace {

using Outcome = Understood::Outcome;

const MessageCatalogue& all_words() {
  static const MessageCatalogue built_in = MessageCatalogue::built_in();
  return built_in;
}

HomeNames flat() {
  return {.things = {"bed", "chair", "cup", "fridge", "key", "lamp", "microwave", "sofa", "table"},
          .rooms = {"bathroom", "bedroom 1", "bedroom 2", "corridor", "kitchen", "living room"},
          .goals = {"door", "way out"},
          .spots = {},
          .vocabulary = nullptr};
}

// "take_me_to kitchen", "did you mean: take_me_to kitchen".
std::string said_as(const Understood& heard) {
  switch (heard.outcome) {
    case Outcome::kCannotTell:
      return "cannot tell";
    case Outcome::kDeclined:
      return "declined";
    case Outcome::kNotUnderstood:
      return "not understood";
    default:
      break;
  }
  std::string text = heard.outcome == Outcome::kQuestion     ? ""
                     : heard.outcome == Outcome::kWhichOne   ? "which one: "
                     : heard.outcome == Outcome::kWhichRoom  ? "which room: "
                     : heard.outcome == Outcome::kWhichDoor  ? "which door: "
                     : heard.outcome == Outcome::kDidYouMean ? "did you mean: "
                                                             : "unknown: ";
  text += std::ranges::find(kQuestionTypes, heard.type, [](const auto& one) {
            return one.second;
          })->first;
  for (const Noun& noun : heard.names) text += " " + noun.name;
  for (const Noun& room : heard.rooms) text += " in " + room.name;
  return text;
}

Understood to(const std::string& name, Noun::Kind kind = Noun::Kind::kRoom) {
  return {Outcome::kQuestion, QuestionType::kTakeMeTo, {{kind, name}}};
}

// As sayings.h has it.
Dialogue before(char what) {
  Dialogue dialogue;
  const std::vector<std::optional<ChoicePlace>> places{ChoicePlace{{1, 2}, 4},
                                                       ChoicePlace{{1, -2}, 7}};
  const Understood bedrooms{Outcome::kWhichOne,
                            QuestionType::kTakeMeTo,
                            {{Noun::Kind::kRoom, "bedroom 1"}, {Noun::Kind::kRoom, "bedroom 2"}}};
  const Understood asked_table{
      Outcome::kQuestion, QuestionType::kWhereIs, {{Noun::Kind::kThing, "table"}}};
  const auto lead = [&](const std::string& room) {
    dialogue.is_led = dialogue.follows_way = true;
    dialogue.goal = {Noun::Kind::kRoom, room};
    dialogue.last = to(room);
  };
  switch (what) {
    case 'Q':
      dialogue.last = asked_table;
      break;
    case 'L':
      lead("kitchen");
      break;
    case 'P':
      lead("kitchen");
      dialogue.last = asked_table;
      break;
    case 'W':
      dialogue.offer = bedrooms;
      dialogue.places = places;
      break;
    case 'X':
      lead("bedroom 1");
      dialogue.chosen_from = bedrooms;
      dialogue.places = places;
      break;
    case 'M':
      dialogue.offer = which_room(to("chair", Noun::Kind::kThing), {"kitchen", "living room"});
      dialogue.places = places;
      break;
    case 'D':
      dialogue.offer = to("kitchen");
      dialogue.offer.outcome = Outcome::kDidYouMean;
      break;
    default:
      break;
  }
  return dialogue;
}

std::string hear_in(const Dialogue& dialogue, const std::string& text,
                    const std::string& language = "en") {
  const Understood heard = in_dialogue(text, all_words().in(language), flat(), dialogue);
  const bool is_offer =
      !choices_of(dialogue.offer).empty() && said_as(heard) == said_as(dialogue.offer);
  return is_offer ? "offer" : said_as(heard);
}

std::string hear_in(char what, const std::string& text, const std::string& language = "en") {
  return hear_in(before(what), text, language);
}

struct Saying {
  char before = 'N';
  std::string text, meaning;
};

std::vector<Saying> sayings_of(std::string_view lines) {
  std::istringstream rest{std::string(lines)};
  std::vector<Saying> sayings;
  for (std::string line; std::getline(rest, line);) {
    const std::size_t end = line.rfind('|');
    if (end == std::string::npos || end < 2) continue;
    sayings.push_back({line.front(), line.substr(2, end - 2), line.substr(end + 1)});
  }
  return sayings;
}

TEST(Dialogue, WhoIsLedAndSaysATurnAgainIsAskedWhatTheyMean) {
  EXPECT_EQ(hear_in('X', "left"), "did you mean: take_me_to bedroom 1");
  EXPECT_EQ(hear_in('X', "on my right"), "did you mean: take_me_to bedroom 2");
  EXPECT_EQ(hear_in('X', "nächste", "de"), "did you mean: take_me_to bedroom 1");
  EXPECT_EQ(hear_in('X', "no, the right one"), "take_me_to bedroom 2");
}

TEST(DialogueTest, WhatPeopleTakeBackIsUnderstoodInEveryLanguage) {
  for (const auto& [language, lines] : testing::kSayings) {
    for (const Saying& one : sayings_of(lines)) {
      EXPECT_EQ(hear_in(one.before, one.text, std::string(language)), one.meaning)
          << language << ": " << one.before << ": " << one.text;
    }
  }
}

// How many of those are understood that no pattern was written for; none of them leads astray.
TEST(DialogueTest, NobodyIsLedElsewhereByWordsThatAreNotUnderstood) {
  for (const auto& [language, lines] : testing::kSayingsKeptApart) {
    int as_meant = 0, all = 0;
    for (const Saying& one : sayings_of(lines)) {
      const std::string heard = hear_in(one.before, one.text, std::string(language));
      as_meant += heard == one.meaning ? 1 : 0;
      ++all;
      if (heard == one.meaning) continue;
      EXPECT_FALSE(heard.starts_with("take_me_to"))
          << language << ": " << one.text << ": " << heard;
      RecordProperty(std::string(language) + ": " + one.text, heard);
    }
    RecordProperty(std::string(language), std::to_string(as_meant) + " of " + std::to_string(all));
  }
}

TEST(DialogueTest, WordsForStopComeBeforeAnyCorrection) {
  for (const char what : {'L', 'P', 'X'}) {
    for (const auto& [language, text] :
         {std::pair("en", "no stop"), std::pair("de", "nein halt"), std::pair("es", "no para"),
          std::pair("fr", "non arrête")}) {
      const std::string heard = hear_in(what, text, language);
      EXPECT_TRUE(heard == "end" || heard == "pause") << text << ": " << heard;
    }
    EXPECT_EQ(hear_in(what, "stop, not the kitchen, the bathroom"), "pause");
  }
}

TEST(DialogueTest, WhatIsUnclearPausesWhoIsLedAndAsksOnce) {
  for (const char* text : {"no, the bathrom", "no, the bedroom", "no, the garage"}) {
    const Understood heard = in_dialogue(text, all_words().in("en"), flat(), before('L'));
    EXPECT_NE(heard.outcome, Outcome::kQuestion) << text;
    EXPECT_TRUE(heard.doubts_way) << text;
  }
  EXPECT_EQ(hear_in('L', "no, the whatever it was"), "pause");
  // Who says that it is not the bedroom is not led there, and may have been misheard.
  EXPECT_EQ(hear_in('L', "not the living room, the bathroom"), "did you mean: take_me_to bathroom");
  // A correction of a question leaves the way as it is.
  EXPECT_EQ(hear_in('P', "no, the sofa"), "where_is sofa");
  EXPECT_EQ(hear_in('L', "the bathroom"), "named bathroom") << "half a sentence leads nowhere";
  EXPECT_EQ(hear_in('L', "sorry, what did you say"), "repeat");
  EXPECT_EQ(hear_in('L', "no, what is in the bathroom"), "what_is_in bathroom");
  EXPECT_EQ(hear_in('L', "sorry, whatever"), "not understood") << "denies nothing";
}

TEST(DialogueTest, AnOfferThatWaitsIsToldAgainToWordsThatChooseNothing) {
  for (const char* text : {"the third one", "yes", "the other one", "roomwise", "blue"}) {
    EXPECT_EQ(hear_in('W', text), "offer") << text;
  }
  EXPECT_EQ(hear_in('M', "the bathroom"), "offer") << "no chair was offered there";
  EXPECT_EQ(hear_in('M', "in the bathroom"), "offer");
  EXPECT_EQ(hear_in('M', "what is in the bathroom"), "what_is_in bathroom");
  EXPECT_EQ(hear_in('D', "the second one"), "offer");
  EXPECT_EQ(hear_in('W', "where am I"), "where_am_i") << "another question";
}

TEST(DialogueTest, OfThreeTheRestIsOffered) {
  Dialogue dialogue;
  dialogue.offer = which_room(to("chair", Noun::Kind::kThing), {"kitchen", "corridor", "bathroom"});
  EXPECT_EQ(hear_in(dialogue, "not in the kitchen"),
            "which room: take_me_to chair in corridor in bathroom");
  dialogue.chosen_from = std::exchange(dialogue.offer, {});
  dialogue.last = choices_of(dialogue.chosen_from).front();
  EXPECT_TRUE(hear_in(dialogue, "the other one").starts_with("which room: take_me_to chair in"));
}

TEST(DialogueTest, ASideIsChosenOnlyWhereItIsClear) {
  Dialogue dialogue = before('W');
  dialogue.places = {ChoicePlace{{1, 2}, 4}, ChoicePlace{{-1, 2}, 3}};  // both to the left
  EXPECT_EQ(hear_in(dialogue, "the left one"), "offer");
  EXPECT_EQ(hear_in(dialogue, "the right one"), "offer");
  EXPECT_EQ(hear_in(dialogue, "the nearer one"), "take_me_to bedroom 2");
  dialogue.places = {ChoicePlace{{2, 2}, 4}, ChoicePlace{{2, 1}, 3}};  // both ahead
  EXPECT_EQ(hear_in(dialogue, "the right one"), "take_me_to bedroom 2");
  dialogue.places = {ChoicePlace{{1, 2}, 4}, std::nullopt};
  EXPECT_EQ(hear_in(dialogue, "the left one"), "offer");
  EXPECT_EQ(hear_in(dialogue, "the nearer one"), "offer");
  dialogue.places.clear();
  EXPECT_EQ(hear_in(dialogue, "the left one"), "offer") << "nobody knows where one stands";
}

TEST(DialogueTest, SpanishNoDeniesWhereOneIsLedAndIsAskedAboutWhatIsOffered) {
  EXPECT_EQ(hear_in('L', "no la cocina", "es"), "pause");
  EXPECT_EQ(hear_in('L', "no el baño", "es"), "take_me_to bathroom");
  EXPECT_EQ(hear_in('M', "no en la cocina", "es"), "offer");
  EXPECT_EQ(hear_in('M', "no, en la cocina", "es"), "take_me_to chair in kitchen");
  EXPECT_EQ(hear_in('M', "no en el salón sino en la cocina", "es"), "take_me_to chair in kitchen");
}

TEST(DialogueTest, UmlautsMayBeTypedAsTwoLetters) {
  EXPECT_EQ(hear_in('N', "Wo ist der Kuehlschrank?", "de"), "where_is fridge");
  EXPECT_EQ(hear_in('N', "fuehre mich in die Kueche", "de"), "take_me_to kitchen");
  EXPECT_EQ(hear_in('N', "was ist neu", "de"), "what_changed") << "no umlaut";
  EXPECT_EQ(hear_in('N', "wo ist die Kueche", "en"), "not understood") << "of German alone";
}

TEST(DialogueTest, AWordAfterAnArticleIsANameThoughAPatternHasIt) {
  EXPECT_EQ(hear_in('N', "where is my watch"), "unknown: where_is watch");
  EXPECT_EQ(hear_in('N', "où est ma montre", "fr"), "unknown: where_is montre");
  EXPECT_EQ(hear_in('N', "I need to lie down"), "not understood");
}

TEST(DialogueTest, SpanishEnIsOnWhereNothingCanBeInIt) {
  EXPECT_EQ(hear_in('N', "qué hay en la mesa", "es"), "what_is_on table");
  EXPECT_EQ(hear_in('N', "qué hay en la nevera", "es"), "cannot tell");
}

}  // namespace
}  // namespace roomwise::guide
