#include "roomwise/guide/questions/understand.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/guide/grammar/folded_words.h"
#include "roomwise/guide/words/message_catalogue.h"

namespace roomwise::guide {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using Outcome = Understood::Outcome;
using Type = QuestionType;

const MessageCatalogue& catalogue() {
  static const MessageCatalogue built_in = MessageCatalogue::built_in();
  return built_in;
}

HomeNames some_home() {
  return {
      .things = {"Anna's chair", "bed", "cup", "keys", "microwave", "oven", "stove", "table"},
      .rooms = {"bedroom 1", "bedroom 2", "children's room", "kitchen", "living room", "toilet"},
      .goals = {"door"},
      .spots = {"reading corner"},
      .vocabulary = nullptr};
}

Understood hear(const std::string& text, const std::string& language = "en") {
  return understand(text, catalogue().in(language), some_home());
}

std::vector<std::string> names_of(const Understood& heard) {
  std::vector<std::string> names;
  for (const Noun& noun : heard.names) names.push_back(noun.name);
  return names;
}

// "where_is keys", "take_me_to kitchen", "which one: ...".
std::string told(const Understood& heard) {
  std::string text;
  switch (heard.outcome) {
    case Outcome::kQuestion:
      break;
    case Outcome::kWhichOne:
      text = "which one: ";
      break;
    case Outcome::kWhichRoom:
      text = "which room: ";
      break;
    case Outcome::kWhichDoor:
      text = "which door: ";
      break;
    case Outcome::kDidYouMean:
      text = "did you mean: ";
      break;
    case Outcome::kUnknownName:
      text = "unknown: ";
      break;
    case Outcome::kCannotTell:
      return "cannot tell";
    case Outcome::kDeclined:
      return "declined";
    case Outcome::kNotUnderstood:
      return "not understood";
  }
  text += std::ranges::find(kQuestionTypes, heard.type, [](const auto& one) {
            return one.second;
          })->first;
  for (const std::string& name : names_of(heard)) text += " " + name;
  for (const Noun& room : heard.rooms) text += " in " + room.name;
  return text;
}

std::string english(const std::string& text) {
  return told(hear(text));
}
std::string german(const std::string& text) {
  return told(hear(text, "de"));
}

TEST(UnderstandTest, QuestionsInEnglish) {
  EXPECT_EQ(english("Where did I leave my keys?"), "where_is keys");
  EXPECT_EQ(english("where is the key"), "where_is keys");
  EXPECT_EQ(english("bring me to the loo"), "take_me_to toilet");
  EXPECT_EQ(english("What is on the table?"), "what_is_on table");
  EXPECT_EQ(english("what's on the table"), "what_is_on table");
  EXPECT_EQ(english("Is the window open?"), "cannot tell");
  EXPECT_EQ(english("is somebody in the room"), "who_is_here");
  EXPECT_EQ(english("is somebody in the kitchen"), "cannot tell") << "the camera is here";
  EXPECT_EQ(english("Where am I?"), "where_am_i");
  EXPECT_EQ(english("please, can you tell me where the microwave is"), "where_is microwave");
  EXPECT_EQ(english("whats in the kitchen"), "what_is_in kitchen");
  EXPECT_EQ(english("Which rooms are there"), "which_rooms");
  EXPECT_EQ(english("which way do I face"), "which_way");
  EXPECT_EQ(english("what is ahead of me"), "what_is_ahead");
  EXPECT_EQ(english("describe this room"), "describe_room");
  EXPECT_EQ(english("describe the kitchen"), "describe_room kitchen");
  EXPECT_EQ(english("how far is it to the bed"), "where_is bed");
  EXPECT_EQ(english("how far is the wall"), "what_is_ahead");
  EXPECT_EQ(english("take me to the door"), "take_me_to door");
  EXPECT_EQ(english("where is the door"), "where_is door");
  EXPECT_EQ(english("the way to the kitchen"), "take_me_to kitchen");
  EXPECT_EQ(english("the way to the bed"), "way_to bed");
  EXPECT_EQ(english("which is the way to the bed"), "way_to bed");
  EXPECT_EQ(english("which is the way to the kitchen"), "take_me_to kitchen");
  EXPECT_EQ(english("repeat that"), "repeat");
  EXPECT_EQ(english("stop"), "end");
}

TEST(UnderstandTest, TheWayOutIsAskedForWithoutANameInEveryLanguage) {
  const auto means_out = [](const std::string& language, const std::string& text) {
    EXPECT_EQ(told(hear(text, language)), "take_me_out") << text;
  };
  for (const char* text : {"take me out", "How do I get out of here?", "I want to go outside",
                           "I need to get out of the flat", "which way is out"}) {
    means_out("en", text);
  }
  for (const char* text : {"Bring mich raus!", "wie komme ich hier raus", "Ich möchte nach draußen",
                           "Wo geht es hinaus?", "können Sie mich hinausführen"}) {
    means_out("de", text);
  }
  for (const char* text : {"sácame de aquí", "¿Cómo salgo?", "quiero salir a la calle",
                           "¿Por dónde se sale?", "llévame fuera"}) {
    means_out("es", text);
  }
  for (const char* text : {"emmène-moi dehors", "Comment sortir d'ici ?", "je voudrais sortir",
                           "par où sort-on", "faites-moi sortir"}) {
    means_out("fr", text);
  }
}

TEST(UnderstandTest, TheWayOutHasNamesInEveryLanguage) {
  HomeNames home = some_home();
  home.goals.emplace_back("way out");
  const auto leads_out = [&](const std::string& language, const std::string& text) {
    EXPECT_EQ(told(understand(text, catalogue().in(language), home)), "take_me_to way out") << text;
  };
  leads_out("en", "Take me to the way out");
  leads_out("en", "bring me to the exit");
  leads_out("en", "how do I get to the front door");
  leads_out("de", "Bring mich zum Ausgang");
  leads_out("de", "führe mich zur Haustür");
  leads_out("es", "llévame a la salida");
  leads_out("fr", "emmène-moi à la sortie");
}

TEST(UnderstandTest, QuestionsInGerman) {
  EXPECT_EQ(german("Wo habe ich denn meine Tasse hingestellt?"), "where_is cup");
  EXPECT_EQ(german("Bring mich bitte zum Klo!"), "take_me_to toilet");
  EXPECT_EQ(german("Was liegt auf dem Tisch?"), "what_is_on table");
  EXPECT_EQ(german("finde den Tisch"), "where_is table");
  EXPECT_EQ(german("Wo sind die Tische?"), "where_is table");
  EXPECT_EQ(german("Ist das Fenster offen?"), "cannot tell");
  EXPECT_EQ(german("führ mich in die Küche"), "take_me_to kitchen");
  EXPECT_EQ(german("FUEHRE mich in die KUCHE"), "take_me_to kitchen") << "a slip is forgiven";
  EXPECT_EQ(german("Wie groß ist die Küche?"), "describe_room kitchen");
  EXPECT_EQ(german("welche Räume gibt es"), "which_rooms");
  EXPECT_EQ(german("Weißt du, wo die Mikrowelle ist?"), "where_is microwave");
  EXPECT_EQ(german("Was kann ich fragen?"), "what_can_i_ask");
}

TEST(UnderstandTest, QuestionsInSpanish) {
  const auto spanish = [](const std::string& text) { return told(hear(text, "es")); };
  EXPECT_EQ(spanish("¿Dónde he dejado mi taza?"), "where_is cup");
  EXPECT_EQ(spanish("donde esta la mesa"), "where_is table") << "typed without accents";
  EXPECT_EQ(spanish("Llévame al aseo, por favor"), "take_me_to toilet");
  EXPECT_EQ(spanish("¿Qué hay encima de la mesa?"), "what_is_on table");
  EXPECT_EQ(spanish("qué tan grande es el cuarto"), "describe_room");
  EXPECT_EQ(spanish("¿Está abierta la ventana?"), "cannot tell");
  EXPECT_EQ(spanish("¿Qué hay en la cocina?"), "what_is_in kitchen");
}

TEST(UnderstandTest, QuestionsInFrench) {
  const auto french = [](const std::string& text) { return told(hear(text, "fr")); };
  EXPECT_EQ(french("Où ai-je posé ma tasse ?"), "where_is cup");
  EXPECT_EQ(french("ou est la table"), "where_is table") << "typed without accents";
  EXPECT_EQ(french("Emmène-moi jusqu’à la cuisine, s’il te plaît"), "take_me_to kitchen");
  EXPECT_EQ(french("Qu'y a-t-il sur la table ?"), "what_is_on table");
  EXPECT_EQ(french("La fenêtre est-elle ouverte ?"), "cannot tell");
  EXPECT_EQ(french("où est l'ordinateur"), "unknown: where_is computer");
}

// What people who cannot see ask of a home, each in the words of every language.
TEST(UnderstandTest, WhatPeopleAskOfAHomeIsUnderstoodInEveryLanguage) {
  const std::map<std::string, std::vector<std::string>> asked{
      {"what_is_on table",
       {"en:what is on this table", "en:what's lying on the table", "de:was ist auf diesem Tisch",
        "de:was steht auf dem Tisch", "es:qué hay sobre esta mesa", "es:qué hay encima de la mesa",
        "fr:qu'y a-t-il sur cette table", "fr:il y a quoi sur la table"}},
      {"who_is_here",
       {"en:is somebody in the room", "en:is anybody here", "en:am I alone",
        "en:is there anyone else in this room", "de:ist jemand im Raum", "de:ist hier jemand",
        "de:bin ich allein", "es:hay alguien en la habitación", "es:hay alguien aquí",
        "es:estoy sola", "fr:y a-t-il quelqu'un dans la pièce", "fr:il y a quelqu'un",
        "fr:suis-je seul"}},
      {"is_it_light",
       {"en:which light is on", "en:is the light on", "en:is it dark in here",
        "de:welches Licht ist an", "de:brennt das Licht", "de:ist es hier dunkel",
        "es:qué luz está encendida", "es:está encendida la luz", "es:está oscuro",
        "fr:quelle lumière est allumée", "fr:la lumière est-elle allumée", "fr:fait-il sombre"}},
      {"show_walks",
       {"en:show my walk to my helper", "en:let my helper watch",
        "de:zeige meiner Hilfe meinen Weg", "de:meine Hilfe darf zusehen",
        "es:muestra mi recorrido a quien me ayuda", "es:quien me ayuda puede mirar",
        "fr:montre mon trajet à mon aide", "fr:mon aide peut regarder"}},
      {"hide_walks",
       {"en:hide my walk", "en:do not share my walk", "en:stop watching me",
        "de:zeige meinen Weg nicht mehr", "de:niemand soll zusehen", "de:nicht zusehen",
        "es:oculta mi recorrido", "es:no compartas mi recorrido", "es:que nadie mire",
        "fr:cache mon trajet", "fr:ne montrez plus mon trajet", "fr:personne ne doit regarder"}},
      {"what_changed",
       {"en:what changed here", "en:what has changed", "de:was hat sich hier verändert",
        "de:was ist neu", "es:qué ha cambiado aquí", "es:qué ha cambiado",
        "fr:qu'est-ce qui a changé ici", "fr:qu'est-ce qui a changé"}},
      {"what_is_ahead",
       {"en:how far is the wall",
        "en:what is ahead",
        "en:how far is it to the wall",
        "de:wie weit ist die Wand",
        "de:was ist vor mir",
        "de:wie weit ist es bis zur Wand",
        "es:a qué distancia está la pared",
        "es:qué hay delante",
        "es:cuánto falta hasta la pared",
        "fr:à quelle distance est le mur",
        "fr:qu'y a-t-il devant moi",
        "fr:quelle est la distance jusqu'au mur",
        "en:what is in the way",
        "en:what's in my way",
        "en:is there something in the way",
        "de:was steht im Weg",
        "de:was ist da im Weg",
        "es:qué hay en el camino",
        "es:qué bloquea el camino",
        "fr:qu'y a-t-il sur le chemin",
        "fr:qu'est-ce qui bloque le passage",
        "fr:y a-t-il quelque chose devant moi"}},
      {"something_ahead",
       {"en:there is something in front of me", "en:there's an obstacle in the way",
        "de:vor mir steht etwas", "de:da ist etwas im Weg", "es:hay algo delante",
        "es:¿Hay algo delante de mí?", "es:hay un obstáculo en el camino",
        "fr:il y a quelque chose devant moi", "fr:il y a un obstacle sur le chemin"}},
      {"blocked",
       {"en:I am stuck", "en:I'm stuck", "en:something is in my way", "en:I can't go on",
        "de:ich stecke fest", "de:ich komme hier nicht weiter", "de:ich kann nicht weiter",
        "es:estoy atascada", "es:me he quedado atrapado", "es:no puedo avanzar",
        "fr:je suis coincé", "fr:je suis bloquée", "fr:je ne peux plus avancer"}},
      {"how_far",
       {"en:how far is it still", "en:how far is it", "en:how far is it to go", "en:how far still",
        "de:wie weit ist es noch", "de:wie weit muss ich noch", "es:cuánto falta todavía",
        "es:¿A qué distancia está?", "fr:c'est encore loin", "fr:est-ce encore loin"}},
      {"what_is_in kitchen",
       {"en:what is in the kitchen", "de:was ist in der Küche", "es:qué hay en la cocina",
        "fr:qu'y a-t-il dans la cuisine"}},
      {"which_rooms",
       {"en:which rooms are there", "de:welche Räume gibt es", "de:welche Zimmer gibt es hier",
        "es:qué habitaciones hay", "fr:quelles pièces y a-t-il"}},
      {"which_way",
       {"en:which way do I face", "en:which way am I facing", "de:wohin schaue ich",
        "de:in welche Richtung schaue ich", "es:hacia dónde miro", "es:en qué dirección miro",
        "fr:dans quelle direction je regarde", "fr:vers où je regarde"}},
      {"describe_room",
       {"en:describe this room", "de:beschreibe diesen Raum", "es:describe esta habitación",
        "fr:décris cette pièce"}},
      {"cannot tell",
       {"en:is the window open", "de:ist das Fenster offen", "es:está abierta la ventana",
        "fr:la fenêtre est-elle ouverte"}},
  };
  for (const auto& [meaning, texts] : asked) {
    for (const std::string& text : texts) {
      EXPECT_EQ(told(hear(text.substr(3), text.substr(0, 2))), meaning) << text;
    }
  }
}

// The same words ask in some languages, and tell in all.
TEST(UnderstandTest, WhoIsLedAndTellsOfSomethingAheadCannotGoOn) {
  for (const auto& [language, text] :
       {std::pair("en", "there is something ahead"), std::pair("de", "da ist etwas im Weg"),
        std::pair("es", "hay algo delante"), std::pair("fr", "il y a quelque chose devant moi")}) {
    EXPECT_EQ(told(while_led(hear(text, language))), "blocked") << text;
  }
  EXPECT_EQ(told(while_led(hear("what is ahead"))), "what_is_ahead");
  EXPECT_EQ(told(while_led(hear("where is the bed"))), "where_is bed");
}

// "en:stop stop" and who is led hears it.
std::string told_while_led(const std::string& text) {
  const std::string language = text.substr(0, 2);
  const std::string said = text.substr(3);
  return told(
      while_led(unless_stopped(hear(said, language), said, catalogue().in(language), some_home())));
}

TEST(UnderstandTest, WhoIsLedStopsInWhateverWords) {
  for (const char* text : {"en:stop",
                           "en:stop stop",
                           "en:stop stop stop",
                           "en:no stop",
                           "en:stop walking",
                           "en:please stop now",
                           "en:I want to stop",
                           "en:enough",
                           "en:halt",
                           "en:quit",
                           "en:cancel that",
                           "en:thanks that is enough",
                           "en:I don't want to go there",
                           "en:forget it",
                           "en:never mind",
                           "en:my dear stop at once",
                           "en:whoa stop",
                           "de:stopp stopp",
                           "de:halt stopp",
                           "de:anhalten",
                           "de:bleib stehen",
                           "de:stehen bleiben",
                           "de:aufhören",
                           "de:ich will nicht mehr",
                           "de:genug",
                           "de:hör auf damit",
                           "de:ich will da nicht hin",
                           "de:danke das reicht",
                           "de:vergiss es",
                           "de:du sollst stopp machen",
                           "es:para para",
                           "es:detente",
                           "es:deténgase",
                           "es:párate",
                           "es:stop",
                           "es:frena",
                           "es:ya basta",
                           "es:basta ya",
                           "es:ya no quiero",
                           "es:no quiero ir allí",
                           "es:déjalo",
                           "es:olvídalo",
                           "es:no para",
                           "fr:arrête-toi",
                           "fr:arrêtez-vous",
                           "fr:arrête tout",
                           "fr:halte",
                           "fr:ça suffit",
                           "fr:assez",
                           "fr:stop stop",
                           "fr:je ne veux plus",
                           "fr:je ne veux pas y aller",
                           "fr:laisse tomber",
                           "fr:merci ça suffit",
                           "fr:mais arrête donc un peu"}) {
    EXPECT_EQ(told_while_led(text), "end") << text;
  }
  for (const char* text :
       {"en:wait wait", "en:hang on a second", "en:hold on please", "en:would you wait for me",
        "de:warte warte", "de:einen Augenblick", "de:Moment mal", "es:espera espera", "es:espérate",
        "es:un momentito", "fr:attends attends", "fr:un instant", "fr:une seconde",
        "en:do not ever stop", "de:jetzt nicht anhalten du", "fr:n'arrête surtout pas"}) {
    EXPECT_EQ(told_while_led(text), "pause") << text;
  }
  EXPECT_EQ(told_while_led("en:where did the tram stop"), "end") << "rather than walk on";
  EXPECT_EQ(told_while_led("en:what does it say at the stop in the kitchen"), "not understood");
  EXPECT_EQ(told_while_led("en:where is the bed"), "where_is bed");
}

TEST(UnderstandTest, WhoIsLedPausesByAStopWithAThingsName) {
  for (const char* text : {"en:Stop, the table!", "de:Stopp, die Tür ist zu", "de:halt, ein Tisch",
                           "fr:stop, la table"}) {
    EXPECT_EQ(told_while_led(text), "pause") << text;
  }
  HomeNames home = some_home();
  home.spots.emplace_back("bus stop");
  const std::string text = "oh my bus stop";
  const Understood said = understand(text, catalogue().in("en"), home);
  EXPECT_EQ(told(unless_stopped(said, text, catalogue().in("en"), home)), told(said))
      << "a place of that name";
}

TEST(UnderstandTest, AWordOfTheLanguageIsNoNameWithASlip) {
  HomeNames home = some_home();
  home.things.emplace_back("flower");
  home.rooms.emplace_back("hall");
  const auto said = [&](const std::string& text, const std::string& language) {
    return told(understand(text, catalogue().in(language), home));
  };
  EXPECT_EQ(said("halt", "en"), "end");
  EXPECT_EQ(said("hall", "en"), "named hall");
  EXPECT_EQ(english("hall"), "unknown: named hall") << "not halt with a slip";
  EXPECT_EQ(said("quit", "en"), "end");
  EXPECT_EQ(said("hallo", "de"), "not understood") << "and no Diele";
}

TEST(UnderstandTest, EmergenciesAreHeardAndNeverBySlips) {
  const std::map<std::string, std::vector<std::string>> asked{
      {"help",
       {"en:help", "en:help me!", "en:help help", "de:Hilfe", "de:hilf mir", "es:ayuda",
        "es:¡Socorro!", "fr:à l'aide", "fr:au secours", "fr:aidez-moi"}},
      {"emergency",
       {"en:I fell",
        "en:I've fallen",
        "en:call the ambulance",
        "en:call an ambulance",
        "en:fire",
        "en:it smells of gas",
        "en:I smell gas",
        "en:call my daughter",
        "en:I'm hurt",
        "en:I can't get up",
        "de:ich bin gestürzt",
        "de:ruf den Notarzt",
        "de:es brennt",
        "de:es riecht nach Gas",
        "de:ruf meine Tochter an",
        "de:ich habe mich verletzt",
        "es:me caí",
        "es:llama a una ambulancia",
        "es:fuego",
        "es:huele a gas",
        "es:llama a mi hija",
        "es:me duele mucho",
        "fr:je suis tombé",
        "fr:je suis tombée",
        "fr:appelle une ambulance",
        "fr:au feu",
        "fr:ça sent le gaz",
        "fr:appelle ma fille",
        "fr:je me suis fait mal"}},
      {"take_me_out",
       {"en:way out", "en:the exit", "en:fire! how do I get out", "de:Ausgang",
        "de:es brennt wie komme ich raus", "es:salida", "es:hay fuego cómo salgo", "fr:sortie",
        "fr:au feu comment sortir"}},
  };
  for (const auto& [meaning, texts] : asked) {
    for (const std::string& text : texts) {
      EXPECT_EQ(told(hear(text.substr(3), text.substr(0, 2))), meaning) << text;
    }
  }
  EXPECT_NE(english("halp"), "help");
  EXPECT_NE(english("I feel"), "emergency");
}

TEST(UnderstandTest, AWordForAnyRoomIsTheNameOfNone) {
  const std::string which =
      "which one: take_me_to bedroom 1 bedroom 2 children's room kitchen living room toilet";
  for (const char* text :
       {"en:bring me to my room", "de:bring mich in mein Zimmer", "es:quiero ir a mi cuarto",
        "es:llévame a la habitación", "fr:emmène-moi dans la pièce"}) {
    const std::string said = text;
    EXPECT_EQ(told(hear(said.substr(3), said.substr(0, 2))), which) << text;
  }
  EXPECT_EQ(told(in_answer_to(hear("bring me to my room"), hear("the kitchen"))),
            "take_me_to kitchen");
  HomeNames home = some_home();
  home.rooms = {"Anna's room", "my room"};
  EXPECT_EQ(told(understand("take me to my room", catalogue().in("en"), home)),
            "take_me_to my room");
}

TEST(UnderstandTest, RoomsStandForEachOtherWhereTheHomeHasOneOfThem) {
  HomeNames home = some_home();
  home.rooms = {"hall", "kitchen", "living room", "toilet"};
  const auto said = [&](const std::string& text) {
    return told(understand(text.substr(3), catalogue().in(text.substr(0, 2)), home));
  };
  for (const char* text :
       {"en:take me to the hallway", "en:take me to the corridor", "de:bring mich auf den Gang",
        "de:bring mich in den Flur", "es:llévame al pasillo", "es:llévame a la entrada",
        "fr:emmène-moi dans le couloir", "fr:emmène-moi dans l'entrée"}) {
    EXPECT_EQ(said(text), "take_me_to hall") << text;
  }
  EXPECT_EQ(said("en:take me to the lounge"), "take_me_to living room");
  EXPECT_EQ(said("es:llévame a la sala"), "take_me_to living room");
  EXPECT_EQ(said("en:take me to the bathroom"), "take_me_to toilet");
  EXPECT_EQ(said("es:dónde está el baño"), "where_is toilet");
  home.rooms.emplace_back("entrance");
  EXPECT_EQ(said("en:take me to the corridor"), "unknown: take_me_to corridor") << "which?";
}

TEST(UnderstandTest, WordsOfARegionNameWhatTheHomeHas) {
  HomeNames home = some_home();
  home.things = {"fridge", "sofa", "stove", "wardrobe"};
  home.rooms = {"bedroom"};
  home.goals = {"way out"};
  const std::map<std::string, std::vector<std::string>> asked{
      {"where_is fridge",
       {"de:wo ist der Eisschrank", "es:dónde está la heladera", "es:dónde está el refri",
        "fr:où est le frigidaire"}},
      {"where_is sofa", {"de:wo ist das Kanapee", "es:dónde está el sillón"}},
      {"where_is stove", {"es:dónde está la estufa", "fr:où sont les plaques"}},
      {"where_is wardrobe", {"de:wo ist der Kasten", "es:dónde está el armario"}},
      {"take_me_to bedroom", {"es:llévame a la recámara"}},
      {"where_is way out",
       {"en:where is the exit, quick", "en:where is the main door", "de:wo ist der Ausgang schnell",
        "es:dónde está la salida rápido", "es:dónde está la puerta de la calle",
        "es:dónde está la puerta de entrada", "fr:où est la sortie vite"}}};
  for (const auto& [meaning, texts] : asked) {
    for (const std::string& text : texts) {
      const auto& phrases = catalogue().in(text.substr(0, 2));
      EXPECT_EQ(told(understand(text.substr(3), phrases, home)), meaning) << text;
    }
  }
}

TEST(UnderstandTest, WhatIsLeftOfASentenceIsNoName) {
  for (const char* text : {"en:I need to lie down", "es:hay algo raro",
                           "fr:où est-ce que je peux aller", "de:ich suche was ich fragen kann"}) {
    const std::string said = text;
    EXPECT_EQ(told(hear(said.substr(3), said.substr(0, 2))), "not understood") << text;
  }
}

TEST(UnderstandTest, PoliteAndLostPeopleAreUnderstood) {
  const std::map<std::string, std::vector<std::string>> asked{
      {"take_me_to kitchen",
       {"de:könntest du mich bitte in die Küche bringen", "de:wie geht's zur Küche",
        "es:podrías llevarme a la cocina", "es:me llevas a la cocina",
        "fr:tu peux m'emmener à la cuisine", "fr:pourriez-vous me conduire à la cuisine",
        "en:could you please bring me over to the kitchen",
        "en:take me to the kitchen and then to the toilet",
        "de:bring mich in die Küche und dann ins Bad"}},
      {"where_am_i",
       {"en:excuse me, can you please tell me where I am right now", "en:I'm lost",
        "en:I don't know where I am", "en:where am I and what is in front of me",
        "de:ich hab mich verlaufen", "de:ich weiß nicht, wo ich bin", "es:estoy perdida",
        "es:no sé dónde estoy", "fr:je suis perdu", "fr:où est-ce que je me trouve"}},
      {"where_am_i kitchen",
       {"en:am I in the kitchen", "de:bin ich in der Küche", "es:estoy en la cocina",
        "fr:suis-je dans la cuisine"}},
      {"settings",
       {"en:slower", "en:speak louder please", "en:be quiet", "en:in steps please", "de:langsamer",
        "de:sprich lauter bitte", "de:sei still", "de:in Schritten bitte", "es:más despacio",
        "es:más alto por favor", "es:silencio", "fr:moins vite", "fr:plus fort s'il te plaît",
        "fr:tais-toi"}},
      {"where_is microwave", {"en:where is the microwave and where is the bed"}},
      {"emergency", {"en:I've fallen and I can't find my way up"}},
  };
  for (const auto& [meaning, texts] : asked) {
    for (const std::string& text : texts) {
      EXPECT_EQ(told(hear(text.substr(3), text.substr(0, 2))), meaning) << text;
    }
  }
}

TEST(UnderstandTest, AnOfferIsAnsweredByItsPlaceOrByNo) {
  const Understood rooms = which_room(hear("take me to the table"), {"kitchen", "living room"});
  const Understood doors =
      which_door(hear("take me to the kitchen door"), {"living room", "toilet"});
  const Understood names = hear("take me to the bedroom");
  const std::map<std::string, std::vector<std::string>> seconds{
      {"en", {"the second one", "second"}},
      {"de", {"das zweite", "die zweite"}},
      {"es", {"la segunda", "el segundo"}},
      {"fr", {"le deuxième", "la seconde"}}};
  for (const auto& [language, texts] : seconds) {
    for (const std::string& text : texts) {
      const Understood said = hear(text, language);
      EXPECT_EQ(told(in_answer_to(rooms, said)), "take_me_to table in living room") << text;
      EXPECT_EQ(told(in_answer_to(names, said)), "take_me_to bedroom 2") << text;
      EXPECT_EQ(told(in_answer_to(doors, said)), "take_me_to door in kitchen in toilet") << text;
    }
  }
  EXPECT_EQ(told(in_answer_to(rooms, hear("the third one"))), told(rooms)) << "there are two";
  EXPECT_EQ(told(in_answer_to({}, hear("the second one"))), "second");
  for (const auto& [language, text] :
       {std::pair("en", "the nearest"), std::pair("de", "der nächste"),
        std::pair("es", "la más cercana"), std::pair("fr", "la plus proche")}) {
    const Understood nearest = in_answer_to(rooms, hear(text, language));
    EXPECT_EQ(told(nearest), "take_me_to table") << text;
    EXPECT_TRUE(nearest.is_nearest);
  }
  const Understood near = hear("take me to the kichen");
  for (const auto& [language, text] : {std::pair("en", "no"), std::pair("de", "nein danke"),
                                       std::pair("es", "no"), std::pair("fr", "non")}) {
    EXPECT_EQ(told(in_answer_to(near, hear(text, language))), "declined") << text;
  }
  EXPECT_EQ(told(in_answer_to({}, hear("no"))), "no");
}

TEST(UnderstandTest, WhatFollowsAQuestionMeansItsName) {
  const Understood last = hear("where is the table in the kitchen");
  for (const char* text : {"en:take me there", "de:bring mich hin", "de:bring mich dahin",
                           "es:llévame ahí", "es:llévame", "fr:emmène-moi là-bas"}) {
    const std::string said = text;
    const Understood heard = hear(said.substr(3), said.substr(0, 2));
    EXPECT_EQ(told(following(last, heard)), "take_me_to table in kitchen") << text;
    EXPECT_EQ(told(following({}, heard)), "there") << text;
  }
  EXPECT_EQ(told(following(last, hear("how far is it"))), "where_is table in kitchen");
  for (const char* text : {"en:and the bed", "de:und das Bett", "es:y la cama", "fr:et le lit"}) {
    const std::string said = text;
    EXPECT_EQ(told(following(last, hear(said.substr(3), said.substr(0, 2)))), "where_is bed");
  }
  EXPECT_EQ(told(following(last, hear("where am I"))), "where_am_i");
}

TEST(UnderstandTest, ThingsThatWereTaughtAreKnownByTheirNames) {
  HomeNames home = some_home();
  home.things.push_back("my blue mug");
  home.things.push_back("my microwave");
  home.things.push_back("meine Tasse");
  const auto said = [&](const std::string& text, const std::string& language) {
    return told(understand(text, catalogue().in(language), home));
  };
  EXPECT_EQ(said("where is my blue mug", "en"), "where_is my blue mug");
  EXPECT_EQ(said("where is the blue mug", "en"), "where_is my blue mug");
  // Whose it is tells it from the home's own.
  EXPECT_EQ(said("where is my microwave", "en"), "where_is my microwave");
  EXPECT_EQ(said("where is the microwave", "en"), "where_is microwave");
  EXPECT_EQ(said("forget my blue mug", "en"), "forget_thing my blue mug");
  EXPECT_EQ(said("share my blue mug", "en"), "share_thing my blue mug");
  EXPECT_EQ(said("keep my blue mug private", "en"), "keep_thing my blue mug");
  EXPECT_EQ(said("teach a thing", "en"), "teach_thing");
  EXPECT_EQ(said("Wo ist meine Tasse?", "de"), "where_is meine Tasse");
  EXPECT_EQ(said("Vergiss meine Tasse", "de"), "forget_thing meine Tasse");
  EXPECT_EQ(said("Olvida my blue mug", "es"), "forget_thing my blue mug");
  EXPECT_EQ(said("Oubliez my blue mug", "fr"), "forget_thing my blue mug");
}

TEST(UnderstandTest, SpotsAreMarkedByTheNameThatSomebodyGives) {
  EXPECT_EQ(english("Remember this place as my chair"), "mark_spot my chair");
  EXPECT_EQ(english("mark my chair here, please"), "mark_spot my chair");
  EXPECT_EQ(english("mark the Reading Nook here"), "mark_spot Reading Nook") << "no article";
  EXPECT_EQ(english("remember where I am"), "mark_spot");
  EXPECT_EQ(german("Dieser Platz ist mein Sessel"), "mark_spot mein Sessel");
  EXPECT_EQ(german("merk dir bitte, wo ich bin"), "mark_spot");
  EXPECT_EQ(told(hear("Marca aquí mi sillón", "es")), "mark_spot mi sillón");
  EXPECT_EQ(told(hear("Retiens cet endroit comme mon fauteuil", "fr")), "mark_spot mon fauteuil");
  EXPECT_EQ(english("mark one two three four five six here"), "not understood") << "no name";
  EXPECT_EQ(english("mark my small blue coffee mug here"), "mark_spot my small blue coffee mug");
}

TEST(UnderstandTest, SpotsAreGoalsAndForgottenByTheirNames) {
  HomeNames home = some_home();
  home.things.push_back("chair");
  home.spots = {"my chair", "mein Sessel", "reading corner"};
  const auto said = [&](const std::string& text, const std::string& language) {
    return told(understand(text, catalogue().in(language), home));
  };
  EXPECT_EQ(said("take me to my chair", "en"), "take_me_to my chair");
  EXPECT_EQ(said("take me to the chair", "en"), "take_me_to chair") << "whose it is tells";
  EXPECT_EQ(said("take me to our chair", "en"), "take_me_to my chair");
  EXPECT_EQ(said("where is my chair", "en"), "where_is my chair");
  EXPECT_EQ(said("forget my chair", "en"), "forget_spot my chair");
  EXPECT_EQ(said("forget the chair", "en"), "forget_thing chair");
  EXPECT_EQ(said("what is on my chair", "en"), "what_is_on chair") << "a spot is no thing";
  EXPECT_EQ(said("Bring mich zu meinem Sessel", "de"), "take_me_to mein Sessel") << "its case";
  EXPECT_EQ(said("take me back to the reading corner", "en"), "take_me_to reading corner");
}

TEST(UnderstandTest, AThingIsNamedWithItsRoom) {
  EXPECT_EQ(english("take me to the table in the kitchen"), "take_me_to table in kitchen");
  EXPECT_EQ(english("where is the table in the kitchen"), "where_is table in kitchen");
  EXPECT_EQ(german("Bring mich zum Tisch in der Küche"), "take_me_to table in kitchen");
  EXPECT_EQ(told(hear("llévame a la mesa de la cocina", "es")), "take_me_to table in kitchen");
  EXPECT_EQ(told(hear("emmène-moi à la table de la cuisine", "fr")), "take_me_to table in kitchen");
  EXPECT_EQ(english("where is the table in the cellar"), "not understood");
}

TEST(UnderstandTest, OfThingsInSeveralRoomsARoomAnswersWhichOne) {
  const Understood asked = which_room(hear("take me to the table"), {"kitchen", "living room"});
  EXPECT_EQ(told(asked), "which room: take_me_to table in kitchen in living room");
  for (const char* answer : {"kitchen", "in the kitchen", "the one in the kitchen"}) {
    EXPECT_EQ(told(in_answer_to(asked, hear(answer))), "take_me_to table in kitchen") << answer;
  }
  EXPECT_EQ(told(in_answer_to(asked, hear("where am I"))), "where_am_i");
  EXPECT_EQ(told(in_answer_to(asked, hear("the toilet"))), told(asked)) << "was not offered";
  const Understood frage = which_room(hear("zum Tisch", "de"), {"kitchen", "living room"});
  EXPECT_EQ(told(in_answer_to(frage, hear("der in der Küche", "de"))),
            "take_me_to table in kitchen");
}

TEST(UnderstandTest, ADoorIsNamedByItsRoomsInEveryLanguage) {
  const std::map<std::string, std::vector<std::string>> asked{
      {"take_me_to door in kitchen",
       {"en:bring me to the kitchen door", "en:take me to the door of the kitchen",
        "en:to the door to the kitchen", "en:go to the kitchen's door",
        "de:bring mich zur Küchentür", "de:zur Küchentür", "de:führe mich zur Tür der Küche",
        "de:zur Tür zur Küche", "es:llévame a la puerta de la cocina",
        "es:a la puerta que da a la cocina", "fr:emmène-moi à la porte de la cuisine",
        "fr:à la porte qui mène à la cuisine"}},
      {"take_me_to door in living room",
       {"en:take me to the living room door", "de:bring mich bitte zur Wohnzimmertür",
        "de:zur Tür des Wohnzimmers", "es:llévame a la puerta del salón",
        "fr:emmène-moi à la porte du salon"}},
      {"take_me_to door in living room in kitchen",
       {"en:take me to the door between the living room and the kitchen",
        "en:to the door from the living room to the kitchen",
        "de:bring mich zur Tür zwischen dem Wohnzimmer und der Küche",
        "de:zur Tür vom Wohnzimmer zur Küche", "es:llévame a la puerta entre el salón y la cocina",
        "es:a la puerta del salón a la cocina",
        "fr:emmène-moi à la porte entre le salon et la cuisine",
        "fr:à la porte du salon vers la cuisine"}},
      {"where_is door in kitchen",
       {"en:where is the kitchen door", "de:wo ist die Küchentür",
        "es:dónde está la puerta de la cocina", "fr:où est la porte de la cuisine"}},
      {"named door in kitchen",
       {"en:the kitchen door", "de:die Küchentür", "es:la puerta de la cocina",
        "fr:la porte de la cuisine"}},
      {"unknown: take_me_to basement",
       {"en:take me to the basement door", "de:bring mich zur Kellertür",
        "es:llévame a la puerta del sótano", "fr:emmène-moi à la porte de la cave"}},
      {"which room: take_me_to door in bedroom 1 in bedroom 2",
       {"en:take me to the bedroom door", "de:zur Schlafzimmertür",
        "es:llévame a la puerta del dormitorio", "fr:emmène-moi à la porte de la chambre"}},
  };
  for (const auto& [meaning, texts] : asked) {
    for (const std::string& text : texts) {
      EXPECT_EQ(told(hear(text.substr(3), text.substr(0, 2))), meaning) << text;
    }
  }
  EXPECT_EQ(english("take me to the door of the moon"), "not understood");
  EXPECT_EQ(english("is the bedroom door open"), "cannot tell") << "whichever bedroom is meant";
  EXPECT_EQ(told(hear("à la porte qui mène aux toilettes", "fr")), "take_me_to door in toilet");
  HomeNames home = some_home();
  home.goals.clear();
  for (const char* text : {"take me to the kitchen door", "take me to the bedroom door"}) {
    EXPECT_EQ(told(understand(text, catalogue().in("en"), home)), "unknown: take_me_to door");
  }
}

TEST(UnderstandTest, OfDoorsOfARoomTheOtherRoomAnswersWhichOne) {
  const std::vector<std::string> behind{"living room", "toilet"};
  const std::map<std::string, std::vector<std::string>> answers{
      {"en", {"toilet", "the one to the toilet", "to the toilet", "the door to the toilet"}},
      {"de", {"Toilette", "die zur Toilette", "zur Toilette", "die Toilettentür"}},
      {"es", {"aseo", "la que da al aseo", "la del aseo", "al aseo"}},
      {"fr", {"les toilettes", "celle vers les toilettes", "aux toilettes"}}};
  const std::map<std::string, std::string> asked{{"en", "take me to the kitchen door"},
                                                 {"de", "zur Küchentür"},
                                                 {"es", "llévame a la puerta de la cocina"},
                                                 {"fr", "emmène-moi à la porte de la cuisine"}};
  for (const auto& [language, texts] : answers) {
    const Understood offer = which_door(hear(asked.at(language), language), behind);
    EXPECT_EQ(told(offer), "which door: take_me_to door in kitchen in living room in toilet");
    for (const std::string& text : texts) {
      EXPECT_EQ(told(in_answer_to(offer, hear(text, language))),
                "take_me_to door in kitchen in toilet")
          << text;
    }
    EXPECT_EQ(told(in_answer_to(offer, hear("roomwise", language))), "not understood");
  }
  const Understood offer = which_door(hear("take me to the kitchen door"), behind);
  EXPECT_EQ(told(in_answer_to(offer, hear("to bedroom 1"))), "take_me_to bedroom 1")
      << "was not offered";
}

TEST(UnderstandTest, TheWayBackIsAskedForInEveryLanguage) {
  EXPECT_EQ(english("take me back"), "take_me_back");
  EXPECT_EQ(english("bring me back to where I started"), "take_me_back");
  EXPECT_EQ(german("Bring mich zurück"), "take_me_back");
  EXPECT_EQ(told(hear("Quiero volver", "es")), "take_me_back");
  EXPECT_EQ(told(hear("Ramenez-moi là où j'étais", "fr")), "take_me_back");
  EXPECT_EQ(english("which places did I mark"), "which_spots");
}

TEST(UnderstandTest, ANameThatIsASlipAwayIsAskedAbout) {
  EXPECT_EQ(english("take me to the kichen"), "did you mean: take_me_to kitchen");
  EXPECT_EQ(english("where is the mircowave"), "did you mean: where_is microwave");
  EXPECT_EQ(english("wehre is the microwave"), "where_is microwave");
  EXPECT_EQ(english("where is the cap"), "unknown: where_is cap") << "three letters: no slips";
}

TEST(UnderstandTest, ANameOfSeveralIsAskedAbout) {
  EXPECT_EQ(english("take me to the bedroom"), "which one: take_me_to bedroom 1 bedroom 2");
  EXPECT_EQ(english("take me to bedroom 2"), "take_me_to bedroom 2");
  EXPECT_EQ(german("Wo ist der Ofen?"), "which one: where_is oven stove");
  EXPECT_EQ(german("Wo ist der Backofen?"), "where_is oven");
}

TEST(UnderstandTest, NamesThatAHelperGaveAreKnownByTheirPartsToo) {
  EXPECT_EQ(english("where is Anna's chair"), "where_is Anna's chair");
  EXPECT_EQ(english("where is annas chair"), "where_is Anna's chair");
  EXPECT_EQ(english("take me to the livingroom"), "take_me_to living room");
  EXPECT_EQ(english("take me to the childrens room"), "take_me_to children's room");
  HomeNames home = some_home();
  home.things = {"blue box"};
  EXPECT_EQ(told(understand("find my box", catalogue().in("en"), home)), "where_is blue box");
}

TEST(UnderstandTest, WhatTheHomeDoesNotHaveKeepsItsName) {
  EXPECT_EQ(english("where is the piano"), "unknown: where_is piano");
  EXPECT_EQ(english("where are my red socks"), "unknown: where_is red socks");
  EXPECT_EQ(german("Wo ist das Klavier?"), "unknown: where_is piano");
  EXPECT_EQ(english("sing a song for us all and do it well"), "not understood");
  EXPECT_EQ(english(""), "not understood");
  EXPECT_EQ(english("?!"), "not understood");
  EXPECT_EQ(english(std::string(kMaxQuestionBytes + 1, 'a')), "not understood");
}

TEST(UnderstandTest, NoNameIsDeniedThatHoldsANameOfTheHome) {
  for (const char* text : {"Is there a cup on the table?", "where is the cup on the table",
                           "where is my plate on the table", "where is the cup I left here"}) {
    EXPECT_EQ(english(text), "not understood") << text;
  }
  EXPECT_EQ(german("gibt es eine Tasse auf dem Tisch"), "not understood");
  EXPECT_EQ(told(hear("¿Hay una taza en la mesa?", "es")), "not understood");
  EXPECT_EQ(told(hear("y a-t-il une tasse sur la table", "fr")), "not understood");
  EXPECT_EQ(english("is the window in the kitchen open"), "cannot tell");
}

TEST(UnderstandTest, AWordForAThingIsThatOfTheHomeWhoseNameHoldsIt) {
  EXPECT_EQ(english("where is the chair"), "where_is Anna's chair");
  HomeNames home = some_home();
  const auto asked = [&] {
    return told(understand("where is the chair", catalogue().in("en"), home));
  };
  home.things.emplace_back("Ben's chair");
  EXPECT_EQ(asked(), "which one: where_is Anna's chair Ben's chair");
  home.things.emplace_back("chair");
  EXPECT_EQ(asked(), "where_is chair") << "one is called so and no more";
}

// Every example on the manual's cards is a word of its language, and no slip in another.
TEST(UnderstandTest, AWordOfTheLanguageIsNoSlipInAnotherThatTheHomeHas) {
  HomeNames home = some_home();
  home.things = {"bowl"};
  const auto in_german = [&](const std::string& text) {
    return told(understand(text, catalogue().in("de"), home));
  };
  EXPECT_EQ(in_german("Wo habe ich meine Schlüssel gelassen?"), "unknown: where_is key");
  EXPECT_EQ(in_german("Wo ist die Schüsel?"), "did you mean: where_is bowl");
}

TEST(UnderstandTest, AnUnknownNameIsSaidAsItWasWritten) {
  EXPECT_EQ(told(hear("¿Dónde está el paño?", "es")), "unknown: where_is paño");
  EXPECT_EQ(german("Wo ist bitte das Käsemesser?"), "unknown: where_is Käsemesser");
  EXPECT_EQ(english("where is the cafe\u0301 sign"), "unknown: where_is cafe\u0301 sign");
}

TEST(UnderstandTest, WhatIsInAThingIsNotAnsweredByWhatStandsOnIt) {
  const std::map<std::string, std::vector<std::string>> inside{
      {"en", {"what is in the oven", "what is inside the oven", "is there anything in the oven"}},
      {"de", {"was ist im Backofen", "was liegt in dem Backofen", "ist etwas im Backofen"}},
      {"es", {"¿Qué hay en el horno?", "qué hay dentro del horno", "hay algo en el horno"}},
      {"fr",
       {"qu'y a-t-il dans le four", "qu'est-ce qu'il y a à l'intérieur du four",
        "y a-t-il quelque chose dans le four"}}};
  HomeNames home = some_home();
  home.things = {"oven"};
  for (const auto& [language, texts] : inside) {
    for (const std::string& text : texts) {
      EXPECT_EQ(told(understand(text, catalogue().in(language), home)), "cannot tell") << text;
    }
  }
}

TEST(UnderstandTest, ALabelOfANetworkNamesTheThing) {
  const auto vocabulary = objects::ObjectVocabulary::standard();
  HomeNames home = some_home();
  home.vocabulary = &vocabulary;
  EXPECT_EQ(told(understand("where is the four-poster", catalogue().in("en"), home)),
            "where_is bed");
}

TEST(UnderstandTest, YesAndANameAnswerWhatWasAsked) {
  const Understood kichen = hear("take me to the kichen");
  EXPECT_EQ(told(in_answer_to(kichen, hear("yes"))), "take_me_to kitchen");
  EXPECT_EQ(told(in_answer_to(kichen, hear("the bed"))), "take_me_to bed");
  const Understood bedroom = hear("take me to the bedroom");
  EXPECT_EQ(told(in_answer_to(bedroom, hear("bedroom 2"))), "take_me_to bedroom 2");
  EXPECT_EQ(told(in_answer_to(bedroom, hear("where am I"))), "where_am_i");
  EXPECT_EQ(told(in_answer_to(bedroom, hear("yes"))), told(bedroom)) << "of two, that says nothing";
  EXPECT_EQ(told(in_answer_to({}, hear("yes"))), "yes");
}

// A text that a pattern stands for, with a name of the home in its slot.
std::string example_of(const QuestionPattern& pattern, const Phrasebook& phrases,
                       const std::string& determiner) {
  std::string text;
  for (const std::string& word : pattern.before) text += word + " ";
  if (pattern.slot) {
    const bool is_room = pattern.slot == Slot::kRoom;
    const bool is_spot = pattern.slot == Slot::kSpot;
    const Noun noun = is_room                             ? room("kitchen").front()
                      : is_spot                           ? thing("reading corner").front()
                      : pattern.type == Type::kCannotTell ? thing("oven").front()
                                                          : thing("table").front();
    text += determiner + " " + phrases.called(noun);
  }
  for (const std::string& word : pattern.after) text += " " + word;
  return text;
}

std::string in_capitals(std::string text) {
  for (char& letter : text) {
    if (letter >= 'a' && letter <= 'z') letter = static_cast<char>(letter - 'a' + 'A');
  }
  return text;
}

TEST(UnderstandTest, EveryWayToAskOfEveryLanguageIsUnderstood) {
  for (const std::string& language : catalogue().languages()) {
    const Phrasebook& phrases = catalogue().in(language);
    for (const QuestionPattern& pattern : phrases.grammar().patterns()) {
      const std::string text = example_of(pattern, phrases, "");
      const Understood heard = understand(text, phrases, some_home());
      EXPECT_EQ(heard.type, pattern.type) << language << ": " << text;
      if (pattern.type == Type::kCannotTell) continue;
      EXPECT_EQ(heard.outcome, Outcome::kQuestion) << language << ": " << text;
      EXPECT_EQ(heard.names.size(), pattern.slot ? 1U : 0U) << language << ": " << text;
    }
  }
}

TEST(UnderstandTest, ArticlesCapitalsAndSignsDoNotChangeTheMeaning) {
  const std::map<std::string, std::vector<std::string>> determiners{
      {"en", {"the", "my", "a"}},
      {"de", {"der", "meinen", "einem"}},
      {"es", {"la", "mi", "una"}},
      {"fr", {"le", "ma", "l'"}}};
  for (const std::string& language : catalogue().languages()) {
    const Phrasebook& phrases = catalogue().in(language);
    for (const QuestionPattern& pattern : phrases.grammar().patterns()) {
      const Understood plain = understand(example_of(pattern, phrases, ""), phrases, some_home());
      for (const std::string& determiner : determiners.at(language)) {
        const std::string text = example_of(pattern, phrases, determiner);
        for (const std::string& said :
             {text, in_capitals(text), "¿ " + text + " ?!", "«" + text + ".»"}) {
          const Understood heard = understand(said, phrases, some_home());
          EXPECT_EQ(heard.type, plain.type) << said;
          // A new name is kept as it was written, but for articles.
          if (pattern.slot == Slot::kNew) continue;
          EXPECT_EQ(told(heard), told(plain)) << said;
        }
      }
    }
  }
}

// What a refusal names as an example must work.
TEST(UnderstandTest, WhatRefusalsSayCanBeAskedCanBeAsked) {
  for (const std::string& language : catalogue().languages()) {
    const Phrasebook& phrases = catalogue().in(language);
    for (const char* message :
         {"ask.examples", "ask.examples_thing", "ask.examples_room", "ask.examples_spot"}) {
      std::string text =
          phrases.text(message, {{"thing", thing("microwave")}, {"room", room("kitchen")}});
      text = text.substr(text.find(':') + 1);
      const std::size_t comma = text.find(',');
      ASSERT_NE(comma, std::string::npos) << text;
      for (const std::string& one : {text.substr(0, comma), text.substr(comma)}) {
        EXPECT_EQ(understand(one, phrases, some_home()).outcome, Outcome::kQuestion) << one;
      }
    }
  }
}

void expect_one_meaning(const std::string& text, const std::string& language) {
  const Understood heard = hear(text, language);
  EXPECT_EQ(told(hear(text, language)), told(heard)) << text;
  EXPECT_EQ(heard.outcome == Outcome::kWhichOne, heard.names.size() > 1) << text;
}

TEST(UnderstandTest, AnyBytesAreATextAndMeanOneThing) {
  for (const std::string& language : catalogue().languages()) {
    for (std::uint64_t seed = 0; seed < 100; ++seed) {
      RandomStream random(seed);
      std::string text(random.index(60), ' ');
      for (char& byte : text) byte = static_cast<char>(random.index(256));
      expect_one_meaning(text, language);
    }
  }
}

// Parts of questions in any order, with letters lost, come nearer to what is understood.
TEST(UnderstandTest, WordsInAnyOrderAreATextAndMeanOneThing) {
  for (const std::string& language : catalogue().languages()) {
    const auto patterns = catalogue().in(language).grammar().patterns();
    for (std::uint64_t seed = 0; seed < 100; ++seed) {
      RandomStream random(seed);
      std::string text;
      for (std::uint64_t parts = random.index(4); parts > 0; --parts) {
        text += example_of(patterns[random.index(patterns.size())], catalogue().in(language), " ");
        if (random.index(2) == 0) text.erase(random.index(text.size()), 1);
        text += ' ';
      }
      expect_one_meaning(text, language);
    }
  }
}

// One letter of a text missing, too many, or wrong.
std::string with_a_slip(std::string text, RandomStream& random) {
  const auto is_letter = [](char letter) { return letter >= 'a' && letter <= 'z'; };
  std::size_t at = random.index(text.size());
  while (!is_letter(text[at])) at = random.index(text.size());
  const char letter = static_cast<char>('a' + random.index(26));
  switch (random.index(3)) {
    case 0:
      text.erase(at, 1);
      break;
    case 1:
      text.insert(at, 1, letter);
      break;
    default:
      text[at] = letter;
  }
  return text;
}

TEST(UnderstandTest, ASlipIsForgivenAskedAboutOrRefusedAndNoOtherQuestion) {
  for (const std::string& language : catalogue().languages()) {
    const Phrasebook& phrases = catalogue().in(language);
    const auto patterns = phrases.grammar().patterns();
    std::map<Outcome, int> outcomes;
    for (std::size_t i = 0; i < patterns.size(); ++i) {
      if (patterns[i].type == Type::kCannotTell) continue;
      RandomStream random(i);
      const std::string text = example_of(patterns[i], phrases, "");
      const std::string slipped = with_a_slip(text, random);
      const Understood heard = understand(slipped, phrases, some_home());
      ++outcomes[heard.outcome];
      if (heard.outcome != Outcome::kQuestion) continue;
      const Understood meant = understand(text, phrases, some_home());
      EXPECT_EQ(heard.type, meant.type) << slipped;
      if (patterns[i].slot == Slot::kNew) continue;
      EXPECT_EQ(told(heard), told(meant)) << slipped;
    }
    for (const auto& [outcome, count] : outcomes) {
      RecordProperty(fmt::format("{}_{}", language, static_cast<int>(outcome)), count);
    }
  }
}

TEST(FoldedWordsTest, AreSmallWithoutAccentsAndSigns) {
  EXPECT_THAT(folded_words("Wo ist die KÜCHE?"), ElementsAre("wo", "ist", "die", "kuche"));
  EXPECT_THAT(folded_words("Große Äpfel, œuf; Łódź"),
              ElementsAre("grosse", "apfel", "oeuf", "lodz"));
  EXPECT_THAT(folded_words("u\u0308ber"), ElementsAre("uber")) << "a mark of its own";
  EXPECT_THAT(folded_words("¿Qué hay?"), ElementsAre("que", "hay"));
  EXPECT_THAT(folded_words("qu’est-ce"), ElementsAre("qu", "est", "ce"));
  EXPECT_THAT(folded_words("дом 2"), ElementsAre("дом", "2"));
  EXPECT_THAT(folded_words("a\xFF\xC3z\xE2\x82"), ElementsAre("a", "z"));
  EXPECT_THAT(folded_words("¡«»!"), IsEmpty());
}

TEST(FoldedWordsTest, SlipsAreCounted) {
  EXPECT_EQ(slips_between("kitchen", "kitchen"), 0);
  EXPECT_EQ(slips_between("kitchen", "kichen"), 1);
  EXPECT_EQ(slips_between("kitchen", "kicthen"), 1) << "two exchanged";
  EXPECT_EQ(slips_between("kitchen", ""), 7);
  EXPECT_EQ(slips_between("bed", "bath"), 3);
}

TEST(GrammarTest, NamesThePatternThatIsWrong) {
  nlohmann::json file = nlohmann::json::parse(built_in_messages()[0]);
  const auto with = [&](const nlohmann::json& patterns) {
    nlohmann::json questions = file["questions"];
    questions["patterns"]["next"] = patterns;
    return Grammar::parse(questions);
  };
  EXPECT_OK(with({"and (now|then) [what]"}));
  EXPECT_ERROR(with({"and (now|then"}), "\"next\", \"and (now|then\": \"(\" is not closed");
  EXPECT_ERROR(with({"and now)"}), "\")\" closes nothing");
  EXPECT_ERROR(with({"to {thing} and {thing}"}), "it has two names");
  EXPECT_ERROR(with({"to {home}"}), "there is no \"{home}\"");
  EXPECT_ERROR(with({"[now]"}), "it may be empty");
  EXPECT_ERROR(with(nlohmann::json::array()), "there is no pattern of \"next\"");
  EXPECT_ERROR(with({"(a|b)(a|b)(a|b)(a|b)(a|b)(a|b)(a|b)(a|b)(a|b)(a|b)(a|b)(a|b)(a|b)"}),
               "too many ways");
  file["questions"]["patterns"]["dance"] = {"dance"};
  EXPECT_ERROR(Grammar::parse(file["questions"]), "there is no type \"dance\"");
}

}  // namespace
}  // namespace roomwise::guide
