#include "roomwise/guide/answers/spot_prompts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/guide/words/message_catalogue.h"

namespace roomwise::guide {
namespace {

std::string texts_of_spots(const std::vector<Prompt>& prompts) {
  std::string text;
  for (const Prompt& prompt : prompts) text += (text.empty() ? "" : " ") + prompt.text;
  return text;
}

TEST(SpotPromptsTest, WhatWasMarkedIsSaidByItsName) {
  const MessageCatalogue catalogue = MessageCatalogue::built_in();
  const Wording english{&catalogue, {.language = "en"}};
  EXPECT_EQ(spot_prompt(SpotStep::kMarked, "my chair", english, 0).text,
            "My chair is marked here.");
  EXPECT_EQ(spot_prompt(SpotStep::kMarked, "", english, 0).text,
            "I remember this place. Say: take me back.");
  EXPECT_EQ(spot_prompt(SpotStep::kNotYours, "my chair", english, 0).text,
            "You marked nothing called my chair.");
  EXPECT_EQ(spot_prompt(SpotStep::kNotSure, "my chair", english, 0).confidence,
            Confidence::kUnsure);
  EXPECT_EQ(spot_prompt(SpotStep::kForgotten, "", english, 0).text,
            "The remembered place is forgotten.");
}

TEST(SpotPromptsTest, EveryStepHasWordsInEveryLanguage) {
  const MessageCatalogue catalogue = MessageCatalogue::built_in();
  for (const std::string& language : catalogue.languages()) {
    const Wording wording{&catalogue, {.language = language}};
    for (int step = 0; step <= static_cast<int>(SpotStep::kBusy); ++step) {
      EXPECT_FALSE(spot_prompt(static_cast<SpotStep>(step), "my chair", wording, 0).text.empty());
    }
    EXPECT_EQ(spots_prompts({}, wording, 0).size(), 1U);
    EXPECT_EQ(spots_prompts({"a", "b", "c", "d"}, wording, 0).size(), 2U);
  }
}

TEST(SpotPromptsTest, ManySpotsAreToldInParts) {
  const MessageCatalogue catalogue = MessageCatalogue::built_in();
  const Wording english{&catalogue, {.language = "en"}};
  EXPECT_EQ(texts_of_spots(spots_prompts({"my chair", "long bench", "sink", "window"}, english, 0)),
            "You marked: my chair, long bench and sink. Then: window.");
}

}  // namespace
}  // namespace roomwise::guide
