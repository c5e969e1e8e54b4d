#include "laboratory/trials/room_fitting.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::trials {
namespace {

// A home of two rooms, told well by the regression (right of `regression`), hardly by similarity.
RoomCase made_up(const std::string& name, bool is_real, double regression, std::uint64_t seed) {
  RandomStream random(seed);
  RoomCase one{name, name, is_real, "net", {"hall", "kitchen"}, {}, {}};
  one.calibration.temperature = 0.1;
  one.calibration.whitened_cosine_mean = 0.5 + 0.1 * random.uniform();
  for (int i = 0; i < 400; ++i) {
    const bool is_known = i % 2 == 0;
    const int room = i % 4 / 2;
    SeenPicture picture;
    picture.room = is_known ? room : -1;
    const double told = random.uniform() < regression ? 0.9 : 0.1;
    picture.regression = Eigen::Vector2d(room == 0 ? told : 1 - told, room == 0 ? 1 - told : told);
    picture.similarity.of_rooms =
        Eigen::Vector2d(0.3, 0.3) + 0.1 * Eigen::Vector2d(random.normal(), random.normal());
    picture.similarity.whitened_cosine = 0.4 + 0.05 * random.normal();
    picture.similarity.plain_cosine = (is_known ? 0.95 : 0.85) + 0.02 * random.normal();
    one.pictures.push_back(picture);
  }
  return one;
}

class FitRooms : public ::testing::Test {
 protected:
  FitRooms() : cases_{made_up("office", true, 0.97, 1), made_up("flat", false, 0.97, 2)} {}
  [[nodiscard]] Expected<rooms::RoomModel> fit(const RoomFittingOptions& options = {},
                                               const std::string& network = "net") const {
    return fit_rooms(std::vector<const RoomCase*>{&cases_[0], &cases_[1]}, network, options);
  }
  std::vector<RoomCase> cases_;
};

TEST_F(FitRooms, BelievesWhatTellsTheRooms) {
  const auto model = fit();
  ASSERT_OK(model);
  EXPECT_GT(model->regression_weight, 0.5);
  EXPECT_LT(std::abs(model->similarity_weight), 0.3) << "it says nothing";
  EXPECT_GT(model->weights[0], 0) << "plain cosine tells this home from others";
}

TEST_F(FitRooms, ProbabilitiesAreAsHighAsAnswersAreRight) {
  const auto model = fit();
  ASSERT_OK(model);
  // What the regression says is believed as often as it is right.
  double believed = 0, right = 0;
  for (const RoomCase& one : cases_) {
    for (const SeenPicture& picture : one.pictures) {
      if (picture.room < 0) continue;
      Eigen::Index said = 0;
      picture.regression.maxCoeff(&said);
      believed +=
          model->probabilities(picture.similarity, picture.regression, one.calibration)[said];
      right += said == picture.room ? 1 : 0;
    }
  }
  EXPECT_LT(right, 400);
  EXPECT_NEAR(believed, right, 0.01);
}

TEST_F(FitRooms, NamesAsRightlyAsIsAskedAndFewOfOtherPlaces) {
  for (const double precision : {0.9, 0.97}) {
    const auto model = fit({.min_precision = precision, .max_elsewhere_named = 0.02});
    ASSERT_OK(model);
    for (const RoomCase& one : cases_) {
      const RoomCounts counts = counts_of(one, *model);
      EXPECT_EQ(counts.known, 200u);
      EXPECT_GE(static_cast<double>(counts.named_right),
                precision * static_cast<double>(counts.named));
      EXPECT_LE(counts.elsewhere_named, 4u);
    }
  }
}

TEST_F(FitRooms, RefusesAHomeOfAnotherNetwork) {
  EXPECT_ERROR(fit({}, "other"), "case \"office\" was learned on net, not on other");
}

TEST_F(FitRooms, ReadsTheEvidenceThatItWrote) {
  const roomwise::testing::ScratchFolder folder;
  const auto file = folder.path() / "evidence.jsonl";
  ASSERT_OK(write_file(file, evidence_json(cases_[0]) + "\n" + evidence_json(cases_[1]) + "\n"));
  const auto read = read_room_evidence(file);
  ASSERT_OK(read);
  const auto model = fit_rooms(std::vector<const RoomCase*>{&read->at(0), &read->at(1)}, "net", {});
  EXPECT_EQ(model->bias, fit()->bias);
  ASSERT_OK(write_file(file, evidence_json(cases_[0]) + "\n{}\n"));
  EXPECT_ERROR(read_room_evidence(file), "evidence.jsonl:2: ");
}

TEST_F(FitRooms, NeedsPicturesOfTheRoomsAndOfOtherPlaces) {
  std::erase_if(cases_[1].pictures, [](const SeenPicture& picture) { return picture.room < 0; });
  EXPECT_ERROR(fit(), "case \"flat\" has 200 pictures of its rooms and 0 of other places");
}

TEST_F(FitRooms, WritesWhatTheProgramReads) {
  const auto model = fit();
  ASSERT_OK(model);
  const auto any = fit({}, "");
  ASSERT_OK(any);
  EXPECT_EQ(any->weights[0], 0) << "a cosine means nothing in another network";
  EXPECT_LT(any->weights[3], 0);
  const std::string text = to_json(std::vector{*model, *any}, cases_, {});
  const auto read = rooms::parse_room_models(text);
  ASSERT_OK(read);
  EXPECT_NEAR(read->at(0).regression_weight, model->regression_weight, 1e-4);
  EXPECT_NEAR(read->at(1).bias, any->bias, 1e-4);
  EXPECT_EQ(nlohmann::json::parse(text)["fitted_on"][0]["name"], "office");
}

TEST(ReadRoomStudy, NamesTheCaseThatIsWrong) {
  const roomwise::testing::ScratchFolder folder;
  const auto file = folder.path() / "study.json";
  ASSERT_OK(write_file(file, R"({"cases": [{"name": "a", "source": "a", "real": true, "home":
      "a.home", "known": [{"folder": "walk", "visits": "2-"}], "elsewhere": ["photos"]}, {}]})"));
  EXPECT_ERROR(read_room_study(file), "case 2");
  ASSERT_OK(write_file(file, R"({"cases": [{"name": "a", "source": "b", "real": true, "home":
      "a.home", "known": [{"folder": "walk", "visits": "2-"}], "elsewhere": ["photos"]}]})"));
  const auto study = read_room_study(file);
  ASSERT_OK(study);
  EXPECT_EQ(study->at(0).home, folder.path() / "a.home");
  EXPECT_EQ(study->at(0).tests.at(0).visits, "2-");
  EXPECT_TRUE(study->at(0).tests.at(1).is_elsewhere);
}

}  // namespace
}  // namespace roomwise::trials
