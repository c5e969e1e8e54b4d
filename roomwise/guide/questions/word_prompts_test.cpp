#include "roomwise/guide/questions/word_prompts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "roomwise/guide/testing/test_times.h"
#include "roomwise/guide/words/message_catalogue.h"

namespace roomwise::guide {
namespace {

using ::testing::ElementsAre;

class WordPromptsTest : public ::testing::Test {
 protected:
  [[nodiscard]] std::optional<std::string> word(const std::string& text,
                                                const std::string& language) const {
    const HomeNames home{{"bed"}, {"kitchen"}, {}};
    const Phrasebook& phrases = catalogue_.in(language);
    return word_to_look_for(understand(text, phrases, home), phrases);
  }
  [[nodiscard]] Wording wording(const std::string& language) const {
    return {&catalogue_, {language, DistanceUnit::kSteps, 0.5}};
  }
  static std::vector<std::string> texts(const std::vector<Prompt>& prompts) {
    std::vector<std::string> texts;
    for (const Prompt& prompt : prompts) texts.push_back(prompt.text);
    return texts;
  }

  const MessageCatalogue catalogue_ = MessageCatalogue::built_in();
};

TEST_F(WordPromptsTest, WhatIsLookedForIsEnglish) {
  EXPECT_EQ(word("where is the accordion", "en"), "accordion") << "of no language's words";
  EXPECT_EQ(word("take me to the accordion", "en"), "accordion");
  EXPECT_EQ(word("where is the piano", "en"), "piano");
  EXPECT_EQ(word("Wo ist das Klavier?", "de"), "piano") << "a word that the language knows";
  EXPECT_EQ(word("¿Dónde está el piano?", "es"), "piano");
  EXPECT_EQ(word("Où est le piano ?", "fr"), "piano");
  EXPECT_EQ(word("Wo ist das Akkordeon?", "de"), std::nullopt) << "nobody can translate it";
  EXPECT_EQ(word("where is the bed", "en"), std::nullopt) << "the home has one";
  EXPECT_EQ(word("where is the garage", "en"), std::nullopt) << "a room";
  EXPECT_EQ(word("what is on the accordion", "en"), std::nullopt);
  EXPECT_EQ(word("sing", "en"), std::nullopt);
}

TEST_F(WordPromptsTest, WhatMayHaveBeenSeenIsNeverSaidAsCertain) {
  const CalendarTime today{.year = 2026, .month = 11, .day = 27, .hour = 15};
  CalendarTime morning = today;
  morning.hour = 9;
  const std::map<std::string, std::vector<std::string>> said{
      {"en",
       {"Perhaps I saw the piano in the hall.", "Seen this morning.",
        "By pictures alone; I am not sure."}},
      {"de",
       {"Vielleicht sah ich das Klavier in der Diele.", "Gesehen heute Morgen.",
        "Nur nach Bildern; sicher bin ich nicht."}},
      {"es",
       {"Quizá vi el piano en el vestíbulo.", "Visto esta mañana.",
        "Solo por las imágenes; no es seguro."}},
      {"fr",
       {"J'ai peut-être vu le piano dans le hall.", "Vu ce matin.",
        "D'après les images seules ; ce n'est pas sûr."}}};
  for (const auto& [language, texts_said] : said) {
    const auto prompts =
        word_prompts("piano", SeenWord{"hall", morning}, today, wording(language), kNow);
    EXPECT_EQ(texts(prompts), texts_said);
    EXPECT_EQ(prompts.front().confidence, Confidence::kUnsure);
    EXPECT_EQ(prompts.back().confidence, Confidence::kUnsure);
  }
  EXPECT_THAT(texts(word_prompts("accordion", SeenWord{}, today, wording("en"), kNow)),
              ElementsAre("Perhaps I saw the accordion, room unknown.",
                          "By pictures alone; I am not sure."));
  EXPECT_THAT(texts(word_prompts("accordion", {}, today, wording("en"), kNow)),
              ElementsAre("I found no accordion in the pictures."));
}

TEST_F(WordPromptsTest, WhoAsksHearsThatItIsLookedFor) {
  const std::map<std::string, std::vector<std::string>> said{
      {"en", {"I know no piano here.", "I look for it in the pictures."}},
      {"de", {"Ich kenne hier kein Klavier.", "Ich suche in den Bildern danach."}},
      {"es", {"Aquí no conozco ningún piano.", "Lo busco en las imágenes."}},
      {"fr", {"Ici, je ne connais aucun piano.", "Je cherche dans les images."}}};
  for (const auto& [language, texts_said] : said) {
    EXPECT_EQ(texts(looking_prompts("piano", wording(language), kNow)), texts_said);
  }
}

}  // namespace
}  // namespace roomwise::guide
