#include "roomwise/service/client/device_link.h"

#include <gmock/gmock.h>

namespace roomwise::service {
namespace {

using News = DeviceLink::News;

DeviceLink connected_link() {
  DeviceLink link;
  EXPECT_TRUE(link.begin_try(0));
  EXPECT_EQ(link.connected(), News::kConnected);
  return link;
}

TEST(DeviceLinkTest, WaitsLongerAfterEachTry) {
  DeviceLink link;
  double now_s = 100;
  for (const double wait_s : {0.5, 1.0, 2.0, 4.0, 5.0, 5.0}) {
    EXPECT_TRUE(link.begin_try(now_s));
    EXPECT_FALSE(link.begin_try(now_s));  // it is being tried
    EXPECT_EQ(link.failed(now_s), News::kNone);
    EXPECT_DOUBLE_EQ(*link.next_try_s(), now_s + wait_s);
    EXPECT_FALSE(link.begin_try(now_s + 0.99 * wait_s));
    now_s += wait_s;
  }
  EXPECT_TRUE(link.begin_try(now_s));
  EXPECT_EQ(link.connected(), News::kConnected);
  EXPECT_EQ(link.failed(now_s), News::kLost);
  EXPECT_DOUBLE_EQ(*link.next_try_s(), now_s + 0.5);  // from the start again
}

TEST(DeviceLinkTest, TellsOfALossAndOfTheReturnOnce) {
  DeviceLink link = connected_link();
  EXPECT_EQ(link.failed(10), News::kLost);
  EXPECT_TRUE(link.begin_try(11));
  EXPECT_EQ(link.failed(12), News::kNone);
  EXPECT_TRUE(link.begin_try(13));
  EXPECT_EQ(link.connected(), News::kBack);
  EXPECT_EQ(link.counts().losses, 1u);
}

TEST(DeviceLinkTest, OneFrameIsUnderWayAndTheNewestWaits) {
  DeviceLink link = connected_link();
  EXPECT_FALSE(link.next_frame(0));
  link.offer(1, {1});
  EXPECT_EQ(link.next_frame(0), Bytes{1});
  link.offer(2, {2});
  link.offer(3, {3});
  EXPECT_FALSE(link.next_frame(0));
  link.acknowledged(0.5, 0);  // an earlier one
  EXPECT_FALSE(link.next_frame(0));
  link.acknowledged(1, 0);
  EXPECT_EQ(link.next_frame(0), Bytes{3});
  EXPECT_FALSE(link.next_frame(0));
  EXPECT_EQ(link.counts().sent, 2u);
  EXPECT_EQ(link.counts().replaced, 1u);
}

TEST(DeviceLinkTest, AFrameThatIsNeverAcknowledgedHoldsUpNothingForLong) {
  DeviceLink link = connected_link();
  link.offer(1, {1});
  EXPECT_TRUE(link.next_frame(0));
  link.offer(2, {2});
  EXPECT_FALSE(link.next_frame(9.9));
  EXPECT_FALSE(link.is_slow());
  EXPECT_EQ(link.next_frame(10), Bytes{2});
  EXPECT_TRUE(link.is_slow());
  EXPECT_TRUE(link.take_became_slow());
  EXPECT_FALSE(link.take_became_slow());  // told once
  // A new connection may lead through another network.
  EXPECT_EQ(link.failed(11), News::kLost);
  EXPECT_FALSE(link.is_slow());
}

TEST(DeviceLinkTest, NothingOldIsSentAfterAReturn) {
  DeviceLink link = connected_link();
  link.offer(1, {1});
  EXPECT_TRUE(link.next_frame(0));
  link.offer(2, {2});
  EXPECT_EQ(link.failed(1), News::kLost);
  link.offer(3, {3});
  EXPECT_TRUE(link.begin_try(2));
  EXPECT_EQ(link.connected(), News::kBack);
  EXPECT_FALSE(link.next_frame(2));
  link.offer(4, {4});
  EXPECT_EQ(link.next_frame(2), Bytes{4});
}

// Sends `frames` that take so long each; how often the link became slow.
int send(DeviceLink& link, int frames, double took_s) {
  static double now_s = 0;
  int became_slow = 0;
  for (int i = 0; i < frames; ++i) {
    now_s += 1;
    link.offer(now_s, {1});
    EXPECT_TRUE(link.next_frame(now_s));
    link.acknowledged(now_s, now_s + took_s);
    if (link.take_became_slow()) ++became_slow;
  }
  return became_slow;
}

TEST(DeviceLinkTest, ASlowLinkIsNoticedOnceAndTriedAgainWithCare) {
  DeviceLink link = connected_link();
  EXPECT_EQ(send(link, 50, 0.4), 0);
  EXPECT_FALSE(link.is_slow());
  EXPECT_EQ(send(link, 5, 0.6), 1);
  EXPECT_TRUE(link.is_slow());
  // Small frames are quicker, but not quick.
  EXPECT_EQ(send(link, 500, 0.2), 0);
  EXPECT_TRUE(link.is_slow());
  EXPECT_EQ(send(link, 19, 0.05), 0);
  EXPECT_TRUE(link.is_slow());
  EXPECT_EQ(send(link, 1, 0.05), 0);
  EXPECT_FALSE(link.is_slow());
  // A whole frame is slow again: now it takes twice as many quick ones.
  EXPECT_EQ(send(link, 1, 0.6), 1);
  EXPECT_EQ(send(link, 39, 0.05), 0);
  EXPECT_TRUE(link.is_slow());
  EXPECT_EQ(send(link, 1, 0.05), 0);
  EXPECT_FALSE(link.is_slow());
}

}  // namespace
}  // namespace roomwise::service
