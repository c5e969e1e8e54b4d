#include "roomwise/live/home/lens_memory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::live {
namespace {

mapping::LensCalibration lens(double focal) {
  motion::IntrinsicsEstimate lens = motion::IntrinsicsEstimate::typical_of_phones();
  lens.mean << std::log(focal), -0.02;
  lens.information << 4000, 30, 30, 900;
  return mapping::LensCalibration(lens);
}
double focal(const mapping::LensCalibration& lens) {
  return std::exp(lens.known().mean[0]);
}

class LensMemoryTest : public ::testing::Test {
 protected:
  [[nodiscard]] std::unique_ptr<LensMemory> open() const {
    auto memory = LensMemory::open(file_);
    EXPECT_OK(memory);
    return memory ? *std::move(memory) : nullptr;
  }
  testing::ScratchFolder folder_;
  const std::filesystem::path file_ = folder_ / "a.home.lenses.json";
};

TEST_F(LensMemoryTest, KnowsNothingOfANewDevice) {
  const auto memory = open();
  EXPECT_EQ(memory->recall(1, "back").known().mean,
            motion::IntrinsicsEstimate::typical_of_phones().mean);
  ASSERT_OK(memory->save());
  EXPECT_FALSE(std::filesystem::exists(file_)) << "nothing was learned";
}

TEST_F(LensMemoryTest, KeepsWhatWasLearnedOfEachLensOverARestart) {
  const auto before = open();
  before->learn(1, "back", lens(0.8));
  before->learn(1, "wide", lens(0.4));
  before->learn(2, "back", lens(0.7));
  before->learn(1, "back", lens(0.81));
  ASSERT_OK(before->save());
  const auto after = open();
  EXPECT_EQ(after->recall(1, "back").known().mean, lens(0.81).known().mean);
  EXPECT_EQ(after->recall(1, "back").known().information, lens(0.81).known().information);
  EXPECT_EQ(after->recall(1, "wide").known().mean, lens(0.4).known().mean);
  EXPECT_EQ(after->recall(2, "back").known().mean, lens(0.7).known().mean);
  EXPECT_EQ(after->recall(2, "wide").known().mean,
            motion::IntrinsicsEstimate::typical_of_phones().mean);
}

TEST_F(LensMemoryTest, ADeviceThatNamesEverNewLensesFillsNothing) {
  const auto memory = open();
  memory->learn(2, "back", lens(0.7));
  for (int i = 0; i < 100; ++i) {
    memory->learn(1, "lens " + std::to_string(i), lens(0.5 + 0.001 * i));
    if (i == 50) {
      ASSERT_OK(memory->save());
    }
  }
  EXPECT_NEAR(focal(memory->recall(1, "lens 99")), 0.599, 1e-9);
  EXPECT_NEAR(focal(memory->recall(1, "lens 92")), 0.592, 1e-9);
  EXPECT_EQ(memory->recall(1, "lens 91").known().mean,
            motion::IntrinsicsEstimate::typical_of_phones().mean);
  EXPECT_NEAR(focal(memory->recall(2, "back")), 0.7, 1e-9);
}

TEST_F(LensMemoryTest, ForgetsAllAndTheFile) {
  const auto memory = open();
  memory->learn(1, "back", lens(0.8));
  ASSERT_OK(memory->save());
  ASSERT_OK(memory->forget());
  EXPECT_FALSE(std::filesystem::exists(file_));
  EXPECT_EQ(memory->recall(1, "back").known().mean,
            motion::IntrinsicsEstimate::typical_of_phones().mean);
}

// A quarter turn and a metre between views.
geometry::RigidTransform view(int number) {
  return {Eigen::Quaterniond(
              Eigen::AngleAxisd(number * std::numbers::pi / 2, Eigen::Vector3d::UnitY())),
          {1.0 * number, 0.25, -2}};
}

TEST_F(LensMemoryTest, KeepsTheViewsThatWereCountedOverARestart) {
  const auto before = open();
  before->learn(1, "back", mapping::LensCalibration(lens(0.8).known(), {view(0), view(1)}));
  ASSERT_OK(before->save());
  const auto counted = open()->recall(1, "back").counted();
  ASSERT_EQ(counted.size(), 2U);
  for (int i = 0; i < 2; ++i) {
    const auto off = counted[static_cast<std::size_t>(i)].inverse() * view(i);
    EXPECT_LT(off.distance_m(), 1e-3);
    EXPECT_LT(off.angle_rad(), 1e-3);
  }
}

constexpr const char* kLensText =
    R"({"device": 1, "lens": "a", "log_focal": 0, "k1": 0, "information": [1,0,1])";

TEST_F(LensMemoryTest, ReadsAFileWithoutViews) {
  ASSERT_OK(write_file(file_, std::string(R"({"lenses": [)") + kLensText + "}]}"));
  const auto memory = open();
  EXPECT_FALSE(memory->set_aside());
  EXPECT_EQ(memory->recall(1, "a").known().mean[0], 0);
  EXPECT_TRUE(memory->recall(1, "a").counted().empty());
}

TEST_F(LensMemoryTest, SetsADamagedFileAsideAndGoesOn) {
  const std::string lens_text = kLensText;
  for (const std::string& text :
       {std::string("{"), std::string("[]"), std::string(), lens_text,
        std::string(R"({"lenses": [{"device": 1, "lens": "a"}]})"),
        std::string(R"({"lenses": [{"device": 1, "lens": "a", "log_focal": 0, "k1": 0, )"
                    R"("information": [0,0,0]}]})"),
        std::string(R"({"lenses": [{"device": 1, "lens": "a", "log_focal": 1000, "k1": 0, )"
                    R"("information": [1,0,1]}]})"),
        R"({"lenses": [)" + lens_text + R"(, "views": [[1, 2]]}]})",
        R"({"lenses": [)" + lens_text + R"(, "views": [[1, 2, 3, 0, 0, 0, 0]]}]})",
        R"({"lenses": [)" + lens_text + R"(}, {"device": 2, "le)"}) {
    ASSERT_OK(write_file(file_, text));
    const auto memory = open();
    ASSERT_NE(memory, nullptr);
    ASSERT_TRUE(memory->set_aside()) << text;
    EXPECT_THAT(*memory->set_aside(),
                ::testing::AllOf(::testing::HasSubstr("a.home.lenses.json: is damaged: "),
                                 ::testing::HasSubstr("it is now "),
                                 ::testing::HasSubstr("lenses are learned anew")));
    EXPECT_EQ(memory->recall(1, "a").known().mean,
              motion::IntrinsicsEstimate::typical_of_phones().mean)
        << "nothing of it is believed";
    EXPECT_FALSE(std::filesystem::exists(file_));
    EXPECT_EQ(read_text_file(file_.string() + ".damaged").value(), text);
    EXPECT_FALSE(open()->set_aside()) << "the next time all is well";
    memory->learn(1, "back", lens(0.8));
    ASSERT_OK(memory->save());
    EXPECT_NEAR(focal(open()->recall(1, "back")), 0.8, 1e-9);
  }
  ASSERT_OK(open()->forget());
  EXPECT_FALSE(std::filesystem::exists(file_.string() + ".damaged"));
}

}  // namespace
}  // namespace roomwise::live
