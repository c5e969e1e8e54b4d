#include "roomwise/live/home/work_places.h"

#include <gmock/gmock.h>

#include <atomic>
#include <string>
#include <thread>

#include "roomwise/base/testing/testing.h"

namespace roomwise::live {
namespace {

using Urgency = WorkPlaces::Urgency;

class Stopped final : public Interruption {
 public:
  [[nodiscard]] bool interrupted() const override { return stop; }
  std::atomic<bool> stop{false};
};

// Work in its own thread that notes its name when it has a place.
std::thread work(WorkPlaces& places, Urgency urgency, char name, std::string& done) {
  const std::size_t before = places.waiting();
  std::thread thread([&places, urgency, name, &done] {
    const auto place = places.take(urgency, Interruption());
    ASSERT_OK(place);
    done += name;
  });
  while (places.waiting() == before) std::this_thread::yield();
  return thread;
}

TEST(WorkPlaces, AreAsManyAsThereAre) {
  WorkPlaces places(2);
  const auto first = places.take(Urgency::kCanWait, Interruption());
  ASSERT_OK(first);
  {
    const auto second = places.take(Urgency::kCanWait, Interruption());
    ASSERT_OK(second);
    Stopped stopped;
    stopped.stop = true;
    EXPECT_ERROR(places.take(Urgency::kCanWait, stopped), "interrupted while waiting");
    EXPECT_EQ(places.waiting(), 0u);
  }
  EXPECT_OK(places.take(Urgency::kCanWait, Interruption()));
}

TEST(WorkPlaces, WhatAnswersWaitForComesFirstThenWhoCameFirst) {
  WorkPlaces places(1);
  std::string done;
  std::thread a, b, c;
  {
    const auto place = places.take(Urgency::kCanWait, Interruption());
    ASSERT_OK(place);
    a = work(places, Urgency::kCanWait, 'a', done);
    b = work(places, Urgency::kCanWait, 'b', done);
    c = work(places, Urgency::kAnswersWait, 'c', done);
  }
  a.join();
  b.join();
  c.join();
  EXPECT_EQ(done, "cab");
}

TEST(WorkShare, LeavesAProcessorToAnswers) {
  for (const std::size_t processors : {2u, 3u, 8u, 32u}) {
    for (const std::size_t threads : {1u, 2u, 8u, 32u}) {
      const WorkShare share = share_of_work(processors, threads);
      EXPECT_GE(share.places, 1u);
      EXPECT_GE(share.threads, 1u);
      EXPECT_LE(share.threads, threads);
      EXPECT_LT(share.places * share.threads, processors);
    }
  }
  EXPECT_EQ(share_of_work(8, 2).places, 3u);
  EXPECT_EQ(share_of_work(1, 1).places, 1u);
}

}  // namespace
}  // namespace roomwise::live
