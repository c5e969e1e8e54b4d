#include "roomwise/pipeline/rooms/room_learning.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "roomwise/base/encodings.h"
#include "roomwise/base/in_context.h"
#include "roomwise/image/codec.h"
#include "roomwise/image/picture_files.h"
#include "roomwise/pipeline/rooms/picture_features.h"
#include "roomwise/pipeline/stored/lost_pictures.h"
#include "roomwise/pipeline/stored/stored_edits.h"
#include "roomwise/rooms/recognition/room_decision.h"

namespace roomwise::pipeline {
namespace {

// How the rooms were learned, for reports and for what compares with the same key-frames later.
// Those are told by walk and frame: their numbers change when others are taken out.
std::string to_json(const rooms::LearningReport& report,
                    std::span<const home::Keyframe> keyframes) {
  nlohmann::ordered_json json;
  for (const auto& room : report.rooms) {
    json["rooms"].push_back({{"room", room.room},
                             {"pictures", room.pictures},
                             {"held_out_correct", room.held_out_correct},
                             {"paper_held_out_correct", room.paper_held_out_correct}});
  }
  json["held_out"] = report.held_out;
  json["held_out_precision"] = report.held_out_precision();
  json["paper_held_out_precision"] = report.paper_held_out_precision;
  json["weight_decay"] = report.weight_decay;
  json["sure_from"] = report.min_probability;
  json["warnings"] = report.warnings;
  json["frames"] = nlohmann::ordered_json::array();
  for (const home::Keyframe& keyframe : keyframes)
    json["frames"].push_back({keyframe.recording, keyframe.frame_index});
  return json.dump();
}

// Adds rooms that the home does not have yet.
Expected<void> add_rooms(home::Home& home, const std::set<std::string>& names) {
  ROOMWISE_TRY(std::vector<rooms::Room> rooms, home.rooms());
  for (const std::string& name : names) {
    if (std::ranges::count(rooms, name, &rooms::Room::name) == 0) rooms.push_back({name, name});
  }
  return home.replace_rooms(rooms);
}

// Forgets the pictures of later visits that look most like another room to a newly learned
// classifier, or like none: rooms may have been named anew. Those of other networks stay. How many
// were forgotten.
Expected<std::size_t> check_visit_pictures(home::Home& home,
                                           const rooms::RoomClassifier& classifier) {
  ROOMWISE_TRY(const auto pictures, home.visit_pictures());
  std::vector<home::VisitPicture> kept;
  for (const home::VisitPicture& picture : pictures) {
    if (picture.network_fingerprint == classifier.network().fingerprint) {
      ROOMWISE_TRY(const rooms::PictureEvidence evidence, classifier.evidence(picture.features));
      const auto decision = rooms::decide(evidence, classifier.rooms(), classifier.model());
      if (evidence.familiarity < 0 || decision.rooms.front().room != picture.room) continue;
    }
    kept.push_back(picture);
  }
  if (kept.size() < pictures.size()) ROOMWISE_RETURN_IF_ERROR(home.replace_visit_pictures(kept));
  return pictures.size() - kept.size();
}

// Stores the classifier, and in which room it believes every key-frame to be.
Expected<void> store(home::Home& home, rooms::LearnedRooms& learned,
                     std::span<const home::KeyframeId> keyframes) {
  const rooms::RoomClassifier& classifier = learned.classifier;
  ROOMWISE_TRY(const std::size_t forgotten, check_visit_pictures(home, classifier));
  if (forgotten > 0) {
    learned.report.warnings.push_back(
        fmt::format("{} pictures of later visits do not look like these rooms and are forgotten; "
                    "bring the home up to date with those walks again",
                    forgotten));
  }
  ROOMWISE_TRY(auto learned_from, home.keyframes());
  std::erase_if(learned_from, [&](const home::Keyframe& keyframe) {
    return std::ranges::find(keyframes, keyframe.id) == keyframes.end();
  });
  ROOMWISE_RETURN_IF_ERROR(
      home.put_room_classifier({classifier.network().name, classifier.network().fingerprint,
                                classifier.to_bytes(), to_json(learned.report, learned_from)}));
  std::map<home::KeyframeId, std::vector<rooms::RoomScore>> rooms_of;
  ROOMWISE_TRY(const auto networks, home.networks());
  for (const auto& [id, network] : networks) {
    if (network.fingerprint != classifier.network().fingerprint) continue;
    ROOMWISE_TRY(const auto predictions, home.predictions(id));
    for (const auto& [keyframe, prediction] : predictions) {
      ROOMWISE_TRY(const rooms::PictureEvidence evidence, classifier.evidence(prediction.features));
      const auto decision = rooms::decide(evidence, classifier.rooms(), classifier.model());
      rooms_of[keyframe] = decision.rooms;
    }
  }
  return home.replace_keyframe_rooms(rooms_of);
}

// As features_network(), among those that have looked at the home's key-frames; of these one that
// is loaded, where there is one.
Expected<home::NetworkId> stored_features_network(const home::Home& home, const Networks& loaded) {
  ROOMWISE_TRY(const auto networks, home.networks());
  if (networks.empty()) {
    return fail(
        "{}: no network has looked at its key-frames; map the recording with --network FILE",
        home.file());
  }
  for (const auto& [id, network] : networks) {
    const auto is_this = [&](const auto& one) { return one->fingerprint() == network.fingerprint; };
    if (network.labels.empty() && std::ranges::any_of(loaded, is_this)) return id;
  }
  const auto nameless = std::find_if(networks.rbegin(), networks.rend(),
                                     [](const auto& entry) { return entry.second.labels.empty(); });
  return nameless != networks.rend() ? nameless->first : networks.rbegin()->first;
}

// The one that has looked at the home's key-frames.
Expected<const network::Classifier*> loaded_network(const home::Home& home,
                                                    const home::Network& network,
                                                    const Networks& networks) {
  const auto same = std::ranges::find_if(
      networks, [&](const auto& loaded) { return loaded->fingerprint() == network.fingerprint; });
  if (same != networks.end()) return same->get();
  return fail(
      "{}: varied pictures and photos are to be shown to the network {}, which has looked at the "
      "key-frames; give its file by --network, or have another look at them first by objects find",
      home.file(), network.name);
}

// Gives each sample, a key-frame's, the features of variants of its picture; notes those whose
// picture cannot be read again, which have none.
Expected<void> add_variants(home::Home& home, const home::Network& network,
                            std::span<const home::KeyframeId> keyframes,
                            std::span<rooms::RoomSample> samples, int variants,
                            const Networks& networks, const std::shared_ptr<LostPictures>& lost,
                            RunContext& run) {
  ROOMWISE_TRY(const network::Classifier* same, loaded_network(home, network, networks));
  const PictureSource source{
      keyframes.size(),
      [&](std::size_t i) -> Expected<Bytes> {
        ROOMWISE_TRY(auto images, home.images(keyframes[i]));
        return std::move(images.color);
      },
      [&](std::size_t i) { return fmt::format("{}: key-frame {}", home.file(), keyframes[i]); },
      [&](std::size_t i) { return keyframes[i]; },
      [&](std::size_t i, const Error& why) {
        return go_on_without(home, keyframes[i], why, lost);
      }};
  ROOMWISE_TRY(auto features, picture_features(home, source, *same, {1, variants}, run));
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i].variants = std::move(features[i]);
  return {};
}

// The rooms' names along the walks that are learned from; those whose rooms nobody named are left
// out.
Expected<std::map<home::RecordingId, recording::RoomLabels>> named_walks(
    const home::Home& home, const RoomLearning& learning) {
  const std::vector<home::RecordingId>& walks = learning.walks;
  ROOMWISE_TRY(const auto recordings, walks_that_stay(home));
  std::map<home::RecordingId, recording::RoomLabels> named;
  for (const home::StoredRecording& recording : recordings) {
    if (!walks.empty() && std::ranges::find(walks, recording.id) == walks.end()) continue;
    ROOMWISE_TRY(recording::RoomLabels labels, home.room_ranges(recording.id));
    if (!labels.ranges().empty()) named.emplace(recording.id, std::move(labels));
  }
  if (named.empty() && learning.photos.empty()) {
    return fail(
        "{}: the rooms of its walks are not named; give --labels rooms.txt or use rooms name",
        home.file());
  }
  return named;
}

// Each selected room must be one that some walk names.
Expected<void> check_rooms(const RoomSelection& selection,
                           const std::map<home::RecordingId, recording::RoomLabels>& walks) {
  const auto names = [&](const std::string& room) {
    return std::ranges::any_of(walks, [&](const auto& walk) {
      return RoomSelection{{}, {room}}.check_against(walk.second).has_value();
    });
  };
  for (const std::string& room : selection.rooms) {
    if (!names(room)) return fail("the labels of the walks have no room '{}'", room);
  }
  return {};
}

// The photos as samples, as if of a walk of their own.
Expected<std::vector<rooms::RoomSample>> samples_of(home::Home& home,
                                                    std::span<const RoomPhoto> photos,
                                                    const network::Classifier& network,
                                                    int variants, RunContext& run) {
  const PictureSource source{photos.size(),
                             [&](std::size_t i) { return read_file(photos[i].path); },
                             [&](std::size_t i) { return photos[i].path.string(); }};
  ROOMWISE_TRY(auto features, picture_features(home, source, network, {0, variants}, run));
  std::vector<rooms::RoomSample> samples;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    rooms::RoomSample& sample =
        samples.emplace_back(rooms::RoomSample{std::move(features[i].front()), photos[i].room});
    sample.variants.assign(std::make_move_iterator(features[i].begin() + 1),
                           std::make_move_iterator(features[i].end()));
  }
  return samples;
}

std::set<std::string> names_of_rooms(std::span<const RoomPhoto> photos) {
  std::set<std::string> names;
  for (const RoomPhoto& photo : photos) names.insert(photo.room);
  return names;
}

Expected<rooms::LearnedRooms> learn(std::span<const rooms::RoomSample> samples,
                                    const rooms::NetworkIdentity& network,
                                    const RoomLearning& learning, RunContext& run) {
  const auto timing = run.clock.measure("softmax");
  return rooms::learn_rooms(samples, network, learning.options, &run.pool);
}

}  // namespace

Expected<home::Home> create_home(const std::filesystem::path& path,
                                 const home::OpenOptions& options) {
  ROOMWISE_TRY(home::Home home, home::Home::create(path, options));
  ROOMWISE_RETURN_IF_ERROR(home.replace_concepts(rooms::Concepts::standard()));
  return home;
}

Expected<void> name_rooms(home::Home& home, home::RecordingId recording,
                          const recording::RoomLabels& labels) {
  std::set<std::string> names;
  for (const recording::RoomRange& range : labels.ranges()) names.insert(range.room);
  return home.atomically([&]() -> Expected<void> {
    ROOMWISE_RETURN_IF_ERROR(add_rooms(home, names));
    return home.replace_room_ranges(recording, labels.ranges());
  });
}

Expected<rooms::LearningReport> learn_rooms_from_keyframes(home::Home& home,
                                                           const RoomSelection& selection,
                                                           const RoomLearning& learning,
                                                           const Networks& networks,
                                                           RunContext& run) {
  ROOMWISE_TRY(const auto labels, named_walks(home, learning));
  ROOMWISE_RETURN_IF_ERROR(check_rooms(selection, labels));
  ROOMWISE_TRY(const home::NetworkId network_id, stored_features_network(home, networks));
  ROOMWISE_TRY(const auto stored_networks, home.networks());
  ROOMWISE_TRY(const auto predictions, home.predictions(network_id));
  ROOMWISE_TRY(const auto keyframes, home.keyframes());

  std::vector<rooms::RoomSample> samples;
  std::vector<home::KeyframeId> ids;  // of the samples
  for (const home::Keyframe& keyframe : keyframes) {
    const auto of_walk = labels.find(keyframe.recording);
    if (of_walk == labels.end()) continue;
    const recording::RoomRange* range = of_walk->second.find(keyframe.frame_index);
    const auto prediction = predictions.find(keyframe.id);
    if (range == nullptr || !selection.contains(*range) || prediction == predictions.end())
      continue;
    samples.push_back({prediction->second.features, range->room,
                       static_cast<std::uint64_t>(keyframe.recording),
                       static_cast<std::uint64_t>(range->stay)});
    ids.push_back(keyframe.id);
  }
  const home::Network& network = stored_networks.at(network_id);
  const auto lost = std::make_shared<LostPictures>(true);
  if (learning.variants > 0) {
    ROOMWISE_RETURN_IF_ERROR(
        add_variants(home, network, ids, samples, learning.variants, networks, lost, run));
  }
  if (!learning.photos.empty()) {
    ROOMWISE_TRY(const network::Classifier* same, loaded_network(home, network, networks));
    ROOMWISE_TRY(auto photos, samples_of(home, learning.photos, *same, learning.variants, run));
    std::ranges::move(photos, std::back_inserter(samples));
  }
  ROOMWISE_TRY(rooms::LearnedRooms learned,
               learn(samples, {network.name, network.fingerprint}, learning, run));
  if (const auto unread = lost->all(); !unread.empty()) {
    std::vector<std::string> named;
    for (const auto& [id, why] : unread) named.push_back(why);
    learned.report.warnings.push_back(fmt::format(
        "stored pictures that cannot be read again: {}; they count as the network saw them, "
        "but not varied: {}",
        named.size(), fmt::join(named, "; ")));
  }
  ROOMWISE_RETURN_IF_ERROR(home.atomically([&]() -> Expected<void> {
    ROOMWISE_RETURN_IF_ERROR(add_rooms(home, names_of_rooms(learning.photos)));
    return store(home, learned, ids);
  }));
  return learned.report;
}

Expected<std::vector<RoomPhoto>> list_room_photos(const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  std::error_code error;
  std::vector<RoomPhoto> photos;
  for (fs::directory_iterator room(folder, error), end; !error && room != end;
       room.increment(error)) {
    if (!room->is_directory()) continue;
    if (!is_plain_text(room->path().filename().string())) {
      return fail("{}: has a folder whose name is not UTF-8 text; rename it", folder.string());
    }
    for (fs::directory_iterator file(room->path(), error); !error && file != end;
         file.increment(error)) {
      if (image::has_ending_of_picture(file->path()))
        photos.push_back({file->path(), room->path().filename().string()});
    }
    if (error) break;
  }
  if (error) return fail("{}: cannot be read: {}", folder.string(), error.message());
  if (photos.empty()) {
    return fail("{}: holds no photos; expected one folder a room with .jpg or .png files in it",
                folder.string());
  }
  std::ranges::sort(photos, {},
                    [](const RoomPhoto& photo) { return std::tie(photo.room, photo.path); });
  return photos;
}

Expected<rooms::LearningReport> learn_rooms_from_photos(home::Home& home,
                                                        const std::filesystem::path& folder,
                                                        const network::Classifier& network,
                                                        const RoomLearning& learning,
                                                        RunContext& run) {
  ROOMWISE_TRY(const std::vector<RoomPhoto> photos, list_room_photos(folder));
  return learn_rooms_from_photos(home, photos, network, learning, run);
}

Expected<rooms::LearningReport> learn_rooms_from_photos(home::Home& home,
                                                        std::span<const RoomPhoto> photos,
                                                        const network::Classifier& network,
                                                        const RoomLearning& learning,
                                                        RunContext& run) {
  ROOMWISE_TRY(const auto samples, samples_of(home, photos, network, learning.variants, run));
  ROOMWISE_TRY(rooms::LearnedRooms learned,
               learn(samples, {network.name(), network.fingerprint()}, learning, run));
  ROOMWISE_RETURN_IF_ERROR(home.atomically([&]() -> Expected<void> {
    ROOMWISE_RETURN_IF_ERROR(add_rooms(home, names_of_rooms(photos)));
    return store(home, learned, {});
  }));
  return learned.report;
}

Expected<std::vector<home::KeyframeId>> learned_keyframes(const home::Home& home) {
  ROOMWISE_TRY(const auto record, home.room_classifier());
  std::vector<home::KeyframeId> keyframes;
  if (!record) return keyframes;
  const auto json = nlohmann::json::parse(record->report_json, nullptr, false);
  if (json.is_discarded() || !json.contains("frames")) return keyframes;
  std::set<std::pair<home::RecordingId, std::uint64_t>> learned;
  try {
    json.at("frames").get_to(learned);
  } catch (const nlohmann::json::exception&) {
    return fail("{}: is damaged: what its rooms were learned from is no list of frames",
                home.file());
  }
  ROOMWISE_TRY(const auto all, home.keyframes());
  for (const home::Keyframe& keyframe : all) {
    if (learned.contains({keyframe.recording, keyframe.frame_index}))
      keyframes.push_back(keyframe.id);
  }
  return keyframes;
}

Expected<rooms::RoomClassifier> with_visit_pictures(const home::Home& home,
                                                    rooms::RoomClassifier classifier) {
  ROOMWISE_TRY(auto stored, home.visit_pictures());
  std::vector<rooms::RoomPicture> pictures;
  for (home::VisitPicture& picture : stored) {
    const bool is_learned =
        picture.network_fingerprint == classifier.network().fingerprint &&
        std::ranges::find(classifier.rooms(), picture.room) != classifier.rooms().end();
    if (is_learned) pictures.push_back({std::move(picture.features), std::move(picture.room)});
  }
  return in_context(home.file(), classifier.with(pictures));
}

Expected<const network::Classifier*> features_network(const Networks& networks) {
  if (networks.empty()) return fail("no network is given; give --network FILE");
  const auto nameless =
      std::ranges::find_if(networks, [](const auto& network) { return network->labels().empty(); });
  return nameless != networks.end() ? nameless->get() : networks.front().get();
}

const network::Classifier* naming_network(const Networks& networks) {
  const auto naming = std::ranges::find_if(
      networks, [](const auto& network) { return !network->labels().empty(); });
  return naming != networks.end() ? naming->get() : nullptr;
}

}  // namespace roomwise::pipeline
