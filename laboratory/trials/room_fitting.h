#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "roomwise/pipeline/rooms/labelled_pictures.h"
#include "roomwise/pipeline/rooms/room_recognizer.h"
#include "roomwise/rooms/recognition/room_model.h"

// What homes that learned their rooms make of pictures whose room is known, and of pictures of
// other places: what the decision about rooms is fitted to.
namespace roomwise::trials {

// Pictures of a home's rooms, or of other places.
struct RoomTest {
  std::filesystem::path folder;  // a recording with rooms.txt, or a folder of photos a room
  std::string visits;            // of the recording: as pipeline::parse_stays() reads them; all
  bool is_elsewhere = false;     // none of the home's rooms is there
};
// A home that learned its rooms, and what it is tested on.
struct RoomCaseFiles {
  std::string name;
  std::string source;  // cases of one source share pictures and are left out together
  bool is_real = false;
  std::filesystem::path home;
  std::vector<RoomTest> tests;
};
// A study: {"cases": [{"name", "source", "real", "home", "known": [{"folder", "visits"}],
// "elsewhere": [folder]}]}; relative paths are relative to the file. Fails, naming the case, on
// anything else.
[[nodiscard]] Expected<std::vector<RoomCaseFiles>> read_room_study(
    const std::filesystem::path& file);

// What a home's classifier makes of one picture.
struct SeenPicture {
  int room = -1;  // of the learned ones, in their order; -1: none of them
  std::string name;
  rooms::Similarity similarity;
  Eigen::VectorXd regression;  // the paper's probability of each room
};
struct RoomCase {
  std::string name;
  std::string source;
  bool is_real = false;
  std::string network;  // that it was learned on
  std::vector<std::string> rooms;
  rooms::RoomCalibration calibration;
  std::vector<SeenPicture> pictures;
};
// Rooms that the home did not learn are places elsewhere. Of places elsewhere at most
// `max_elsewhere` pictures of each folder count, spread evenly.
[[nodiscard]] Expected<RoomCase> room_case(const RoomCaseFiles& files, const home::Home& home,
                                           const pipeline::Networks& networks,
                                           std::size_t max_elsewhere, pipeline::RunContext& run);

// What a case saw, one line of JSON, and such lines back: what is fitted to, without the homes.
// Reading fails, naming the line.
[[nodiscard]] std::string evidence_json(const RoomCase& one);
[[nodiscard]] Expected<std::vector<RoomCase>> read_room_evidence(const std::filesystem::path& file);

// What is asked of the decision, on the pictures that it is fitted to: of real and of simulated
// homes each.
struct RoomFittingOptions {
  double min_precision = 0.97;        // of the pictures whose room is named, rightly
  double max_elsewhere_named = 0.03;  // of the pictures of other places
  // The same by the model for any network, which tells homes apart less well: under 0.03 it would
  // name next to nothing in real homes (docs/experiments/rooms-fitted.md).
  double max_elsewhere_named_any = 0.05;
  double max_rejected = 0.01;  // of the pictures of the rooms: "none of them"
};

// How single pictures of a case are decided.
struct RoomCounts {
  std::size_t known = 0, elsewhere = 0;  // pictures
  // Of the known ones: whose most probable room is right; by the paper's regression; by similarity.
  std::size_t best_right = 0, regression_right = 0, similarity_right = 0;
  std::size_t named = 0, named_right = 0;
  std::size_t either = 0, either_right = 0;
  std::size_t elsewhere_named = 0, elsewhere_either = 0;
};
[[nodiscard]] RoomCounts counts_of(const RoomCase& one, const rooms::RoomModel& model);

// For the network named, on which all cases were learned, or, where that is empty, for any: by what
// means the same whatever the network. Real and simulated cases weigh the same together, and so do
// pictures of the rooms and of other places in each. Fails where one sort of pictures is missing.
[[nodiscard]] Expected<rooms::RoomModel> fit_rooms(std::span<const RoomCase* const> cases,
                                                   const std::string& network,
                                                   const RoomFittingOptions& options);
// The text of room_model.json.
[[nodiscard]] std::string to_json(std::span<const rooms::RoomModel> models,
                                  std::span<const RoomCase> fitted_on,
                                  const RoomFittingOptions& options);

}  // namespace roomwise::trials
