#include "roomwise/guide/words/phrasebook.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "roomwise/base/testing/testing.h"
#include "roomwise/guide/words/message_catalogue.h"

namespace roomwise::guide {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class PhrasebookTest : public ::testing::Test {
 protected:
  const MessageCatalogue catalogue_ = MessageCatalogue::built_in();
  const Phrasebook& english_ = catalogue_.in("en");
  const Phrasebook& german_ = catalogue_.in("de");
  const Phrasebook& spanish_ = catalogue_.in("es");
  const Phrasebook& french_ = catalogue_.in("fr");
};

TEST_F(PhrasebookTest, SpanishAndFrenchAgreeAndElide) {
  EXPECT_EQ(spanish_.text("room.is", {{"room", room("kitchen")}}), "Está en la cocina.");
  EXPECT_EQ(spanish_.text("room.is", {{"room", room("bedroom 2")}}), "Está en el dormitorio 2.");
  EXPECT_EQ(spanish_.text("where.unknown", {{"thing", thing("bed")}}),
            "Aquí no conozco ninguna cama.");
  EXPECT_EQ(french_.text("room.is", {{"room", room("kitchen")}}), "Vous êtes dans la cuisine.");
  EXPECT_EQ(french_.text("room.is", {{"room", room("workshop")}}), "Vous êtes dans l'atelier.");
  EXPECT_EQ(french_.text("guide.far", {{"distance", "3 pas"}, {"goal", thing("wardrobe")}}),
            "3 pas jusqu'à l'armoire.");
  EXPECT_EQ(french_.text("where.no_room", {{"thing", thing("sink")}}),
            "Je ne sais pas où est l'évier.");
}

TEST_F(PhrasebookTest, NumbersAreCountedByTheRuleOfTheLanguage) {
  EXPECT_EQ(french_.count("metre", 0.5), "0,5 mètre");
  EXPECT_EQ(french_.count("metre", 1.5), "1,5 mètre");
  EXPECT_EQ(french_.count("metre", 2), "2 mètres");
  EXPECT_EQ(spanish_.count("metre", 0.5), "0,5 metros");
  EXPECT_EQ(spanish_.count("metre", 1), "un metro");
  const auto at_hour = [&](const char* hour) {
    return spanish_.text("guide.turn_hour_left", {{"hour", hour}});
  };
  EXPECT_EQ(at_hour("1"), "Gire a la una.");
  EXPECT_EQ(at_hour("3"), "Gire a las 3.");
}

// A voice reads "1 Schritt" as "eins Schritt", "1 paso" as "uno paso", "1 marche" as "un marche".
TEST_F(PhrasebookTest, OneIsWrittenInTheGenderOfItsWord) {
  EXPECT_EQ(german_.count("stair", 1), "eine Stufe");
  EXPECT_EQ(spanish_.count("step", 1), "un paso");
  EXPECT_EQ(spanish_.count("room", 1), "una habitación");
  EXPECT_EQ(french_.count("stair", 1), "une marche");
  EXPECT_EQ(french_.count("room", 0), "0 pièce");
  EXPECT_EQ(french_.text("guide.turn_hour_left", {{"hour", "1"}}), "Tournez à une heure.");
  EXPECT_EQ(german_.text("rooms.count", {{"count", german_.count("room", 1)}}),
            "Ich kenne einen Raum.");
}

TEST_F(PhrasebookTest, HoursAndDaysAreReadAsPeopleSayThem) {
  const auto at_hour = [&](const char* hour) {
    return german_.text("guide.turn_hour_left", {{"hour", hour}});
  };
  EXPECT_EQ(at_hour("1"), "Auf ein Uhr drehen.");
  EXPECT_EQ(at_hour("11"), "Auf 11 Uhr drehen.");
  const auto on_day = [&](const char* day) {
    return french_.text("where.seen_on", {{"day", day}, {"month", "mai"}});
  };
  EXPECT_EQ(on_day("1"), "Vu le 1er mai.");
  EXPECT_EQ(on_day("21"), "Vu le 21 mai.");
}

TEST_F(PhrasebookTest, SpanishAndDiffersBeforeItsOwnSound) {
  const auto near = [&](const char* last) {
    return spanish_.text("around.close", {{"things", thing_list({"bed", last})}});
  };
  EXPECT_EQ(near("chair"), "Muy cerca: cama y silla.");
  EXPECT_EQ(near("toilet"), "Muy cerca: cama e inodoro.");
  EXPECT_EQ(near("Hilo"), "Muy cerca: cama e Hilo.");
  EXPECT_EQ(near("hielera"), "Muy cerca: cama y hielera.");
}

TEST_F(PhrasebookTest, WhatIsLeftToWalkGoesWithOneStepAndWithMore) {
  for (const double steps : {1.0, 5.0}) {
    const bool is_one = steps == 1;
    const auto said = [&](const Phrasebook& book, const char* message) {
      return book.text(message, {{"distance", book.count("step", steps)},
                                 {"goal", thing("bed")},
                                 {"room", room("kitchen")},
                                 {"hour", "2"}});
    };
    EXPECT_EQ(said(german_, "guide.soon_hour"), is_one ? "Noch ein Schritt, dann auf 2 Uhr drehen."
                                                       : "Noch 5 Schritte, dann auf 2 Uhr drehen.");
    EXPECT_EQ(said(german_, "guide.soon_left"), is_one ? "Noch ein Schritt, dann links drehen."
                                                       : "Noch 5 Schritte, dann links drehen.");
    EXPECT_EQ(said(german_, "guide.soon_into"),
              is_one ? "Noch ein Schritt, dann sind Sie in der Küche."
                     : "Noch 5 Schritte, dann sind Sie in der Küche.");
    EXPECT_EQ(said(german_, "ahead.free"),
              is_one ? "Ich kenne nichts vor Ihnen. So weit weiß ich es: ein Schritt."
                     : "Ich kenne nichts vor Ihnen. So weit weiß ich es: 5 Schritte.");
    EXPECT_EQ(said(spanish_, "guide.begin"), is_one ? "Hasta la cama: aproximadamente un paso."
                                                    : "Hasta la cama: aproximadamente 5 pasos.");
    EXPECT_EQ(said(spanish_, "guide.more"), is_one ? "Bien, un paso más." : "Bien, 5 pasos más.");
  }
}

TEST_F(PhrasebookTest, WhatToDoAtAPlaceHasAVerb) {
  const Values values{{"distance", "3 pas"}, {"place", thing("door")}, {"hour", "10"}};
  EXPECT_EQ(french_.text("guide.soon_hour_at", values),
            "3 pas jusqu'à la porte, là, tournez à 10 heures.");
  EXPECT_EQ(french_.text("guide.soon_around_at", values),
            "3 pas jusqu'à la porte, là, faites demi-tour.");
  const Values in_spanish{{"distance", "3 pasos"}, {"place", thing("door")}, {"hour", "10"}};
  EXPECT_EQ(spanish_.text("guide.soon_hour_at", in_spanish),
            "3 pasos hasta la puerta, allí gire a las 10.");
  EXPECT_EQ(spanish_.text("guide.soon_left_at", in_spanish),
            "3 pasos hasta la puerta, allí gire a la izquierda.");
}

TEST_F(PhrasebookTest, TheNearestOfSeveralHasItsGender) {
  const auto told = [](const Phrasebook& book, const char* name) {
    return book.text("where.count", {{"count", "4"}, {"thing", thing(name)}});
  };
  EXPECT_EQ(told(spanish_, "door"), "Conozco 4 puertas. Era la puerta más cercana.");
  EXPECT_EQ(told(spanish_, "armchair"), "Conozco 4 sillones. Era el sillón más cercano.");
  EXPECT_EQ(told(french_, "door"), "J'en connais 4. C'était la porte la plus proche.");
  EXPECT_EQ(told(french_, "sink"), "J'en connais 4. C'était l'évier le plus proche.");
}

TEST_F(PhrasebookTest, FrenchToiletsAreMany) {
  const Nouns toilet = room("toilet");
  EXPECT_EQ(french_.text("guide.room_next", {{"goal", toilet}}), "Les toilettes sont à côté.");
  EXPECT_EQ(french_.text("guide.far", {{"distance", "5 pas"}, {"goal", toilet}}),
            "5 pas jusqu'aux toilettes.");
  EXPECT_EQ(french_.text("room.is", {{"room", toilet}}), "Vous êtes dans les toilettes.");
  EXPECT_EQ(french_.text("guide.room_next", {{"goal", room("kitchen")}}), "La cuisine est à côté.");
  EXPECT_EQ(french_.text("where.here", {{"thing", thing("toilet")}}),
            "La cuvette des toilettes est dans cette pièce.");
}

TEST_F(PhrasebookTest, WhatIsSaidOfManyOrOfAnyGenderFitsAll) {
  EXPECT_EQ(french_.text("ask.which_one", {{"names", room_list({"bedroom 1", "bedroom 2"})}}),
            "Je connais la chambre 1 et la chambre 2. Que choisissez-vous ?");
  EXPECT_EQ(french_.text("changed.gone",
                         {{"room", room("kitchen")}, {"things", thing_list({"bed", "chair"})}}),
            "Disparu dans la cuisine : lit et chaise.");
  EXPECT_EQ(spanish_.text("where.seen_yesterday"), "Según una imagen de ayer.");
  EXPECT_EQ(spanish_.text("changed.moved",
                          {{"room", room("kitchen")}, {"things", thing_list({"bed", "chair"})}}),
            "Cambio de sitio: cama y silla, ahora en la cocina.");
}

TEST_F(PhrasebookTest, WordsOfTheHomeTakeTheArticleOfTheirGender) {
  EXPECT_EQ(english_.text("room.is", {{"room", room("kitchen")}}), "You are in the kitchen.");
  EXPECT_EQ(german_.text("room.is", {{"room", room("kitchen")}}), "Sie sind in der Küche.");
  EXPECT_EQ(german_.text("room.is", {{"room", room("corridor")}}), "Sie sind im Flur.");
  EXPECT_EQ(german_.text("room.is", {{"room", room("balcony")}}), "Sie sind auf dem Balkon.");
  EXPECT_EQ(german_.text("where.unknown", {{"thing", thing("fridge")}}),
            "Ich kenne hier keinen Kühlschrank.");
  EXPECT_EQ(german_.text("where.unknown", {{"thing", thing("bed")}}), "Ich kenne hier kein Bett.");
  EXPECT_EQ(german_.text("where.through", {{"thing", thing("microwave")},
                                           {"room", room("kitchen")},
                                           {"via", room_list({"corridor", "hall"})}}),
            "Die Mikrowelle ist in der Küche, durch den Flur und die Diele.");
}

TEST_F(PhrasebookTest, NamesThatTheHelperGaveAreSpokenAsTheyAre) {
  EXPECT_EQ(english_.text("room.is", {{"room", room("Anna's room")}}), "You are in Anna's room.");
  EXPECT_EQ(english_.text("room.is", {{"room", room("boot room")}}), "You are in the boot room.");
  EXPECT_EQ(german_.text("room.is", {{"room", room("Annas Reich")}}),
            "Sie sind im Raum Annas Reich.");
  EXPECT_EQ(german_.text("where.unknown", {{"thing", thing("Staffelei")}}),
            "Ich kenne hier nichts namens Staffelei.");
  EXPECT_EQ(german_.text("where.count", {{"count", "3"}, {"thing", thing("Staffelei")}}),
            "Ich kenne 3 Dinge namens Staffelei. Das war das nächste namens Staffelei.");
  EXPECT_EQ(english_.text("around.close", {{"things", thing("{hour}")}}), "Close to you: {hour}.");
}

TEST_F(PhrasebookTest, ANameInTheSpeakersLanguageIsAKnownWord) {
  EXPECT_EQ(german_.text("room.is", {{"room", room("Küche")}}), "Sie sind in der Küche.");
  EXPECT_EQ(german_.text("room.is", {{"room", room("KÜCHE")}}), "Sie sind in der Küche.");
  EXPECT_EQ(english_.text("room.is", {{"room", room("Kitchen")}}), "You are in the kitchen.");
}

TEST_F(PhrasebookTest, NumberedRoomsKeepTheirGenderAndLoseEnglishArticles) {
  EXPECT_EQ(english_.text("room.is", {{"room", room("bedroom 2")}}), "You are in bedroom 2.");
  EXPECT_EQ(german_.text("room.is", {{"room", room("bedroom 2")}}), "Sie sind im Schlafzimmer 2.");
  EXPECT_EQ(german_.text("room.is", {{"room", room("balcony 2")}}), "Sie sind auf dem Balkon 2.");
  EXPECT_EQ(english_.text("room.is", {{"room", room("2")}}), "You are in the 2.");
}

TEST_F(PhrasebookTest, ListsAndFirstLetters) {
  EXPECT_EQ(english_.text("around.close", {{"things", thing_list({"bed"})}}), "Close to you: bed.");
  EXPECT_EQ(english_.text("around.close", {{"things", thing_list({"bed", "chair", "tv"})}}),
            "Close to you: bed, chair and TV.");
  EXPECT_EQ(german_.text("where.here", {{"thing", thing("ölbild")}}), "Ölbild ist in diesem Raum.");
}

TEST_F(PhrasebookTest, CountsAreInflected) {
  EXPECT_EQ(english_.count("step", 1), "1 step");
  EXPECT_EQ(english_.count("step", 3), "3 steps");
  EXPECT_EQ(english_.count("metre", 1.5), "1.5 metres");
  EXPECT_EQ(english_.count("metre", 0.98), "1 metre");
  EXPECT_EQ(german_.count("metre", 2.5), "2,5 Meter");
  EXPECT_EQ(german_.count("step", 1), "ein Schritt");
}

TEST_F(PhrasebookTest, MonthsHaveNames) {
  EXPECT_EQ(english_.month(1), "January");
  EXPECT_EQ(german_.month(12), "Dezember");
}

TEST_F(PhrasebookTest, FindsWhatSomebodyMeansByItsNames) {
  EXPECT_THAT(english_.words_for(Noun::Kind::kThing, "Couch"), ElementsAre("sofa"));
  EXPECT_THAT(english_.words_for(Noun::Kind::kThing, "oven"), ElementsAre("oven", "stove"));
  EXPECT_THAT(german_.words_for(Noun::Kind::kThing, "ÖFEN"), IsEmpty());
  EXPECT_THAT(german_.words_for(Noun::Kind::kThing, "BACKÖFEN"), ElementsAre("oven"));
  EXPECT_THAT(german_.words_for(Noun::Kind::kRoom, "badezimmer"), ElementsAre("bathroom"));
  EXPECT_THAT(german_.words_for(Noun::Kind::kThing, "badezimmer"), IsEmpty());
}

TEST_F(PhrasebookTest, AMissingValueOrMessageIsABug) {
  EXPECT_THROW((void)english_.text("room.is"), std::invalid_argument);
  EXPECT_THROW((void)english_.text("room.was"), std::invalid_argument);
}

// A smallest file, to be spoiled.
nlohmann::json small_file() {
  nlohmann::json file =
      nlohmann::json::parse(R"({"language": "xx", "name": "X", "messages": {"a": "{the thing}!"},
    "counts": {"step": {"one": "1", "other": "{n}"}}, "singular": "1", "decimal": ".", "and": "&",
    "months": ["1", "2", "3", "4", "5", "6", "7", "8", "9", "10", "11", "12"],
    "forms": {"the": {"c": "le {}", "proper": "{}", "other": "{}"}},
    "rooms": {"hall": {"name": "gang", "class": "c"}}, "goals": {}})");
  file["questions"] = nlohmann::json::parse(built_in_messages()[0])["questions"];
  return file;
}

TEST(PhrasebookFileTest, SaysWhatIsWrong) {
  EXPECT_OK(Phrasebook::parse(small_file().dump(), {}));
  EXPECT_ERROR(Phrasebook::parse("{", {}), "parse error");
  EXPECT_ERROR(Phrasebook::parse("{}", {}), "'language' not found");
  const auto spoiled = [](const char* pointer, const nlohmann::json& value) {
    nlohmann::json file = small_file();
    file[nlohmann::json::json_pointer(pointer)] = value;
    return Phrasebook::parse(file.dump(), {});
  };
  EXPECT_ERROR(spoiled("/messages/a", 7), "must be string");
  EXPECT_ERROR(spoiled("/messages/a", "{the thing"), "message \"a\": a brace is not closed");
  EXPECT_ERROR(spoiled("/messages/a", "{las thing}"), "message \"a\": there is no form \"las\"");
  EXPECT_ERROR(spoiled("/forms/the", {{"c", "{}"}, {"other", "{}"}}), "lacks \"proper\"");
  EXPECT_ERROR(spoiled("/forms/the/c", "le"), "form \"the\", \"c\": there is no {}");
  EXPECT_ERROR(spoiled("/counts/step", {{"one", "1"}}), "count \"step\" lacks");
  EXPECT_ERROR(spoiled("/singular", "2"), "singular is \"2\"; expected \"1\" or \"below 2\"");
  EXPECT_ERROR(spoiled("/questions/endings", 1), "questions:");
  EXPECT_ERROR(spoiled("/months", {"January"}), "months: expected twelve names");
  EXPECT_ERROR(spoiled("/months/11", ""), "months: expected twelve names");
  EXPECT_ERROR(spoiled("/rooms/hall/class", "q"), "word \"hall\": neither it nor its class \"q\"");
  EXPECT_ERROR(spoiled("/rooms/hall/la", "la gang"), "there is no form \"la\"");
}

TEST(PhrasebookFileTest, ThingsAreCalledAsTheirKindsSay) {
  objects::Kind bed, unnamed;
  bed.name = "bed";
  bed.called["xx"] = {"bett", "c", {}, {"lager"}};
  unnamed.name = "rug";
  const auto book = Phrasebook::parse(small_file().dump(), std::vector{bed, unnamed});
  ASSERT_OK(book);
  EXPECT_EQ(book->text("a", {{"thing", thing("bed")}}), "Le bett!");
  EXPECT_EQ(book->text("a", {{"thing", thing("rug")}}), "Rug!") << "nobody gave it a name here";
  EXPECT_THAT(book->words_for(Noun::Kind::kThing, "Lager"), ElementsAre("bed"));
  bed.called["xx"].word_class = "q";
  EXPECT_ERROR(Phrasebook::parse(small_file().dump(), std::vector{bed}), "word \"bed\": neither");
}

}  // namespace
}  // namespace roomwise::guide
