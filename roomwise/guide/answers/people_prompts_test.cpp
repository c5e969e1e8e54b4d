#include "roomwise/guide/answers/people_prompts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/guide/words/message_catalogue.h"

namespace roomwise::guide {
namespace {

using ::testing::ElementsAre;
using Side = SeenPerson::Side;

std::vector<std::string> told_of(const std::vector<SeenPerson>& people) {
  static const MessageCatalogue catalogue = MessageCatalogue::built_in();
  const Wording english{&catalogue, {.language = "en", .distances = DistanceUnit::kMetres}};
  std::vector<std::string> texts;
  for (const Prompt& prompt : people_prompts(people, english, 0)) texts.push_back(prompt.text);
  return texts;
}

TEST(PeoplePromptsTest, SomebodyIsToldBySideAndDistance) {
  EXPECT_THAT(told_of({{Side::kLeft, 2.1}}), ElementsAre("Somebody is on your left, 2 metres."));
  EXPECT_THAT(told_of({{Side::kAhead}}), ElementsAre("Somebody is ahead of you."));
}

TEST(PeoplePromptsTest, OfSeveralTheNearestIsTold) {
  EXPECT_THAT(told_of({{Side::kLeft}, {Side::kAhead, 4}, {Side::kRight, 1.5}}),
              ElementsAre("I see 3 people.", "Somebody is on your right, 1.5 metres."));
}

TEST(PeoplePromptsTest, WhoIsNotSeenIsNotSaidToBeAbsent) {
  EXPECT_THAT(told_of({}), ElementsAre("I see nobody in front of you."));
}

TEST(PeoplePromptsTest, WhatMayBeSomebodyIsSaidAsSuch) {
  EXPECT_THAT(told_of({{Side::kLeft, 2, false}}), ElementsAre("Perhaps I see somebody."));
  EXPECT_THAT(told_of({{Side::kLeft, 2, false}, {Side::kAhead, 3}}),
              ElementsAre("Somebody is ahead of you, 3 metres."));
}

}  // namespace
}  // namespace roomwise::guide
