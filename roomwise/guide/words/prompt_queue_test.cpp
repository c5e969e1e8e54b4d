#include "roomwise/guide/words/prompt_queue.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::guide {
namespace {

using ::testing::HasSubstr;
using ::testing::Optional;

constexpr TimestampNs at(double seconds) {
  return static_cast<TimestampNs>(seconds * 1e9);
}

Prompt prompt(Priority priority, const std::string& key, const std::string& text,
              double valid_until_s = 1000) {
  Prompt made;
  made.replace_key = key;
  made.text = text;
  made.priority = priority;
  made.valid_until_ns = at(valid_until_s);
  return made;
}
Prompt answer(const std::string& key, const std::string& text, double valid_until_s = 1000) {
  return prompt(Priority::kAnswer, key, text, valid_until_s);
}
Prompt callout(const std::string& key, const std::string& text, double valid_until_s = 1000) {
  return prompt(Priority::kCallout, key, text, valid_until_s);
}
Prompt hazard(const std::string& text = "Obstacle ahead.") {
  return prompt(Priority::kHazard, "hazard", text);
}

class PromptQueueTest : public ::testing::Test {
 protected:
  // What is begun at that time; empty: nothing.
  std::string begin(double seconds) {
    const auto utterance = queue_.next(at(seconds));
    return utterance ? utterance->prompt.text : "";
  }
  void finish(double seconds) { queue_.finished(queue_.speaking()->id, at(seconds)); }
  // Begins, and finishes half a second later.
  std::string speak(double seconds) {
    const std::string text = begin(seconds);
    if (!text.empty()) finish(seconds + 0.5);
    return text;
  }

  PromptQueue queue_;
};

TEST_F(PromptQueueTest, TheMostUrgentGoesFirstAndOfEqualsTheOldest) {
  queue_.add(callout("room", "callout"), at(0));
  queue_.add(prompt(Priority::kNotice, "camera", "notice"), at(0));
  queue_.add(answer("a", "first"), at(0));
  queue_.add(answer("b", "second"), at(0));
  queue_.add(hazard("hazard"), at(0));
  double seconds = 0;
  for (const char* text : {"hazard", "first", "second", "notice", "callout", ""}) {
    EXPECT_EQ(speak(seconds += 2), text);
  }
}

TEST_F(PromptQueueTest, OneIsSpokenAtATime) {
  queue_.add(answer("a", "first"), at(0));
  queue_.add(answer("b", "second"), at(0));
  EXPECT_EQ(begin(0), "first");
  EXPECT_EQ(begin(1), "");
  EXPECT_EQ(queue_.next_at(at(1)), std::nullopt);
  queue_.finished(99, at(1));  // of something else
  EXPECT_EQ(begin(1), "");
  finish(2);
  EXPECT_EQ(begin(2), "second");
}

TEST_F(PromptQueueTest, ANewerPromptReplacesTheOlderOfItsKey) {
  queue_.add(answer("room", "hall"), at(0));
  queue_.add(answer("other", "other"), at(0));
  queue_.add(answer("room", "kitchen"), at(1));
  EXPECT_EQ(speak(1), "kitchen");
  EXPECT_EQ(speak(2), "other");
  EXPECT_EQ(speak(3), "");
}

TEST_F(PromptQueueTest, ANewAnswerReplacesAllPartsOfTheOld) {
  for (const char* key : {"around", "around/2", "around/3", "aroundabout"}) {
    queue_.add(answer(key, std::string("old ") + key), at(0));
  }
  queue_.add(answer("around", "new around"), at(1));
  queue_.add(answer("around/2", "new around/2"), at(1));
  EXPECT_EQ(speak(1), "new around");
  EXPECT_EQ(speak(2), "old aroundabout");
  EXPECT_EQ(speak(3), "new around/2");
  EXPECT_EQ(speak(4), "");
}

TEST_F(PromptQueueTest, WhatWasAskedForStaysUrgentWhenACalloutReplacesIt) {
  queue_.add(prompt(Priority::kNotice, "camera", "notice"), at(0));
  queue_.add(answer("room", "hall"), at(0));
  queue_.set_quiet(true);
  queue_.add(callout("room", "kitchen"), at(0));
  EXPECT_EQ(speak(0), "kitchen");
  EXPECT_EQ(speak(1), "notice");
  EXPECT_EQ(speak(2), "");
}

TEST_F(PromptQueueTest, WhatIsPastItsTimeIsNeverBegun) {
  queue_.add(answer("a", "late", 2), at(0));
  EXPECT_EQ(queue_.next_at(at(2.1)), std::nullopt);
  EXPECT_EQ(begin(2.1), "");
  queue_.add(answer("a", "just in time", 2), at(0));
  EXPECT_EQ(begin(2), "just in time");
}

TEST_F(PromptQueueTest, TheSameCalloutIsSaidOnceAMinute) {
  queue_.add(callout("room", "kitchen"), at(0));
  EXPECT_EQ(speak(0), "kitchen");
  queue_.add(callout("room", "kitchen"), at(59));
  EXPECT_EQ(speak(59.9), "");
  EXPECT_EQ(speak(70), "");  // it did not wait for the minute to end
  queue_.add(callout("room", "hall"), at(59));
  EXPECT_EQ(speak(59), "hall");
  queue_.add(callout("room", "kitchen"), at(61));
  EXPECT_EQ(speak(61), "kitchen");
}

TEST_F(PromptQueueTest, ACalloutThatIsNotSaidAgainStillOutdatesTheOneThatWaits) {
  queue_.add(callout("room", "kitchen"), at(0));
  EXPECT_EQ(speak(0), "kitchen");
  queue_.add(callout("room", "hall"), at(1));
  queue_.add(callout("room", "kitchen"), at(1.1));
  EXPECT_EQ(speak(2), "");
}

TEST_F(PromptQueueTest, QuestionsAreAlwaysAnswered) {
  for (const double time : {0.0, 1.0, 2.0}) {
    queue_.add(answer("room", "kitchen"), at(time));
    EXPECT_EQ(speak(time), "kitchen");
  }
  queue_.add(callout("room", "kitchen"), at(5));
  EXPECT_EQ(speak(5), "");  // the answer said it
}

TEST_F(PromptQueueTest, ThereIsSilenceBeforeACallout) {
  queue_.add(callout("a", "first"), at(0));
  queue_.add(callout("b", "second"), at(0));
  queue_.add(answer("c", "answer"), at(0.1));
  EXPECT_EQ(speak(0.1), "answer");  // until 0.6
  EXPECT_EQ(begin(0.6), "");
  EXPECT_THAT(queue_.next_at(at(0.6)), Optional(at(1.35)));
  EXPECT_EQ(begin(1.34), "");
  EXPECT_EQ(speak(1.35), "first");  // until 1.85
  EXPECT_EQ(begin(2.5), "");
  EXPECT_EQ(begin(2.6), "second");
}

TEST_F(PromptQueueTest, AHazardBreaksOffWhatIsBeingSpoken) {
  queue_.add(answer("around", "bed", 3), at(0));
  queue_.add(answer("around/2", "lamp", 6), at(0));
  EXPECT_EQ(begin(0), "bed");
  EXPECT_FALSE(queue_.interrupts(at(0.5)));
  const std::uint64_t broken_off = queue_.speaking()->id;
  queue_.add(hazard(), at(0.5));
  EXPECT_TRUE(queue_.interrupts(at(0.5)));
  EXPECT_THAT(queue_.next_at(at(0.5)), Optional(at(0.5)));
  const auto utterance = queue_.next(at(0.5));
  ASSERT_TRUE(utterance);
  EXPECT_TRUE(utterance->breaks_off);
  EXPECT_EQ(utterance->prompt.text, "Obstacle ahead.");
  queue_.finished(broken_off, at(0.6));  // the speech reports late
  EXPECT_EQ(begin(0.6), "");
  finish(1.5);
  // The answer begins again, in its order.
  EXPECT_EQ(speak(1.5), "bed");
  EXPECT_EQ(speak(2.5), "lamp");
}

TEST_F(PromptQueueTest, WhatWasBrokenOffIsNotSaidAgainWhenItIsOldOrACallout) {
  queue_.add(answer("room", "kitchen", 1), at(0));
  EXPECT_EQ(begin(0), "kitchen");
  queue_.add(hazard("a"), at(0.5));
  EXPECT_EQ(speak(0.5), "a");
  EXPECT_EQ(begin(1.1), "");
  queue_.add(callout("room", "hall"), at(2));
  EXPECT_EQ(begin(2), "hall");
  queue_.add(hazard("b"), at(2.5));
  EXPECT_EQ(speak(2.5), "b");
  EXPECT_EQ(begin(10), "");
}

TEST_F(PromptQueueTest, WhatANewerWordOnTheSameBrokeOffIsNotSaidAgain) {
  for (const std::string key : {"guide", "guide/2"}) {
    queue_ = PromptQueue();
    queue_.add(answer(key, "Straight on.", 9), at(0));
    EXPECT_EQ(begin(0), "Straight on.");
    Prompt stop = hazard("Off the way. Stop.");
    stop.replace_key = "guide";
    queue_.add(stop, at(0.5));
    EXPECT_EQ(speak(0.5), "Off the way. Stop.");
    EXPECT_EQ(begin(2), "") << key;
  }
}

TEST_F(PromptQueueTest, HazardsDoNotBreakOffHazardsNorStutter) {
  queue_.add(hazard(), at(0));
  EXPECT_EQ(begin(0), "Obstacle ahead.");
  queue_.add(hazard(), at(0.1));
  queue_.add(prompt(Priority::kHazard, "stairs", "Stairs ahead."), at(0.1));
  EXPECT_EQ(begin(0.2), "");
  finish(1);
  EXPECT_EQ(speak(1), "Stairs ahead.");
  EXPECT_EQ(speak(2), "");
  queue_.add(hazard(), at(4));
  EXPECT_EQ(speak(4), "Obstacle ahead.");
}

TEST_F(PromptQueueTest, WhoAsksAnewHearsNoMoreOfTheAnswersBefore) {
  queue_.add(answer("around", "bed", 3), at(0));
  queue_.add(answer("around/2", "lamp", 7), at(0));
  queue_.add(prompt(Priority::kNotice, "camera", "notice"), at(0));
  queue_.add(callout("hall", "callout"), at(0));
  EXPECT_EQ(begin(0), "bed");
  const std::uint64_t broken_off = queue_.speaking()->id;
  EXPECT_TRUE(queue_.withdraw_answers(at(1)));
  EXPECT_FALSE(queue_.speaking());
  queue_.add(answer("room", "kitchen", 4), at(1.2));
  EXPECT_EQ(begin(1.2), "kitchen");
  queue_.finished(broken_off, at(1.3));  // the speech reports late
  EXPECT_TRUE(queue_.speaking());
  finish(2);
  EXPECT_EQ(speak(2), "notice");
  EXPECT_EQ(speak(5), "callout");
  EXPECT_EQ(speak(9), "");
  EXPECT_EQ(queue_.take_expired_answers(), 0);  // they were not wanted any more
}

TEST_F(PromptQueueTest, AskingAnewBreaksOffAnswersAlone) {
  queue_.add(answer("room", "kitchen", 5), at(0));
  EXPECT_EQ(begin(0), "kitchen");
  queue_.add(hazard(), at(0.5));
  EXPECT_EQ(begin(0.5), "Obstacle ahead.");
  EXPECT_FALSE(queue_.withdraw_answers(at(0.6)));
  ASSERT_TRUE(queue_.speaking());
  EXPECT_EQ(queue_.speaking()->prompt.text, "Obstacle ahead.");
  finish(1);
  EXPECT_EQ(begin(1), "");  // the answer that it broke off does not come back
}

TEST_F(PromptQueueTest, TellsOfAnswersThatWereNeverBegun) {
  queue_.add(answer("around", "long answer"), at(0));
  EXPECT_EQ(begin(0), "long answer");
  queue_.add(answer("room", "kitchen", 3), at(1));
  queue_.add(answer("other", "replaced", 3), at(1));
  queue_.add(answer("other", "newer"), at(2));
  queue_.add(callout("hall", "callout", 3), at(1));
  EXPECT_EQ(begin(3), "");
  EXPECT_EQ(queue_.take_expired_answers(), 0);
  EXPECT_EQ(begin(3.1), "");
  EXPECT_EQ(queue_.take_expired_answers(), 1);
  EXPECT_EQ(queue_.take_expired_answers(), 0);
  finish(4);
  EXPECT_EQ(begin(4), "newer");
  queue_.add(hazard(), at(5));
  EXPECT_EQ(begin(5), "Obstacle ahead.");
  EXPECT_EQ(begin(1001), "");  // it was begun at least
  EXPECT_EQ(queue_.take_expired_answers(), 0);
}

TEST_F(PromptQueueTest, WhatAGuideSaysByItselfIsNoAnswerThatSomebodyMisses) {
  queue_.add(answer("rooms", "long answer"), at(0));
  EXPECT_EQ(begin(0), "long answer");
  queue_.add(answer("guide", "turn left", 3), at(1), /*is_asked_for=*/false);
  EXPECT_EQ(begin(4), "");
  EXPECT_EQ(queue_.take_expired_answers(), 0);
  // But where it took the place of an answer that waited, somebody does.
  queue_.add(answer("guide", "two metres", 6), at(5));
  queue_.add(answer("guide", "turn right", 6), at(5.5), /*is_asked_for=*/false);
  EXPECT_EQ(begin(7), "");
  EXPECT_EQ(queue_.take_expired_answers(), 1);
}

TEST_F(PromptQueueTest, AnAnswerBreaksOffANoticeOrCalloutSinceItHoldsForSeconds) {
  queue_.add(callout("hall", "callout"), at(0));
  EXPECT_EQ(begin(0), "callout");
  queue_.add(answer("guide", "turn left"), at(1), /*is_asked_for=*/false);
  EXPECT_EQ(begin(1), "") << "nobody asked";
  queue_.add(answer("room", "kitchen", 3), at(1.5));
  EXPECT_TRUE(queue_.interrupts(at(1.5)));
  const auto utterance = queue_.next(at(1.5));
  ASSERT_TRUE(utterance);
  EXPECT_EQ(utterance->prompt.text, "kitchen");
  EXPECT_TRUE(utterance->breaks_off);
  queue_.add(answer("other", "sofa"), at(2));
  EXPECT_EQ(begin(2), "") << "one answer does not break off another";
  finish(3);
  EXPECT_EQ(speak(3), "turn left");
  EXPECT_EQ(speak(4), "sofa");
  queue_.add(prompt(Priority::kNotice, "camera", "notice"), at(5));
  EXPECT_EQ(begin(5), "notice");
  queue_.add(answer("room", "hall", 7), at(5.5));
  EXPECT_EQ(speak(5.5), "hall");
  EXPECT_EQ(speak(6), "notice") << "the notice is spoken again, the callout is not";
  EXPECT_EQ(speak(9), "");
}

TEST_F(PromptQueueTest, QuietSilencesCalloutsAlone) {
  queue_.add(callout("room", "waiting"), at(0));
  queue_.set_quiet(true);
  queue_.add(callout("room", "added"), at(0));
  queue_.add(prompt(Priority::kNotice, "camera", "notice"), at(0));
  queue_.add(answer("a", "answer"), at(0));
  queue_.add(hazard("hazard"), at(0));
  EXPECT_EQ(speak(1), "hazard");
  EXPECT_EQ(speak(2), "answer");
  EXPECT_EQ(speak(3), "notice");
  EXPECT_EQ(speak(9), "");
  queue_.set_quiet(false);
  queue_.add(callout("room", "added"), at(10));
  EXPECT_EQ(speak(10), "added");
}

TEST_F(PromptQueueTest, RemembersTheWholeAnswerForRepetition) {
  EXPECT_FALSE(queue_.last_said());
  queue_.add(answer("around", "bed"), at(0));
  queue_.add(answer("around/2", "lamp"), at(0));
  (void)speak(1);
  (void)speak(2);
  queue_.add(prompt(Priority::kNotice, "camera", "notice"), at(3));
  queue_.add(answer("repeat", "bed"), at(3));
  queue_.add(answer("repeat/2", "lamp"), at(3));
  queue_.add(hazard(), at(3));
  for (const double time : {3.0, 4.0, 5.0, 6.0}) EXPECT_NE(speak(time), "");
  ASSERT_TRUE(queue_.last_said());
  EXPECT_EQ(queue_.last_said()->begun_ns, at(1));
  ASSERT_EQ(queue_.last_said()->prompts.size(), 2u);
  EXPECT_EQ(queue_.last_said()->prompts[1].text, "lamp");
  queue_.add(callout("room", "kitchen"), at(9));
  (void)speak(9);
  EXPECT_EQ(queue_.last_said()->prompts.at(0).text, "kitchen");
}

TEST_F(PromptQueueTest, OptionsAreChecked) {
  EXPECT_OK(PromptQueueOptions{}.validate());
  EXPECT_ERROR(PromptQueueOptions{.same_callout_s = -1}.validate(), "same_callout_s is -1");
  EXPECT_ERROR(PromptQueueOptions{.callout_gap_s = NAN}.validate(), "callout_gap_s is nan");
}

// What happened, to check the rules against.
struct Begun {
  Prompt prompt;
  TimestampNs at_ns = 0;
  std::optional<TimestampNs> ended_ns;
};

Prompt random_prompt(RandomStream& random, double now_s) {
  static const std::vector<std::string> keys{"a", "a/2", "b", "room"};
  const auto priority = static_cast<Priority>(random.index(4));
  return prompt(priority, keys[random.index(keys.size())], fmt::format("{}", random.index(3)),
                now_s + 4 * random.uniform());
}

TEST(PromptQueuePropertyTest, RulesHoldForAnythingThatHappens) {
  std::map<Priority, int> spoken;
  int broken_off = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    RandomStream random(seed);
    PromptQueue queue;
    std::vector<Begun> begun;
    std::vector<Prompt> waiting;  // what was added and is neither begun nor past its time
    double now_s = 0;
    for (int step = 0; step < 600; ++step) {
      now_s += 0.3 * random.uniform();
      const TimestampNs now = at(now_s);
      if (random.uniform() < 0.01) queue.set_quiet(!queue.quiet());
      if (random.uniform() < 0.4) queue.add(random_prompt(random, now_s), now);
      if (queue.speaking() && random.uniform() < 0.25) {
        queue.finished(queue.speaking()->id, now);
        begun.back().ended_ns = now;
      }
      const auto speaking = queue.speaking();
      const bool interrupts = queue.interrupts(now);
      const auto next_at = queue.next_at(now);
      const auto utterance = queue.next(now);
      EXPECT_EQ(utterance.has_value(), next_at == now);
      if (!utterance) continue;
      const Prompt& said = utterance->prompt;
      ++spoken[said.priority];
      EXPECT_LE(now, said.valid_until_ns);
      EXPECT_EQ(utterance->breaks_off, speaking.has_value());
      EXPECT_EQ(utterance->breaks_off, interrupts);
      if (speaking) {
        ++broken_off;
        EXPECT_LE(said.priority, Priority::kAnswer);
        EXPECT_GT(speaking->prompt.priority, said.priority);
        begun.back().ended_ns = now;
      }
      if (said.priority == Priority::kCallout) {
        EXPECT_FALSE(queue.quiet());
        for (const Begun& before : begun) {
          ASSERT_TRUE(before.ended_ns);
          EXPECT_GE(now, *before.ended_ns + at(0.75));
          const bool is_same =
              before.prompt.replace_key == said.replace_key && before.prompt.text == said.text;
          EXPECT_TRUE(!is_same || now >= before.at_ns + at(60)) << said.text << " at " << now_s;
        }
      }
      begun.push_back({said, now, std::nullopt});
    }
  }
  // Everything happened, and often.
  for (const auto& [priority, count] : spoken) EXPECT_GT(count, 60) << to_string(priority);
  EXPECT_EQ(spoken.size(), 4u);
  EXPECT_GT(broken_off, 60);
}

// Whatever waits: what is begun is never less urgent than something that is begun after it, where
// nothing was added between.
TEST(PromptQueuePropertyTest, WithoutNewPromptsUrgencyOnlyFalls) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    RandomStream random(seed, {1});
    PromptQueue queue;
    for (int i = 0; i < 8; ++i) {
      Prompt each = random_prompt(random, 0);
      each.replace_key = fmt::format("{}", i);
      each.valid_until_ns = at(1000);
      queue.add(std::move(each), at(0));
    }
    Priority last = Priority::kHazard;
    int count = 0;
    for (double now_s = 0; const auto utterance = queue.next(at(now_s)); now_s += 2) {
      EXPECT_GE(utterance->prompt.priority, last);
      last = utterance->prompt.priority;
      queue.finished(utterance->id, at(now_s + 1));
      ++count;
    }
    EXPECT_EQ(count, 8);
  }
}

}  // namespace
}  // namespace roomwise::guide
