#include "roomwise/live/device/walk_watch.h"

#include <gmock/gmock.h>

namespace roomwise::live {
namespace {

using std::chrono::milliseconds;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

guide::Prompt prompt_of(const std::string& key, const std::string& text,
                        guide::Priority priority = guide::Priority::kAnswer) {
  guide::Prompt prompt;
  prompt.replace_key = key;
  prompt.text = text;
  prompt.priority = priority;
  return prompt;
}

class WalkWatchTest : public ::testing::Test {
 protected:
  void say(const guide::Prompt& prompt) { watch.say({&prompt, 1}, now); }
  [[nodiscard]] bool is_due(bool is_over = false) const { return watch.is_due(walk, is_over, now); }
  [[nodiscard]] std::vector<std::string> said() const {
    std::vector<std::string> texts;
    for (const auto& one : watch.shown(walk).said) texts.push_back(one.text);
    return texts;
  }

  WalkWatch watch;
  WalkWatch::Time now{std::chrono::hours(1)};
  service::WatchedWalk walk{"en", "bed", "on_way", {}, 3.2, {}, {}};
};

TEST_F(WalkWatchTest, PicturesAreShownTwiceASecondAndNewsAtOnce) {
  EXPECT_TRUE(is_due());
  watch.was_shown(walk, now);
  now += milliseconds(499);
  EXPECT_FALSE(is_due());
  say(prompt_of("guide", "Stop."));
  EXPECT_TRUE(is_due()) << "the guide said something";
  watch.was_shown(walk, now);
  EXPECT_FALSE(is_due());
  walk.state = "lost";
  EXPECT_TRUE(is_due());
  watch.was_shown(walk, now);
  now += milliseconds(500);
  EXPECT_TRUE(is_due());
  EXPECT_FALSE(is_due(/*is_over=*/true)) << "where they go after that";
}

TEST_F(WalkWatchTest, OnlyWhatTheGuideSaysAndHazardsAreShown) {
  say(prompt_of("guide", "Straight on."));
  say(prompt_of("people", "I see nobody in front of you."));
  say(prompt_of("obstacle", "Obstacle ahead.", guide::Priority::kHazard));
  say(prompt_of("obstacle", "Obstacle ahead.", guide::Priority::kHazard));
  EXPECT_THAT(said(), ElementsAre("Straight on.", "Obstacle ahead."));
  for (int i = 0; i < 50; ++i) say(prompt_of("guide", fmt::format("{}", i)));
  EXPECT_EQ(said().size(), 20U) << "the newest";
  EXPECT_EQ(said().back(), "49");
}

TEST_F(WalkWatchTest, APlaceIsAsOldAsItsPicture) {
  EXPECT_FALSE(watch.shown(walk).person);
  CameraPose pose;
  pose.plan_from_camera.translation = {1, 2, 1.3};
  pose.sigma_m = 0.1;
  watch.place(pose, now - milliseconds(300));
  const auto person = watch.shown(walk).person;
  ASSERT_TRUE(person);
  EXPECT_EQ(person->x_m, 1);
  EXPECT_EQ(person->y_m, 2);
  EXPECT_EQ(person->sigma_m, 0.1);
  EXPECT_EQ(to_ms(now) - person->t_ms, 300);
}

TEST_F(WalkWatchTest, OfEachWhoWatchesThePersonIsToldOnceWithAllOthers) {
  const service::Identity anna{1, "Anna's laptop", service::Role::kHelper};
  const service::Identity tom{2, "Tom's tablet", service::Role::kHelper};
  EXPECT_THAT(watch.to_tell({&anna, 1}), ElementsAre("Anna's laptop"));
  EXPECT_THAT(watch.to_tell(std::vector{anna, tom}), ElementsAre("Anna's laptop", "Tom's tablet"));
  EXPECT_THAT(watch.to_tell(std::vector{anna, tom}), IsEmpty());
}

}  // namespace
}  // namespace roomwise::live
