#pragma once

#include <filesystem>

#include "roomwise/home/home.h"
#include "roomwise/pipeline/objects/keyframe_observer.h"
#include "roomwise/pipeline/rooms/room_selection.h"
#include "roomwise/pipeline/run_context.h"
#include "roomwise/rooms/learning/room_learner.h"

namespace roomwise::pipeline {

// Makes a new home that begins with the paper's concepts.
[[nodiscard]] Expected<home::Home> create_home(const std::filesystem::path& path,
                                               const home::OpenOptions& options = {});

// Names the rooms of the home's recording: its frames' ranges, and the rooms that they mention. A
// new room's type is its name ("kitchen" is a kitchen) until the user says otherwise.
[[nodiscard]] Expected<void> name_rooms(home::Home& home, home::RecordingId recording,
                                        const recording::RoomLabels& labels);

// A picture and the room that it shows.
struct RoomPhoto {
  std::filesystem::path path;
  std::string room;
};

// How rooms are learned.
struct RoomLearning {
  rooms::LearningOptions options = {};
  // Of each picture so many varied ones are learned from beside it (network/augmentation.h), at
  // most kMaxVariants.
  int variants = 0;
  std::vector<home::RecordingId> walks = {};  // from which; none: from all whose rooms are named
  // Learned from beside the walks' key-frames: of the same rooms, or of others.
  std::vector<RoomPhoto> photos = {};
};

// Learns the rooms from the key-frames of walks that lie in the selected ranges, on what a features
// network saw in them; stores the classifier and what it says of every key-frame. With variants or
// photos, that network must be among `networks`, to look at them. Pictures that later visits
// brought stay where the new classifier names the same room by them; a warning says how many do
// not.
[[nodiscard]] Expected<rooms::LearningReport> learn_rooms_from_keyframes(
    home::Home& home, const RoomSelection& selection, const RoomLearning& learning,
    const Networks& networks, RunContext& run);

// The JPEG and PNG files of a folder that has one folder a room, by room and name. Fails where
// there are none.
[[nodiscard]] Expected<std::vector<RoomPhoto>> list_room_photos(
    const std::filesystem::path& folder);

// The same from plain photos, for a home without a recording. The photos themselves are not kept.
[[nodiscard]] Expected<rooms::LearningReport> learn_rooms_from_photos(
    home::Home& home, const std::filesystem::path& folder, const network::Classifier& network,
    const RoomLearning& learning, RunContext& run);

[[nodiscard]] Expected<rooms::LearningReport> learn_rooms_from_photos(
    home::Home& home, std::span<const RoomPhoto> photos, const network::Classifier& network,
    const RoomLearning& learning, RunContext& run);

// The key-frames that the home's rooms were learned from; none where they were learned from photos,
// or by a version of Roomwise that did not keep which.
[[nodiscard]] Expected<std::vector<home::KeyframeId>> learned_keyframes(const home::Home& home);

// The classifier, which the home learned, with the pictures that later visits brought
// (RoomClassifier::with).
[[nodiscard]] Expected<rooms::RoomClassifier> with_visit_pictures(const home::Home& home,
                                                                  rooms::RoomClassifier classifier);

// The network on whose features rooms are learned: one that serves features only is preferred to
// one that names things. Fails where there is none.
[[nodiscard]] Expected<const network::Classifier*> features_network(const Networks& networks);
// The one that names things, or nullptr.
[[nodiscard]] const network::Classifier* naming_network(const Networks& networks);

}  // namespace roomwise::pipeline
