#include "roomwise/rooms/concepts/room_type.h"

#include <gmock/gmock.h>

#include <algorithm>

namespace roomwise::rooms {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

double sum_of(const std::vector<TypePosterior>& guesses) {
  double sum = 0;
  for (const TypePosterior& guess : guesses) sum += guess.probability;
  return sum;
}

TEST(GuessRoomType, ThingsOfATypeSpeakForIt) {
  const auto guesses = classify_room_type({{"bed", 0.95}, {"wardrobe", 0.8}}, Concepts::standard());
  EXPECT_EQ(guesses[0].type, "bedroom");
  EXPECT_GT(guesses[0].probability, 0.75);
  EXPECT_THAT(guesses[0].because, ElementsAre("bed", "wardrobe"));
  EXPECT_NEAR(sum_of(guesses), 1, 1e-12);
}

TEST(GuessRoomType, ADoubtfulThingSaysLittle) {
  const auto kitchen = [](double microwave) {
    const auto guesses = classify_room_type({{"microwave", microwave}}, Concepts::standard());
    return std::ranges::find(guesses, "kitchen", &TypePosterior::type)->probability;
  };
  EXPECT_GT(kitchen(0.95), 0.4);
  EXPECT_LT(kitchen(0.5), 0.3);
}

TEST(GuessRoomType, AnEmptyRoomIsOfNoTypeThatIsKnown) {
  const auto guesses = classify_room_type({}, Concepts::standard());
  EXPECT_EQ(guesses[0].type, kOtherType);
  EXPECT_DOUBLE_EQ(guesses[0].probability, 1);
  EXPECT_THAT(guesses[0].because, IsEmpty());
  EXPECT_EQ(classify_room_type({{"piano", 1}}, Concepts::standard())[0].type, kOtherType)
      << "no type is known to have one";
}

TEST(GuessRoomType, ContradictingThingsLeaveADoubt) {
  const auto guesses = classify_room_type({{"bed", 1}, {"stove", 1}}, Concepts::standard());
  EXPECT_LT(guesses[0].probability, 0.6);
}

TEST(GuessRoomType, LearnsFromTheHomesOwnRooms) {
  const RoomContents study = {{"desk", 0.9}, {"bookcase", 0.9}};
  EXPECT_EQ(classify_room_type(study, Concepts::standard())[0].type, kOtherType);
  const std::vector<TypedContents> examples = {{"study", study}, {"study", study}};
  const auto learned = classify_room_type(study, Concepts::standard(), examples);
  EXPECT_EQ(learned[0].type, "study");
  EXPECT_GT(learned[0].probability, 0.7);
  EXPECT_THAT(learned[0].because, ElementsAre("bookcase", "desk"));
  // A home whose bedrooms have microwaves.
  const RoomContents odd = {{"bed", 1}, {"microwave", 1}};
  const std::vector<TypedContents> bedrooms(4, {"bedroom", odd});
  EXPECT_GT(classify_room_type({{"microwave", 1}}, Concepts::standard(), bedrooms)[1].probability,
            0.05);
  EXPECT_EQ(classify_room_type(odd, Concepts::standard(), bedrooms)[0].type, "bedroom");
}

}  // namespace
}  // namespace roomwise::rooms
