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

TEST(Calibrate, KeepsMeansAndDeviationsOfHeldOutPictures) {
  const RoomCalibration calibration = calibrate(held_out(2000, 0.2, 0));
  EXPECT_NEAR(calibration.whitened_cosine_mean, 0.4, 0.01);
  EXPECT_NEAR(calibration.whitened_cosine_deviation, 0.1, 0.01);
  EXPECT_NEAR(calibration.plain_cosine_mean, 0.9, 0.002);
  EXPECT_NEAR(calibration.plain_cosine_deviation, 0.02, 0.002);
  Similarity better;
  better.whitened_cosine = calibration.whitened_cosine_mean + calibration.whitened_cosine_deviation;
  better.plain_cosine = calibration.plain_cosine_mean + 2 * calibration.plain_cosine_deviation;
  EXPECT_NEAR(calibration.deviations(better), 1.5, 1e-9);
}

TEST(RoomCalibration, NamesTheFieldThatIsWrong) {
  EXPECT_OK(RoomCalibration{}.validate());
  RoomCalibration calibration;
  calibration.temperature = 0;
  EXPECT_ERROR(calibration.validate(), "temperature");
  calibration = {};
  calibration.plain_cosine_mean = std::numeric_limits<double>::quiet_NaN();
  EXPECT_ERROR(calibration.validate(), "plain_cosine_mean");
}

}  // namespace
}  // namespace roomwise::rooms
