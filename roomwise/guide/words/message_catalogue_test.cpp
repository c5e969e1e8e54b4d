#include "roomwise/guide/words/message_catalogue.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "roomwise/base/testing/testing.h"
#include "roomwise/rooms/concepts/concepts.h"

namespace roomwise::guide {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr int kMaxWords = 12;

int count_words(const std::string& text) {
  std::istringstream words(text);
  int count = 0;
  for (std::string word; words >> word;) ++count;
  return count;
}

// Values for every placeholder; the names are two words long, as few are.
Values some_values(const std::set<std::string>& names) {
  const std::map<std::string, std::variant<std::string, Nouns>> values{
      {"thing", thing("washing machine")},
      {"things", thing_list({"bed", "chair", "tv"})},
      {"goal", thing("washing machine")},
      {"place", thing("washing machine")},
      {"spot", thing("my chair")},
      {"spots", thing_list({"my chair", "reading corner"})},
      {"name", thing("washing machine")},
      {"names", room_list({"bedroom 1", "bedroom 2"})},
      {"rooms", room_list({"kitchen", "living room"})},
      {"area", "12 square metres"},
      {"width", "65 centimetres"},
      {"room", room("living room")},
      {"other", room("dining room")},
      {"via", room_list({"corridor"})},
      {"hour", "11"},
      {"count", "3"},
      {"distance", "12 steps"},
      {"steps", "14 steps"},
      {"turn", "Turn slightly right"},
      {"code", "1 2 3, 4 5 6"},
      {"day", "25"},
      {"month", "November"},
      {"year", "2026"},
      {"note", "Mind the step."},
      {"text", "The bed is in the bedroom."}};
  Values some;
  for (const std::string& name : names) {
    const auto found = values.find(name);
    EXPECT_NE(found, values.end()) << name;
    if (found != values.end()) some.insert(*found);
  }
  return some;
}

TEST(MessageCatalogueTest, SpeaksFourLanguages) {
  EXPECT_THAT(MessageCatalogue::built_in().languages(), ElementsAre("de", "en", "es", "fr"));
  EXPECT_FALSE(MessageCatalogue::built_in().speaks("it"));
  EXPECT_THROW((void)MessageCatalogue::built_in().in("it"), std::invalid_argument);
}

// That all languages have the same messages, values and words is checked by parse(), which
// built_in() goes through.
TEST(MessageCatalogueTest, LanguagesThatDifferAreRefused) {
  const auto refuses = [](const char* pointer, const nlohmann::json& value, const char* why) {
    std::vector<std::string> files;
    for (const std::string_view text : built_in_messages()) {
      nlohmann::json file = nlohmann::json::parse(text);
      if (file["language"] == "de") file[nlohmann::json::json_pointer(pointer)] = value;
      files.push_back(file.dump());
    }
    const std::vector<std::string_view> views(files.begin(), files.end());
    EXPECT_ERROR(MessageCatalogue::parse(views, {}), why);
  };
  refuses("/messages/neu", "Neu.", "message \"neu\" is in language \"de\", but not in \"en\"");
  refuses("/messages/room.is", "Sie sind da.",
          "the value of message \"room.is\" \"room\" is in language \"en\", but not in \"de\"");
  refuses("/rooms/Gewölbe", {{"name", "Gewölbe"}, {"class", "n"}}, "the word \"Gewölbe\"");
  refuses("/language", "en", "come twice");
  EXPECT_ERROR(MessageCatalogue::parse({}, {}), "no messages");
}

TEST(MessageCatalogueTest, EveryMessageIsShortAndASentence) {
  const MessageCatalogue catalogue = MessageCatalogue::built_in();
  for (const std::string& language : catalogue.languages()) {
    const Phrasebook& book = catalogue.in(language);
    for (const std::string& message : book.messages()) {
      const std::string text = book.text(message, some_values(book.values_of(message)));
      EXPECT_LE(count_words(text), kMaxWords) << text;
      EXPECT_THAT(text, ::testing::Not(HasSubstr("{"))) << message;
      EXPECT_THAT(text, ::testing::Not(HasSubstr("  "))) << message;
      // Turns are the beginnings of sentences.
      const bool is_turn = message.starts_with("route.") && !text.ends_with(".");
      EXPECT_TRUE(text.ends_with(".") || text.ends_with("?") || is_turn) << text;
    }
  }
}

TEST(MessageCatalogueTest, KnowsTheWordsOfANewHome) {
  const rooms::Concepts concepts = rooms::Concepts::standard();
  const MessageCatalogue catalogue = MessageCatalogue::built_in();
  for (const std::string& language : catalogue.languages()) {
    const auto things = catalogue.in(language).words(Noun::Kind::kThing);
    for (const objects::Kind& kind : objects::standard_kinds()) {
      EXPECT_THAT(things, Contains(kind.name)) << language;
    }
    const auto rooms = catalogue.in(language).words(Noun::Kind::kRoom);
    for (const auto& [type, objects] : concepts.objects_of_room_type) {
      EXPECT_THAT(rooms, Contains(type));
    }
  }
}

// A phone speaks these by itself, without words or numbers of the home.
TEST(MessageCatalogueTest, MessagesOfTheDeviceNeedNoValues) {
  const MessageCatalogue catalogue = MessageCatalogue::built_in();
  for (const std::string& message : catalogue.in("en").messages()) {
    if (message.starts_with("device.")) {
      EXPECT_TRUE(catalogue.in("en").values_of(message).empty()) << message;
    }
  }
}

}  // namespace
}  // namespace roomwise::guide
