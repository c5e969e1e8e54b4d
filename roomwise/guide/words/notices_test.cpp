#include "roomwise/guide/words/notices.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/guide/testing/test_times.h"

namespace roomwise::guide {
namespace {

class NoticesTest : public ::testing::Test {
 protected:
  [[nodiscard]] Prompt said(const std::string& key, const std::string& text,
                            TimestampNs valid_until_ns) const {
    Prompt prompt;
    prompt.replace_key = key;
    prompt.text = text;
    prompt.language = "en";
    prompt.valid_until_ns = valid_until_ns;
    return prompt;
  }

  const MessageCatalogue catalogue_ = MessageCatalogue::built_in();
  const Wording english_{&catalogue_, {}};
  const Wording german_{&catalogue_, {.language = "de"}};
};

TEST_F(NoticesTest, NoticesOfOneMatterHaveOneKey) {
  const Prompt lost = notice_prompt("device.connection_lost", Sound::kLost, english_, 0);
  EXPECT_EQ(lost.replace_key, "device.connection");
  EXPECT_EQ(lost.replace_key,
            notice_prompt("device.connection_back", Sound::kBack, english_, 0).replace_key);
  EXPECT_EQ(lost.text, "The connection is lost.");
  EXPECT_EQ(lost.priority, Priority::kNotice);
  EXPECT_EQ(lost.sound, Sound::kLost);
}

TEST_F(NoticesTest, WhatStillHoldsIsRepeatedAsItWas) {
  const Said last{{said("room", "You are in the hall.", 3 * kSecond)}, 0};
  const auto prompts = repeat_prompts(last, german_, 2 * kSecond);
  ASSERT_EQ(prompts.size(), 1u);
  EXPECT_EQ(prompts[0].text, "You are in the hall.");
  EXPECT_EQ(prompts[0].replace_key, "repeat");
  EXPECT_EQ(prompts[0].priority, Priority::kAnswer);
  EXPECT_EQ(prompts[0].valid_until_ns, 3 * kSecond);
}

TEST_F(NoticesTest, WhatIsPastItsTimeSaysSo) {
  const Said last{{said("around", "Bed at 2 o'clock.", 3 * kSecond),
                   said("around/2", "Lamp at 3 o'clock.", 6 * kSecond)},
                  0};
  const auto prompts = repeat_prompts(last, german_, 4 * kSecond);
  ASSERT_EQ(prompts.size(), 2u);
  EXPECT_EQ(prompts[0].text, "Earlier: Bed at 2 o'clock.");
  EXPECT_EQ(prompts[0].confidence, Confidence::kUnsure);
  EXPECT_GT(prompts[0].valid_until_ns, 4 * kSecond);
  // It would be past its time when the first one has been spoken.
  EXPECT_EQ(prompts[1].text, "Earlier: Lamp at 3 o'clock.");
  EXPECT_EQ(prompts[1].replace_key, "repeat/2");
}

TEST_F(NoticesTest, WhatIsOldOrWasNeverSaidIsNotRepeated) {
  const Said last{{said("room", "You are in the hall.", 3 * kSecond)}, 0};
  EXPECT_EQ(repeat_prompts(last, english_, 61 * kSecond).at(0).message_id, "repeat.too_old");
  EXPECT_EQ(repeat_prompts(std::nullopt, english_, kSecond).at(0).message_id, "repeat.nothing");
}

}  // namespace
}  // namespace roomwise::guide
