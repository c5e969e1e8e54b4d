#include "roomwise/rooms/recognition/room_calibration.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::rooms {
namespace {

// Pictures of two rooms whose similarities differ by `advantage`, and a part of which is wrong.
std::vector<HeldOutPicture> held_out(int count, double advantage, int every_wrong) {
  RandomStream random(7);
  std::vector<HeldOutPicture> pictures;
  for (int i = 0; i < count; ++i) {
    HeldOutPicture picture;
    picture.room = i % 2;
    const bool wrong = every_wrong > 0 && i % every_wrong == 0;
    picture.similarity.of_rooms = Eigen::Vector2d::Constant(0.3);
    picture.similarity.of_rooms[wrong ? 1 - picture.room : picture.room] += advantage;
    picture.similarity.whitened_cosine = 0.4 + 0.1 * random.normal();
    picture.similarity.plain_cosine = 0.9 + 0.02 * random.normal();
    pictures.push_back(picture);
  }
  return pictures;
}

TEST(Calibrate, ProbabilitiesAreAsHighAsHeldOutPicturesAreRight) {
  // A tenth is wrong, all with the same advantage: the temperature makes it 0.9.
  const auto pictures = held_out(1000, 0.2, 10);
  const RoomCalibration calibration = calibrate(pictures);
  EXPECT_NEAR(calibration.probabilities(pictures[1].similarity).maxCoeff(), 0.9, 0.01);
  EXPECT_NEAR(calibration.temperature, 0.2 / std::log(9), 0.005);
}

TEST(Calibrate, NeverIsSurerThanTheColdestTemperature) {
  EXPECT_DOUBLE_EQ(calibrate(held_out(100, 0.2, 0)).temperature, 0.03);
}

TEST(Calibrate, SurePicturesAreRightOftenEnough) {
  // 100 pictures with a large advantage, all right; 100 with a small one, of which a third is
  // wrong: only the former are sure.
  auto pictures = held_out(100, 0.3, 0);
  const auto unsure = held_out(100, 0.1, 3);
  pictures.insert(pictures.end(), unsure.begin(), unsure.end());
  const RoomCalibration calibration = calibrate(pictures);
  const double large = calibration.probabilities(pictures[0].similarity).maxCoeff();
  const double small = calibration.probabilities(unsure[1].similarity).maxCoeff();
  EXPECT_GT(calibration.confidence_threshold, small);
  EXPECT_LE(calibration.confidence_threshold, large);
  // Where all are right often enough, all are sure, from a half on.
  EXPECT_LE(calibrate(held_out(200, 0.2, 0)).confidence_threshold,
            calibrate(held_out(200, 0.2, 0)).probabilities(held_out(2, 0.2, 0)[0].similarity)[0]);
}

TEST(Calibrate, KnownIsCountedInDeviationsOfHeldOutPictures) {
  const auto pictures = held_out(2000, 0.2, 0);
  const RoomCalibration calibration = calibrate(pictures);
  EXPECT_NEAR(calibration.whitened_cosine_mean, 0.4, 0.01);
  EXPECT_NEAR(calibration.plain_cosine_deviation, 0.02, 0.002);
  int below_known = 0;
  int below_none = 0;
  for (const HeldOutPicture& picture : pictures) {
    const double known = calibration.familiarity(picture.similarity);
    if (known < calibration.acceptance_threshold) ++below_known;
    if (known < calibration.reject_threshold) ++below_none;
  }
  EXPECT_EQ(below_known, 100);
  EXPECT_EQ(below_none, 20);
  Similarity better = pictures.front().similarity;
  better.whitened_cosine = calibration.whitened_cosine_mean + calibration.whitened_cosine_deviation;
  better.plain_cosine = calibration.plain_cosine_mean + 2 * calibration.plain_cosine_deviation;
  EXPECT_NEAR(calibration.familiarity(better), 1.5 - calibration.room_familiarity_means[0], 1e-9);
}

TEST(Calibrate, KnownIsCountedFromWhatIsUsualInTheRoomThatAPictureLooksMostLike) {
  // A fifth looks most like the other room, which is where it counts.
  auto pictures = held_out(2000, 0.4, 5);
  const auto looks_like = [](const HeldOutPicture& picture) {
    return picture.similarity.of_rooms[1] > picture.similarity.of_rooms[0] ? 1 : 0;
  };
  for (HeldOutPicture& picture : pictures) {
    if (looks_like(picture) == 1) picture.similarity.whitened_cosine += 0.3;
  }
  const RoomCalibration calibration = calibrate(pictures);
  Eigen::Array2d sums = Eigen::Array2d::Zero();
  for (const HeldOutPicture& picture : pictures) {
    sums[looks_like(picture)] += calibration.familiarity(picture.similarity) / 1000;
  }
  EXPECT_NEAR(sums[0], 0, 0.01);
  EXPECT_NEAR(sums[1], 0, 0.01);
  // The same similarities, but most like the other room.
  Similarity picture = pictures[1].similarity;
  const double known = calibration.familiarity(picture);
  std::swap(picture.of_rooms[0], picture.of_rooms[1]);
  const double difference =
      calibration.room_familiarity_means[1] - calibration.room_familiarity_means[0];
  EXPECT_NEAR(difference, 0.83, 0.05) << "half of 0.3 in deviations of 0.18";
  EXPECT_NEAR(std::abs(known - calibration.familiarity(picture)), difference, 1e-9);
}

TEST(Calibrate, ARoomOfFewPicturesIsTakenForAnAverageOne) {
  auto pictures = held_out(2000, 0.4, 0);
  for (HeldOutPicture& picture : pictures) {
    const Eigen::Vector2d two_rooms = picture.similarity.of_rooms;
    picture.similarity.of_rooms = Eigen::Vector4d(two_rooms[0], two_rooms[1], 0.1, 0.1);
  }
  HeldOutPicture rare = pictures[0];
  rare.room = 2;
  rare.similarity.whitened_cosine = 0.8;
  rare.similarity.of_rooms = Eigen::Vector4d(0.3, 0.3, 0.9, 0.1);
  pictures.push_back(rare);
  const RoomCalibration calibration = calibrate(pictures);
  RoomCalibration plain = calibration;
  plain.room_familiarity_means.clear();
  EXPECT_NEAR(calibration.room_familiarity_means[2], plain.familiarity(rare.similarity) / 6, 1e-9);
  EXPECT_EQ(calibration.room_familiarity_means[3], 0) << "no picture looks like it";
}

TEST(RoomCalibration, NamesTheFieldThatIsWrong) {
  EXPECT_OK(RoomCalibration{}.validate());
  RoomCalibration calibration;
  calibration.temperature = 0;
  EXPECT_ERROR(calibration.validate(), "temperature");
  calibration = {};
  calibration.confidence_threshold = 1.5;
  EXPECT_ERROR(calibration.validate(), "confidence_threshold");
  calibration = {};
  calibration.acceptance_threshold = std::numeric_limits<double>::quiet_NaN();
  EXPECT_ERROR(calibration.validate(), "acceptance_threshold");
  calibration = {};
  calibration.room_familiarity_means = {0, std::numeric_limits<double>::infinity()};
  EXPECT_ERROR(calibration.validate(), "room_familiarity_means");
  calibration = {};
  calibration.reject_threshold = 1;
  EXPECT_ERROR(calibration.validate(), "reject_threshold");
}

}  // namespace
}  // namespace roomwise::rooms
