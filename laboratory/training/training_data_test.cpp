#include "laboratory/training/training_data.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <set>

#include "laboratory/training/batch_loader.h"
#include "laboratory/training/testing/small_data.h"
#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/image/codec.h"

namespace roomwise::training {
namespace {

using roomwise::testing::ScratchFolder;

TEST(PictureFolder, HasAClassAFolder) {
  const ScratchFolder folder;
  EXPECT_ERROR(PictureFolder::open(folder / "nowhere"), "nowhere: cannot be read");
  std::filesystem::create_directories(folder / "kitchen");
  std::filesystem::create_directories(folder / "bath");
  std::filesystem::create_directories(folder / "empty");
  EXPECT_ERROR(PictureFolder::open(folder.path()), "pictures of 0 classes; expected one folder");
  const testing::SmallData pictures(3);
  const auto put = [&](const char* name, std::size_t i) {
    ASSERT_OK(write_file(folder / name, image::encode_png(*pictures.picture(i))));
  };
  put("kitchen/2.png", 0);
  put("kitchen/1.PNG", 1);
  EXPECT_ERROR(PictureFolder::open(folder.path()), "pictures of 1 classes");
  put("bath/3.png", 2);
  ASSERT_OK(write_file(folder / "bath/notes.txt", "no picture"));
  std::filesystem::create_directories(folder / ".thumbnails");
  put(".thumbnails/1.png", 0);
  const auto data = PictureFolder::open(folder.path());
  ASSERT_OK(data);
  EXPECT_THAT(data->classes(), ::testing::ElementsAre("bath", "kitchen"));
  ASSERT_EQ(data->size(), 3);
  EXPECT_EQ(data->label(0), 0);
  EXPECT_EQ(data->label(2), 1);
  EXPECT_EQ(data->name(2), "kitchen/2.png");
  EXPECT_EQ(data->picture(1)->pixels()[7].r, pictures.picture(1)->pixels()[7].r);
  ASSERT_OK(write_file(folder / "bath/3.png", "torn"));
  EXPECT_ERROR(data->picture(0), "bath/3.png");

  const auto numbered =
      (*PictureFolder::open(folder.path())).with_classes({"attic", "kitchen", "bath"});
  ASSERT_OK(numbered);
  EXPECT_EQ(numbered->classes().size(), 3);
  EXPECT_EQ(numbered->label(0), 2) << "the bath";
  EXPECT_EQ(numbered->name(2), "kitchen/2.png");
  EXPECT_ERROR((*PictureFolder::open(folder.path())).with_classes({"attic", "bath"}),
               "has the class \"kitchen\", which is none of attic, bath");
}

TEST(SplitData, HoldsAShareOfEachClassOut) {
  const testing::SmallData data(40);
  const DataSplit split = split_data(data, 0.25, 7);
  EXPECT_EQ(split.training.size(), 28);
  ASSERT_EQ(split.held_out.size(), 12);
  std::vector<std::size_t> counts(4);
  for (std::size_t i = 0; i < split.held_out.size(); ++i) ++counts[split.held_out.label(i)];
  EXPECT_THAT(counts, ::testing::Each(3));
  EXPECT_EQ(split_data(data, 0, 7).held_out.size(), 0);
  EXPECT_EQ(split_data(data, 0.01, 7).held_out.size(), 4);
  // Two pictures of the first class, one of each other one.
  const testing::SmallData few(5);
  const DataSplit of_few = split_data(few, 0.9, 7);
  EXPECT_EQ(of_few.training.size(), 4);
  EXPECT_EQ(of_few.held_out.size(), 1);
}

TEST(SampleOrder, ShowsEveryPictureOnceAnEpoch) {
  SampleOrder order(7, 1), other(7, 2);
  std::vector<std::size_t> first, second, others;
  for (std::uint64_t n = 0; n < 7; ++n) {
    first.push_back(order.sample(n).picture);
    others.push_back(other.sample(n).picture);
  }
  for (std::uint64_t n = 7; n < 14; ++n) {
    EXPECT_EQ(order.sample(n).epoch, 1);
    second.push_back(order.sample(n).picture);
  }
  EXPECT_EQ(std::set(first.begin(), first.end()).size(), 7);
  EXPECT_EQ(std::set(second.begin(), second.end()).size(), 7);
  EXPECT_NE(first, second);
  EXPECT_NE(first, others);
  EXPECT_EQ(order.sample(3).picture, first[3]);
}

TEST(BatchLoader, GivesTheSameToAnyNumberOfThreadsAndProcesses) {
  const testing::SmallData data(10);
  const network::ModelCard card = testing::small_card();
  BatchLoaderOptions options;
  options.batch = 4;
  options.seed = 2;
  BatchLoader one(data, card, options, 0);
  ASSERT_OK(one.next());
  const auto expected = one.next();
  ASSERT_OK(expected);
  options.threads = 3;
  BatchLoader later(data, card, options, 1);
  EXPECT_EQ(later.next()->pictures, expected->pictures);
  // Two processes with half of it each.
  options.batch = 2;
  options.processes = 2;
  std::vector<float> together;
  std::vector<std::int64_t> labels;
  for (options.rank = 0; options.rank < 2; ++options.rank) {
    const auto half = BatchLoader(data, card, options, 1).next();
    ASSERT_OK(half);
    together.insert(together.end(), half->pictures.begin(), half->pictures.end());
    labels.insert(labels.end(), half->labels.begin(), half->labels.end());
  }
  EXPECT_EQ(together, expected->pictures);
  EXPECT_EQ(labels, expected->labels);
}

TEST(LearningRate, FollowsItsSchedule) {
  LearningRate rate{.base = 0.1, .schedule = LearningRate::Schedule::kConstant};
  EXPECT_DOUBLE_EQ(rate.at(99, 100), 0.1);
  rate.warm_up_steps = 4;
  EXPECT_DOUBLE_EQ(rate.at(0, 100), 0.025);
  EXPECT_DOUBLE_EQ(rate.at(3, 100), 0.1);
  rate = {.base = 0.1,
          .schedule = LearningRate::Schedule::kSteps,
          .decay_every = 10,
          .decay = 0.5,
          .warm_up_steps = 0};
  EXPECT_DOUBLE_EQ(rate.at(9, 100), 0.1);
  EXPECT_DOUBLE_EQ(rate.at(25, 100), 0.025);
  rate.schedule = LearningRate::Schedule::kCosine;
  EXPECT_DOUBLE_EQ(rate.at(0, 100), 0.1);
  EXPECT_NEAR(rate.at(50, 100), 0.05, 1e-12);
  EXPECT_LT(rate.at(99, 100), 1e-4);
}

}  // namespace
}  // namespace roomwise::training
