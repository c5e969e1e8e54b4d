#include "roomwise/pipeline/mapping/home_floor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "roomwise/base/testing/testing.h"
#include "roomwise/pipeline/testing/mapped_room.h"

namespace roomwise::pipeline {
namespace {

// Counts how often the map is fused.
class CountFused final : public Progress {
 public:
  void begin(std::string_view work, std::optional<std::uint64_t>) override {
    if (work == "fusing the map") ++times;
  }
  void advance(std::uint64_t, std::string_view) override { ++steps; }
  void end() override {}
  [[nodiscard]] bool interrupted() const override { return steps >= stop_at; }

  int times = 0;
  int steps = 0, stop_at = std::numeric_limits<int>::max();
};

class HomeFloorTest : public testing::MappedRoom {
 protected:
  void SetUp() override {
    MappedRoom::SetUp();
    ASSERT_OK(keep_home_floor(*home_, run_));
    fused_.times = 0;
  }

  ThreadPool pool_{2};
  CountFused fused_;
  StageClock clock_;
  RunContext run_{pool_, fused_, clock_};
};

TEST_F(HomeFloorTest, ThatIsKeptIsThereAtOnce) {
  const auto floor = find_home_floor(*home_, run_);
  ASSERT_OK(floor);
  EXPECT_EQ(fused_.times, 0);
  auto map = build_gravity_aligned_map(*home_, {}, run_);
  ASSERT_OK(map);
  const auto fresh = floor_of(*map, run_);
  ASSERT_OK(fresh);
  EXPECT_EQ(floor->frame.has_floor, fresh->frame.has_floor);
  EXPECT_EQ(floor->frame.gravity_from_world.translation,
            fresh->frame.gravity_from_world.translation);
  EXPECT_EQ(floor->frame.gravity_from_world.rotation.coeffs(),
            fresh->frame.gravity_from_world.rotation.coeffs());
  ASSERT_TRUE(floor->grid) << "the room has a floor";
  ASSERT_EQ(floor->grid->columns(), fresh->grid->columns());
  ASSERT_EQ(floor->grid->rows(), fresh->grid->rows());
  EXPECT_EQ(floor->grid->origin_m(), fresh->grid->origin_m());
  for (int row = 0; row < floor->grid->rows(); ++row) {
    for (int column = 0; column < floor->grid->columns(); ++column)
      ASSERT_EQ(floor->grid->at(column, row), fresh->grid->at(column, row));
  }
}

TEST_F(HomeFloorTest, IsTheSameToTheBitInHardlyAnyMemory) {
  const home::DerivedData kept = home_->derived_data("floor").value().value();
  ASSERT_OK(home_->put_derived_data({"floor", "", {}}));
  run_.working_set_bytes = 1;
  ASSERT_OK(keep_home_floor(*home_, run_));
  EXPECT_EQ(fused_.times, 1);
  EXPECT_EQ(home_->derived_data("floor")->value().data, kept.data);
}

TEST_F(HomeFloorTest, ThatIsInterruptedLeavesNothing) {
  ASSERT_OK(home_->put_derived_data({"floor", "", {}}));
  run_.working_set_bytes = 1;
  fused_.stop_at = fused_.steps + 5;
  const auto outcome = keep_home_floor(*home_, run_);
  ASSERT_FALSE(outcome);
  EXPECT_EQ(outcome.error().code, ErrorCode::kInterrupted);
  EXPECT_TRUE(home_->derived_data("floor")->value().data.empty());
  for (const auto& file : std::filesystem::directory_iterator(folder_.path()))
    EXPECT_TRUE(file.path().string().find("scratch") == std::string::npos) << file.path();
}

TEST_F(HomeFloorTest, IsMadeAnewOnceTheMapHasMoved) {
  auto pose = home_->keyframes()->at(3).pose;
  pose.world_from_keyframe.translation.x() += 0.001;
  ASSERT_OK(home_->replace_poses({{3, pose}}));
  ASSERT_OK(find_home_floor(*home_, run_));
  EXPECT_EQ(fused_.times, 1);
  ASSERT_OK(keep_home_floor(*home_, run_));
  EXPECT_EQ(fused_.times, 2);
  ASSERT_OK(keep_home_floor(*home_, run_));
  ASSERT_OK(find_home_floor(*home_, run_));
  EXPECT_EQ(fused_.times, 2) << "it is kept now";
}

TEST_F(HomeFloorTest, ThatIsDamagedIsMadeAnew) {
  auto kept = home_->derived_data("floor").value().value();
  for (const std::size_t size : {std::size_t{0}, std::size_t{5}, kept.data.size() - 1}) {
    home::DerivedData damaged = kept;
    damaged.data.resize(size);
    ASSERT_OK(home_->put_derived_data(damaged));
    fused_.times = 0;
    ASSERT_OK(find_home_floor(*home_, run_));
    EXPECT_EQ(fused_.times, 1);
  }
  ASSERT_OK(keep_home_floor(*home_, run_));
  fused_.times = 0;
  ASSERT_OK(find_home_floor(*home_, run_));
  EXPECT_EQ(fused_.times, 0) << "it is kept whole again";
}

TEST_F(HomeFloorTest, WhoseStairsLeadToNoStoreyIsMadeAnew) {
  using nlohmann::json;
  const json storey{{"floor_m", 0}, {"plan_from_gravity", {0, 0}}, {"plan_from_x_m", 0}};
  const json flight{{"below_plan", {0, 0}},
                    {"above_plan", {1, 0}},
                    {"foot_gravity", {0, 0}},
                    {"top_gravity", {1, 0}},
                    {"up_rad", 0},
                    {"end_rad", 0},
                    {"run_m", 1},
                    {"height_m", 2.7},
                    {"steps", 15},
                    {"width_m", 1},
                    {"left_rail", false},
                    {"right_rail", false}};
  const home::DerivedData kept = home_->derived_data("floor").value().value();
  for (const auto& [lower, times_fused] : {std::pair(0, 0), std::pair(1, 1), std::pair(-1, 1)}) {
    json floor = json::from_cbor(kept.data);
    json stairs = flight;
    stairs["lower"] = lower;
    floor["storeys"] = {{"all", {storey, storey}}, {"stairs", {stairs}}};
    home::DerivedData changed = kept;
    changed.data = json::to_cbor(floor);
    ASSERT_OK(home_->put_derived_data(changed));
    fused_.times = 0;
    ASSERT_OK(find_home_floor(*home_, run_));
    EXPECT_EQ(fused_.times, times_fused) << "stairs up from storey " << lower;
  }
}

TEST_F(HomeFloorTest, ThatAWalkCrossedStaysWhereItsKeyframesAreCulled) {
  // As if nothing of the floor had been seen.
  const auto walked = [&] {
    EXPECT_OK(keep_home_floor(*home_, run_));
    home::DerivedData kept = home_->derived_data("floor").value().value();
    nlohmann::json floor = nlohmann::json::from_cbor(kept.data);
    std::ranges::fill(floor["grid"]["cells"].get_binary(), 0);
    kept.data = nlohmann::json::to_cbor(floor);
    EXPECT_OK(home_->put_derived_data(kept));
    return find_home_floor(*home_, run_)->grid->area_m2(fusion::FloorCell::kFree);
  };
  const double before_m2 = walked();
  EXPECT_GT(before_m2, 1);
  home::KeyframeCulling culling;
  const auto all = home_->keyframes().value();
  const RigidTransform anchor_from_world = all[14].pose.world_from_keyframe.inverse();
  for (const home::KeyframeId id : {15, 16, 17}) {
    culling.culled.push_back(id);
    culling.places.push_back({all[id].recording,
                              all[id].frame_index,
                              {14, anchor_from_world * all[id].pose.world_from_keyframe}});
  }
  ASSERT_OK(home_->cull_keyframes(culling));
  EXPECT_NEAR(walked(), before_m2, 0.01);
}

TEST_F(HomeFloorTest, NeedsAMap) {
  EXPECT_ERROR(find_home_floor(home::Home::create(folder_ / "empty.home").value(), run_),
               "no map yet");
}

}  // namespace
}  // namespace roomwise::pipeline
