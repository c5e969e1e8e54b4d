#include "laboratory/simulation/recording/simulate_views.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/image/codec.h"

namespace roomwise::simulation {
namespace {

using roomwise::testing::ScratchFolder;

// One very small home, one picture of each kind and room, as cheap as can be.
ViewsOptions few_views() {
  ViewsOptions options;
  options.first_home = 3;
  options.last_home = 3;
  options.rooms = {RoomKind::kToilet};
  options.views = {.seed = 0, .of_kind = 1, .of_room = 1, .longer_side_px = 48};
  options.render = {.samples_per_pixel = 1, .bake_effort = 0.02, .light_cache = {}};
  return options;
}

// Stops after a number of homes.
class ImpatientProgress final : public Progress {
 public:
  void begin(std::string_view, std::optional<std::uint64_t>) override {}
  void advance(std::uint64_t done, std::string_view) override { is_enough_ = done >= 1; }
  void end() override {}
  [[nodiscard]] bool interrupted() const override { return is_enough_; }

 private:
  bool is_enough_ = false;
};

class SimulateViews : public ::testing::Test {
 protected:
  void SetUp() override {
    auto opened = FurnitureCatalogue::open();
    ASSERT_OK(opened);
    catalogue_ = *std::move(opened);
  }
  Expected<ViewsSummary> simulate(const ViewsOptions& options, const std::string& name,
                                  std::size_t threads = 2, Progress* progress = nullptr) {
    ThreadPool pool(threads);
    SilentProgress silent;
    return simulate_views(options, *catalogue_, folder_ / name, pool,
                          progress != nullptr ? *progress : silent);
  }
  // Every file below a folder and its bytes.
  std::map<std::string, Bytes> contents(const std::string& name) {
    std::map<std::string, Bytes> contents;
    const std::filesystem::path root = folder_ / name;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(root)) {
      if (entry.is_regular_file())
        contents[std::filesystem::relative(entry.path(), root)] = read_file(entry.path()).value();
    }
    return contents;
  }

  ScratchFolder folder_;
  std::optional<FurnitureCatalogue> catalogue_;
};

TEST_F(SimulateViews, WritesTheSameFolderAClassAtAnyNumberOfThreads) {
  const auto summary = simulate(few_views(), "one", 1);
  ASSERT_OK(summary);
  EXPECT_TRUE(summary->finished);
  ASSERT_OK(simulate(few_views(), "three", 3));
  const auto one = contents("one");
  EXPECT_EQ(one.size(), summary->pictures + 2) << "views.json and credits.txt besides";
  EXPECT_EQ(one, contents("three"));

  std::set<std::string> classes;
  for (const auto& [name, bytes] : one) {
    const std::size_t slash = name.find('/');
    if (slash == std::string::npos) continue;
    classes.insert(name.substr(0, slash));
    const auto picture = image::decode_color(bytes);
    ASSERT_OK(picture);
    EXPECT_LE(std::max(picture->width(), picture->height()), 48);
  }
  EXPECT_THAT(classes, ::testing::IsSupersetOf({"toilet", "room: toilet"}));
}

TEST_F(SimulateViews, GoesOnWhereItWasInterrupted) {
  ViewsOptions options = few_views();
  options.last_home = 4;
  ImpatientProgress impatient;
  const auto first = simulate(options, "broken", 2, &impatient);
  ASSERT_OK(first);
  EXPECT_FALSE(first->finished);
  EXPECT_EQ(first->homes, 1u);
  ASSERT_OK(simulate(options, "broken"));
  ASSERT_OK(simulate(options, "whole"));
  EXPECT_EQ(contents("broken"), contents("whole"));
  options.views.of_room = 2;
  EXPECT_ERROR(simulate(options, "broken"), "holds views of other options");
}

TEST_F(SimulateViews, RefusesWhatMakesNoSense) {
  ViewsOptions options = few_views();
  options.last_home = 2;
  EXPECT_ERROR(simulate(options, "views"), "the first must not come after the last");
  options = few_views();
  options.views.longer_side_px = 3;
  EXPECT_ERROR(simulate(options, "views"), "expected 32 to 2048");
  std::filesystem::create_directories(folder_ / "mine");
  ASSERT_OK(write_file(folder_ / "mine" / "letter.txt", std::string_view("dear")));
  EXPECT_ERROR(simulate(few_views(), "mine"), "is not empty");
}

TEST(HomeViews, NameFurnitureAndRooms) {
  EXPECT_EQ(name_in_views("tv"), "television");
  EXPECT_EQ(name_in_views("floor_lamp"), "lamp");
  EXPECT_EQ(name_in_views("cup"), "");
  EXPECT_EQ(name_in_views(RoomKind::kLivingRoom), "room: living room");
}

TEST(Scenarios, OfHomesAreOfAllKinds) {
  std::set<Scenario> drawn;
  for (std::uint64_t home = 0; home < 60; ++home) drawn.insert(scenario_of(home, 7));
  EXPECT_EQ(drawn.size(), 5u);
  EXPECT_EQ(scenario_of(11, 7), scenario_of(11, 7));
}

}  // namespace
}  // namespace roomwise::simulation
