#include "roomwise/live/home/recognition_log.h"

#include <gmock/gmock.h>

namespace roomwise::live {
namespace {

using ::testing::SizeIs;

service::Seen seen(const std::string& room) {
  service::Seen seen;
  seen.room_decision = "room";
  seen.room = room;
  return seen;
}

TEST(RecognitionLog, KeepsWhatChangedWhatWasSaidOfADevice) {
  RecognitionLog log;
  const service::Identity phone{1, "phone", service::Role::kDevice};
  const service::Identity belt{2, "belt", service::Role::kDevice};
  log.add(phone, 10, seen("kitchen"), {1});
  log.add(phone, 11, seen("kitchen"), {2});
  log.add(belt, 12, seen("kitchen"), {3});
  log.add(phone, 13, seen("hall"), {4});
  const auto all = log.newest_first();
  ASSERT_THAT(all, SizeIs(3));
  EXPECT_EQ(all[0].seen.room, "hall");
  EXPECT_EQ(all[1].who.device, 2);
  EXPECT_EQ(log.picture(all[0].number), Bytes{4});
  EXPECT_FALSE(log.picture(99));
}

TEST(RecognitionLog, ForgetsTheOldestAndAllWhenAsked) {
  RecognitionLog log;
  const service::Identity phone{1, "phone", service::Role::kDevice};
  for (std::size_t i = 0; i < RecognitionLog::kMax + 5; ++i) {
    log.add(phone, 0, seen(std::to_string(i)), {1});
  }
  EXPECT_THAT(log.newest_first(), SizeIs(RecognitionLog::kMax));
  EXPECT_FALSE(log.picture(1));
  log.clear();
  EXPECT_THAT(log.newest_first(), SizeIs(0));
}

}  // namespace
}  // namespace roomwise::live
