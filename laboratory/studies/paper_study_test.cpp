#include "laboratory/studies/paper_study.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "laboratory/studies/paper_page.h"
#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::studies {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::Contains;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using testing::ScratchFolder;

std::string value_after(const Words& words, const std::string& option) {
  const auto found = std::ranges::find(words, option);
  return found == words.end() ? "" : *std::next(found);
}

json room_result() {
  const json way = {
      {"n", 20}, {"named", {{"of", 20}, {"right", 15}, {"interval", {0.5, 0.875}}}}, {"ms", 12}};
  return {{"paper_pair_without_objects", way}, {"paper_pair", way}, {"single", way}};
}

json object_counts(int found) {
  return {{"found", found}, {"missed", 2}, {"beyond", 0},
          {"double", 0},    {"false", 1},  {"pairs", json::array()}};
}

// Stands in for the program: makes what a command would make, and prints made-up figures.
class MadeUpProgram {
 public:
  std::vector<std::string> commands;  // that were run
  std::vector<std::string> margins;   // of those that ask for rooms
  std::string failing;                // the first word of those that fail
  std::size_t interrupted_after = 1000;

  RunProgram program() {
    return [this](const ProgramRun& run) -> Expected<std::string> {
      if (commands.size() == interrupted_after) {
        return fail_with(ErrorCode::kInterrupted, "interrupted");
      }
      commands.push_back(run.words.front());
      if (run.words.front() == failing) return fail("roomwise {}: it is broken", failing);
      if (run.words[0] == "rooms" && run.words[1] == "eval") {
        margins.push_back(value_after(run.words, "--margin"));
      }
      make_files(run.words);
      return answer(run.words).dump();
    };
  }

 private:
  static void make_files(const Words& words) {
    for (const char* option : {"--home", "--trajectory"}) {
      const std::string file = value_after(words, option);
      if (file.empty()) continue;
      EXPECT_OK(write_file(file, std::string_view("made")));
    }
    const std::string folder = value_after(words, "-o");
    if (!folder.empty()) fs::create_directories(folder);
  }

  [[nodiscard]] json answer(const Words& words) const {
    if (words[0] == "map") {
      // By its features, so that rows can be told apart.
      const double frames = value_after(words, "--features") == "orb" ? 4 : 10;
      return {{"run", commands.size()},  // no two take as long
              {"frames", frames},
              {"placed", frames},
              {"cpu_s", 0.2},
              {"stages", {{"features", {{"cpu_s", 0.05}}}, {"optimisation", {{"cpu_s", 0.01}}}}}};
    }
    if (words[0] == "eval" && words[1] == "trajectory") {
      return {{"ate_rmse_m", 0.0123}, {"rpe", nullptr}};
    }
    if (words[0] == "eval") {
      return {{"rules", object_counts(1)},
              {"instances", object_counts(3)},
              {"naive", object_counts(2)}};
    }
    if (words[0] == "objects") {
      return {
          {"objects",
           {{{"name", "lamp"}, {"score", 0.5}, {"sightings", 4}, {"position_world_m", nullptr}}}}};
    }
    if (words[0] == "rooms" && words[1] == "eval") return room_result();
    if (words[0] == "train") {
      return {{"pictures", 6},
              {"held_out", 3},
              {"steps", 20},
              {"cpu_s", 1.5},
              {"best_step", 20},
              {"curve",
               {{{"step", 20},
                 {"cross_entropy", 0.5},
                 {"held_out_cross_entropy", nullptr},
                 {"held_out_precision", nullptr}}}}};
    }
    return json::object();
  }
};

class PaperStudyTest : public ::testing::Test {
 protected:
  PaperStudyTest() {
    options_.data = folder_ / "data";
    options_.work = folder_ / "work";
    options_.networks = {"net.onnx"};
    options_.trained = "net.onnx";
    fs::create_directories(options_.data);
  }
  void have(const std::string& recording) const {
    fs::create_directories(options_.data / recording);
  }
  PaperResults study() {
    SilentProgress silent;
    auto results = study_paper(options_, made_up_.program(), silent);
    EXPECT_OK(results);
    return results ? *std::move(results) : PaperResults();
  }

  const ScratchFolder folder_;
  PaperStudyOptions options_;
  MadeUpProgram made_up_;
};

TEST_F(PaperStudyTest, MapsARecordingByBothMethodsAndAllFeatures) {
  have("rgbd_dataset_freiburg1_desk");
  options_.parts = {PaperPart::kMapping};
  options_.seeds = 2;
  const PaperResults results = study();
  ASSERT_EQ(results.mapping.size(), 6U);
  const MappingRow& orb = results.mapping[2];
  EXPECT_EQ(orb.data.name, "fr1/desk");
  EXPECT_FALSE(orb.data.is_simulated);
  EXPECT_EQ(orb.method, "paper");
  EXPECT_EQ(orb.features, "orb");
  ASSERT_EQ(orb.trials.size(), 2U);
  EXPECT_DOUBLE_EQ(orb.trials[0].ate_m, 0.0123);
  EXPECT_DOUBLE_EQ(orb.trials[0].all_ms, 50) << "0.2 s of 4 frames";
  EXPECT_DOUBLE_EQ(orb.trials[0].solving_ms, 2.5);
  EXPECT_FALSE(orb.trials[0].rpe_m) << "a short recording has none";
  EXPECT_THAT(made_up_.commands, Not(Contains("simulate")));
}

TEST_F(PaperStudyTest, NamesEachMissingRecordingAndWhoKeepsIt) {
  have("rgbd_dataset_freiburg1_rpy");
  options_.parts = {PaperPart::kMapping};
  const PaperResults results = study();
  const auto& missing = results.missing.at(PaperPart::kMapping);
  EXPECT_THAT(missing, Contains(HasSubstr("fr2/xyz (rgbd_dataset_freiburg2_xyz) is not in")));
  EXPECT_THAT(missing,
              Contains(HasSubstr("https://cvg.cit.tum.de/data/datasets/rgbd-dataset/download")));
  EXPECT_THAT(missing, Contains(HasSubstr("office_walk is not in")));
  EXPECT_THAT(missing, Not(Contains(HasSubstr("fr1/rpy"))));
}

TEST_F(PaperStudyTest, SimulatesAFlatWhereNoRecordingIs) {
  const PaperResults results = study();
  ASSERT_EQ(results.mapping.size(), 6U);
  for (const MappingRow& row : results.mapping) EXPECT_TRUE(row.data.is_simulated);
  ASSERT_EQ(results.objects.size(), 3U);
  EXPECT_TRUE(results.objects[0].data.is_simulated);
  EXPECT_EQ(results.objects[0].way, "the paper's rules");
  EXPECT_EQ(results.objects[0].found, 1U);
  EXPECT_EQ(std::ranges::count(made_up_.commands, "simulate"), 3) << "by day, light, moved";
  EXPECT_THAT(results.missing.at(PaperPart::kTraining), Contains(HasSubstr("room_photos")));
}

TEST_F(PaperStudyTest, AsksForRoomsAfterLightAndThingsChanged) {
  options_.parts = {PaperPart::kRooms};
  const PaperResults results = study();
  ASSERT_EQ(results.rooms.size(), 4U) << "two ways of pairs, twice";
  EXPECT_EQ(results.rooms[0].changed, "light");
  EXPECT_EQ(results.rooms[3].changed, "things moved");
  EXPECT_EQ(results.rooms[3].way, "the paper's way, two pictures");
  EXPECT_DOUBLE_EQ(results.rooms[3].right_of_named.value(), 0.75);
}

TEST_F(PaperStudyTest, AsksForRoomsOnLaterStaysAndOnPhotosOfOtherHomes) {
  have("office_walk");
  have("room_photos");
  options_.parts = {PaperPart::kRooms};
  const PaperResults results = study();
  ASSERT_EQ(results.rooms.size(), 8U);
  EXPECT_EQ(results.rooms[4].data.name, "office_walk");
  EXPECT_EQ(results.rooms[6].data.name, "room_photos");
  EXPECT_FALSE(results.rooms[6].data.is_simulated);
  EXPECT_EQ(made_up_.margins, (std::vector<std::string>{"1", "1", "3", ""}))
      << "photos have no neighbours to leave out";
}

TEST_F(PaperStudyTest, IsInterruptedAndGoesOnToTheSamePage) {
  have("rgbd_dataset_freiburg1_rpy");
  have("office_walk");
  have("room_photos");
  const std::string whole = paper_page(study());
  const std::size_t all = made_up_.commands.size();

  options_.work = folder_ / "other";
  made_up_ = {};
  made_up_.interrupted_after = all / 2;
  SilentProgress silent;
  const auto interrupted = study_paper(options_, made_up_.program(), silent);
  ASSERT_FALSE(interrupted);
  EXPECT_EQ(interrupted.error().code, ErrorCode::kInterrupted);

  made_up_.interrupted_after = all + 1;
  EXPECT_EQ(paper_page(study()), whole);
  EXPECT_EQ(made_up_.commands.size(), all) << "nothing was done twice";
  EXPECT_EQ(paper_page(study()), whole);
  EXPECT_EQ(made_up_.commands.size(), all);
}

TEST_F(PaperStudyTest, MakesAnewWhatWasAskedOtherwise) {
  options_.parts = {PaperPart::kRooms};
  study();
  const std::size_t before = made_up_.commands.size();
  options_.networks = {"other.onnx"};
  study();
  EXPECT_EQ(made_up_.commands.size(), before + 4) << "map, learn, two trials; no walk";
}

TEST_F(PaperStudyTest, MakesAHomeAnewThatIsGone) {
  options_.parts = {PaperPart::kRooms};
  study();
  const std::size_t before = made_up_.commands.size();
  fs::remove(options_.work / "homes/flat-day.home");
  const auto again = [&] {
    return std::vector(made_up_.commands.begin() + static_cast<std::ptrdiff_t>(before),
                       made_up_.commands.end());
  };
  // Interrupted in between, the next call knows that what was learned is of the home that is gone.
  made_up_.interrupted_after = before + 1;
  SilentProgress silent;
  EXPECT_ERROR(study_paper(options_, made_up_.program(), silent), "interrupted");
  made_up_.interrupted_after = 1000;
  study();
  EXPECT_THAT(again(), ElementsAre("map", "rooms", "rooms", "rooms"));
}

TEST_F(PaperStudyTest, MakesAllAnewThatStandsOnWhatIsMadeAnew) {
  options_.parts = {PaperPart::kRooms};
  study();
  const std::size_t all = made_up_.commands.size();
  fs::remove_all(options_.work / "flat/day");
  study();
  EXPECT_EQ(made_up_.commands.size(), all + 5)
      << "walk, map, learn, two trials, though the walk's result is the same";
}

TEST_F(PaperStudyTest, MakesAnewWhatAnotherVersionMade) {
  options_.parts = {PaperPart::kRooms};
  options_.version = "1 (ab)";
  study();
  const std::size_t all = made_up_.commands.size();
  study();
  EXPECT_EQ(made_up_.commands.size(), all);
  options_.version = "1 (cd)";
  study();
  EXPECT_EQ(made_up_.commands.size(), 2 * all);
}

TEST_F(PaperStudyTest, TellsWhatFailedAndMakesTheRest) {
  have("rgbd_dataset_freiburg1_rpy");
  have("room_photos");
  made_up_.failing = "train";
  const PaperResults results = study();
  EXPECT_FALSE(results.training);
  EXPECT_THAT(results.missing.at(PaperPart::kTraining),
              Contains("The training: roomwise train: it is broken."));
  EXPECT_EQ(results.mapping.size(), 6U);
  made_up_.failing = "";
  EXPECT_TRUE(study().training) << "it is tried again";
}

TEST_F(PaperStudyTest, SaysThatNoNetworkIsThere) {
  options_.networks.clear();
  options_.trained.reset();
  have("room_photos");
  const PaperResults results = study();
  EXPECT_THAT(results.objects, IsEmpty());
  EXPECT_THAT(results.rooms, IsEmpty());
  for (const PaperPart part : {PaperPart::kObjects, PaperPart::kRooms, PaperPart::kTraining}) {
    EXPECT_THAT(results.missing.at(part), Contains(HasSubstr("ROOMWISE_MODELS")));
  }
  EXPECT_EQ(results.mapping.size(), 6U) << "mapping needs none";
}

TEST_F(PaperStudyTest, SaysWhoseThingsNobodyMarked) {
  have("rgbd_dataset_freiburg1_rpy");
  options_.parts = {PaperPart::kObjects};
  options_.truth = folder_ / "truth";
  fs::create_directories(options_.truth);
  PaperResults results = study();
  EXPECT_THAT(results.missing.at(PaperPart::kObjects),
              Contains(HasSubstr("nobody marked its things")));
  ASSERT_EQ(results.ruled_objects.size(), 1U);
  EXPECT_EQ(results.ruled_objects[0].name, "lamp");
  EXPECT_FALSE(results.ruled_objects[0].has_place);
  ASSERT_OK(write_file(options_.truth / "rgbd_dataset_freiburg1_rpy.objects.json",
                       std::string_view("{}")));
  results = study();
  EXPECT_EQ(results.objects.size(), 3U);
}

TEST_F(PaperStudyTest, LeavesAFolderAloneInWhichAnotherWorks) {
  have("rgbd_dataset_freiburg1_rpy");
  options_.parts = {PaperPart::kMapping};
  SilentProgress silent;
  std::string refused;
  const RunProgram meanwhile = [&](const ProgramRun& run) {
    const auto second = study_paper(options_, made_up_.program(), silent);
    if (!second) refused = second.error().message;
    return made_up_.program()(run);
  };
  EXPECT_OK(study_paper(options_, meanwhile, silent));
  EXPECT_THAT(refused, HasSubstr("another run works in this folder"));
}

TEST_F(PaperStudyTest, SaysWhichFolderIsWrong) {
  SilentProgress silent;
  options_.truth = folder_ / "no-truth";
  EXPECT_ERROR(study_paper(options_, made_up_.program(), silent), "--truth");
  options_.data = folder_ / "nowhere";
  EXPECT_ERROR(study_paper(options_, made_up_.program(), silent),
               "nowhere: is no folder; --data is the folder that holds recordings");
  options_.data = folder_ / "data";
  options_.truth.clear();
  ASSERT_OK(write_file(folder_ / "file", std::string_view("")));
  options_.work = folder_ / "file";
  EXPECT_ERROR(study_paper(options_, made_up_.program(), silent), "give another folder by --work");
  options_.seeds = 0;
  EXPECT_ERROR(options_.validate(), "seeds");
  EXPECT_THAT(made_up_.commands, IsEmpty());
}

}  // namespace
}  // namespace roomwise::studies
