#include "roomwise/rooms/room_calibration.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "roomwise/base/random.h"
#include "roomwise/base/testing.h"

namespace roomwise::rooms {
namespace {

// Pictures of two rooms whose likenesses differ by `advantage`, and a part of which is wrong.
std::vector<HeldOutPicture> held_out(int count, double advantage, int every_wrong) {
  RandomStream random(7);
  std::vector<HeldOutPicture> pictures;
  for (int i = 0; i < count; ++i) {
    HeldOutPicture picture;
    picture.room = i % 2;
    const bool wrong = every_wrong > 0 && i % every_wrong == 0;
    picture.likeness.of_rooms = Eigen::Vector2d::Constant(0.3);
    picture.likeness.of_rooms[wrong ? 1 - picture.room : picture.room] += advantage;
    picture.likeness.finely = 0.4 + 0.1 * random.normal();
    picture.likeness.coarsely = 0.9 + 0.02 * random.normal();
    pictures.push_back(picture);
  }
  return pictures;
}

TEST(Calibrate, ProbabilitiesAreAsHighAsHeldOutPicturesAreRight) {
  // A tenth is wrong, all with the same advantage: the temperature makes it 0.9.
  const auto pictures = held_out(1000, 0.2, 10);
  const RoomCalibration calibration = calibrate(pictures);
  EXPECT_NEAR(calibration.probabilities(pictures[1].likeness).maxCoeff(), 0.9, 0.01);
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
  const double large = calibration.probabilities(pictures[0].likeness).maxCoeff();
  const double small = calibration.probabilities(unsure[1].likeness).maxCoeff();
  EXPECT_GT(calibration.sure_from, small);
  EXPECT_LE(calibration.sure_from, large);
  // Where all are right often enough, all are sure, from a half on.
  EXPECT_LE(calibrate(held_out(200, 0.2, 0)).sure_from,
            calibrate(held_out(200, 0.2, 0)).probabilities(held_out(2, 0.2, 0)[0].likeness)[0]);
}

TEST(Calibrate, KnownIsCountedInDeviationsOfHeldOutPictures) {
  const auto pictures = held_out(2000, 0.2, 0);
  const RoomCalibration calibration = calibrate(pictures);
  EXPECT_NEAR(calibration.finely_mean, 0.4, 0.01);
  EXPECT_NEAR(calibration.coarsely_deviation, 0.02, 0.002);
  int below_known = 0;
  int below_none = 0;
  for (const HeldOutPicture& picture : pictures) {
    const double known = calibration.known(picture.likeness);
    if (known < calibration.known_from) ++below_known;
    if (known < calibration.none_below) ++below_none;
  }
  EXPECT_EQ(below_known, 100);
  EXPECT_EQ(below_none, 20);
  Likeness better = pictures.front().likeness;
  better.finely = calibration.finely_mean + calibration.finely_deviation;
  better.coarsely = calibration.coarsely_mean + 2 * calibration.coarsely_deviation;
  EXPECT_NEAR(calibration.known(better), 1.5 - calibration.usual_of_rooms[0], 1e-9);
}

TEST(Calibrate, KnownIsCountedFromWhatIsUsualInTheRoomThatAPictureLooksMostLike) {
  // A fifth looks most like the other room, which is where it counts.
  auto pictures = held_out(2000, 0.4, 5);
  const auto looks_like = [](const HeldOutPicture& picture) {
    return picture.likeness.of_rooms[1] > picture.likeness.of_rooms[0] ? 1 : 0;
  };
  for (HeldOutPicture& picture : pictures) {
    if (looks_like(picture) == 1) picture.likeness.finely += 0.3;
  }
  const RoomCalibration calibration = calibrate(pictures);
  Eigen::Array2d sums = Eigen::Array2d::Zero();
  for (const HeldOutPicture& picture : pictures) {
    sums[looks_like(picture)] += calibration.known(picture.likeness) / 1000;
  }
  EXPECT_NEAR(sums[0], 0, 0.01);
  EXPECT_NEAR(sums[1], 0, 0.01);
  // The same likenesses, but most like the other room.
  Likeness picture = pictures[1].likeness;
  const double known = calibration.known(picture);
  std::swap(picture.of_rooms[0], picture.of_rooms[1]);
  const double difference = calibration.usual_of_rooms[1] - calibration.usual_of_rooms[0];
  EXPECT_NEAR(difference, 0.83, 0.05) << "half of 0.3 in deviations of 0.18";
  EXPECT_NEAR(std::abs(known - calibration.known(picture)), difference, 1e-9);
}

TEST(Calibrate, ARoomOfFewPicturesIsTakenForAnAverageOne) {
  auto pictures = held_out(2000, 0.4, 0);
  for (HeldOutPicture& picture : pictures) {
    const Eigen::Vector2d two_rooms = picture.likeness.of_rooms;
    picture.likeness.of_rooms = Eigen::Vector4d(two_rooms[0], two_rooms[1], 0.1, 0.1);
  }
  HeldOutPicture rare = pictures[0];
  rare.room = 2;
  rare.likeness.finely = 0.8;
  rare.likeness.of_rooms = Eigen::Vector4d(0.3, 0.3, 0.9, 0.1);
  pictures.push_back(rare);
  const RoomCalibration calibration = calibrate(pictures);
  RoomCalibration plain = calibration;
  plain.usual_of_rooms.clear();
  EXPECT_NEAR(calibration.usual_of_rooms[2], plain.known(rare.likeness) / 6, 1e-9);
  EXPECT_EQ(calibration.usual_of_rooms[3], 0) << "no picture looks like it";
}

TEST(RoomCalibration, NamesTheFieldThatIsWrong) {
  EXPECT_OK(RoomCalibration{}.validate());
  RoomCalibration calibration;
  calibration.temperature = 0;
  EXPECT_ERROR(calibration.validate(), "temperature");
  calibration = {};
  calibration.sure_from = 1.5;
  EXPECT_ERROR(calibration.validate(), "sure_from");
  calibration = {};
  calibration.known_from = std::numeric_limits<double>::quiet_NaN();
  EXPECT_ERROR(calibration.validate(), "known_from");
  calibration = {};
  calibration.usual_of_rooms = {0, std::numeric_limits<double>::infinity()};
  EXPECT_ERROR(calibration.validate(), "usual_of_rooms");
  calibration = {};
  calibration.none_below = 1;
  EXPECT_ERROR(calibration.validate(), "none_below");
}

}  // namespace
}  // namespace roomwise::rooms
