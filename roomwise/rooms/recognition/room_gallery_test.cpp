#include "roomwise/rooms/recognition/room_gallery.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "roomwise/base/random.h"

namespace roomwise::rooms {
namespace {

// Four pictures of each of two rooms with two variants each, around an axis of their room.
class RoomMemoryTest : public ::testing::Test {
 protected:
  RoomMemoryTest() {
    RandomStream random(1);
    for (int room = 0; room < 2; ++room) {
      for (int picture = 0; picture < 4; ++picture) {
        for (int variant = 0; variant < 2; ++variant) {
          std::vector<float> features(8, 0.1F);
          features[static_cast<std::size_t>(room)] = 4;
          features[static_cast<std::size_t>(2 + variant)] = 1;
          for (float& value : features) value += static_cast<float>(0.05 * random.uniform());
          rows_.conservativeResize(rows_.rows() + 1, 8);
          rows_.row(rows_.rows() - 1) = root_features(features);
          room_.push_back(room);
          picture_.push_back(4 * room + picture);
        }
      }
    }
  }
  [[nodiscard]] RoomGallery memory() const { return {rows_, room_, picture_, 2}; }

  Eigen::MatrixXf rows_;
  std::vector<int> room_;
  std::vector<int> picture_;
};

TEST_F(RoomMemoryTest, APictureIsMostAlikeItsOwnRoom) {
  const RoomGallery memory = this->memory();
  const Similarity similarity = memory.compare(rows_.row(0));
  EXPECT_GT(similarity.of_rooms[0], similarity.of_rooms[1] + 0.3);
  EXPECT_DOUBLE_EQ(similarity.whitened_cosine, similarity.of_rooms[0])
      << "its room has the most alike ones";
  EXPECT_GT(similarity.plain_cosine, 0.95);
}

TEST_F(RoomMemoryTest, ARoomIsAsAlikeAsItsThreeMostAlikePictures) {
  // By hand: of each picture its more alike variant, the mean of the best three.
  const RoomGallery memory = this->memory();
  const Eigen::MatrixXf white = memory.space().whitened(memory.projections());
  const Eigen::VectorXf alike = white * white.row(5).transpose();
  for (int room = 0; room < 2; ++room) {
    std::vector<float> pictures;
    for (Eigen::Index i = 8 * room; i < 8 * (room + 1); i += 2) {
      pictures.push_back(std::max(alike[i], alike[i + 1]));
    }
    std::ranges::sort(pictures, std::greater());
    EXPECT_NEAR(memory.compare(rows_.row(5)).of_rooms[room],
                (pictures[0] + pictures[1] + pictures[2]) / 3, 1e-5);
  }
}

TEST_F(RoomMemoryTest, AnUnknownPictureIsLessAlike) {
  const Eigen::VectorXf unknown = root_features(std::vector<float>{0, 0, 0, 0, 0, 0, 5, 5});
  const Similarity known = memory().compare(rows_.row(3));
  const Similarity other = memory().compare(unknown);
  EXPECT_LT(other.whitened_cosine, known.whitened_cosine - 0.3);
  EXPECT_LT(other.plain_cosine, known.plain_cosine - 0.3);
}

TEST_F(RoomMemoryTest, WhatIsAddedMakesItsLikeKnownAndForgetsNothing) {
  // A look of the second room that it was not learned in.
  const Eigen::VectorXf other = root_features(std::vector<float>{0, 3, 0, 0, 0.1F, 3, 0.1F, 0.1F});
  Eigen::MatrixXf more(3, 8);
  for (Eigen::Index i = 0; i < 3; ++i) more.row(i) = other;
  const RoomGallery before = memory();
  const RoomGallery after = before.with(more, std::vector<int>{1, 1, 1});
  EXPECT_LT(before.compare(other).whitened_cosine, 0.9);
  EXPECT_NEAR(after.compare(other).whitened_cosine, 1, 1e-4);
  EXPECT_NEAR(after.compare(other).of_rooms[1], 1, 1e-4);
  EXPECT_NEAR(after.compare(other).of_rooms[0], before.compare(other).of_rooms[0], 1e-6);
  for (Eigen::Index i = 0; i < rows_.rows(); ++i) {
    const Similarity then = before.compare(rows_.row(i));
    const Similarity now = after.compare(rows_.row(i));
    for (int room = 0; room < 2; ++room) {
      EXPECT_GE(now.of_rooms[room], then.of_rooms[room] - 1e-6) << i;
    }
  }
  EXPECT_EQ(after.projections().topRows(before.projections().rows()), before.projections());
  EXPECT_EQ(before.with(Eigen::MatrixXf(0, 8), {}).projections(), before.projections());
  EXPECT_THROW((void)before.with(more, std::vector<int>{1, 1}), std::invalid_argument);
  EXPECT_THROW((void)before.with(more, std::vector<int>{1, 1, 2}), std::invalid_argument);
}

TEST_F(RoomMemoryTest, RefusesNumbersOutOfRange) {
  auto rooms = room_;
  rooms[3] = 2;
  EXPECT_THROW(RoomGallery(rows_, rooms, picture_, 2), std::invalid_argument);
  auto pictures = picture_;
  pictures[15] = 9;
  EXPECT_THROW(RoomGallery(rows_, room_, pictures, 2), std::invalid_argument);
  pictures.pop_back();
  EXPECT_THROW(RoomGallery(rows_, room_, pictures, 2), std::invalid_argument);
}

}  // namespace
}  // namespace roomwise::rooms
