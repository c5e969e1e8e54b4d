#include "roomwise/pipeline/rooms/room_recognizer.h"

#include <algorithm>
#include <map>
#include <set>

#include "roomwise/base/in_context.h"
#include "roomwise/pipeline/objects/changed_networks.h"
#include "roomwise/pipeline/rooms/room_contents.h"
#include "roomwise/pipeline/rooms/room_learning.h"

namespace roomwise::pipeline {
namespace {

// The learned rooms in the order of the classifier; a room that the home does not have any more is
// of no type but its own.
std::vector<rooms::Room> in_order(const std::vector<std::string>& names,
                                  const std::vector<rooms::Room>& rooms) {
  std::vector<rooms::Room> ordered;
  for (const std::string& name : names) {
    const auto room = std::ranges::find(rooms, name, &rooms::Room::name);
    ordered.push_back(room != rooms.end() ? *room : rooms::Room{name, name});
  }
  return ordered;
}

// By the stretches of the walks that the rooms were learned from: what was walked at another time
// may be what the rooms are tested on.
Expected<rooms::RoomTopology> topology_of(const home::Home& home,
                                          const std::vector<std::string>& rooms) {
  ROOMWISE_TRY(const auto learned, learned_keyframes(home));
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  std::map<home::RecordingId, std::set<std::uint64_t>> learned_frames;
  for (const home::Keyframe& keyframe : keyframes) {
    if (std::ranges::find(learned, keyframe.id) == learned.end()) continue;
    learned_frames[keyframe.recording].insert(keyframe.frame_index);
  }
  std::vector<std::string> walk;
  for (const auto& [recording, frames] : learned_frames) {
    ROOMWISE_TRY(const recording::RoomLabels labels, home.room_ranges(recording));
    walk.emplace_back();
    for (const recording::RoomRange& range : labels.ranges()) {
      const auto first = frames.lower_bound(range.first_frame);
      const bool was_learned = first != frames.end() && *first <= range.last_frame;
      const bool is_no_room = std::ranges::find(rooms, range.room) == rooms.end();
      walk.push_back(was_learned || is_no_room ? range.room : std::string());
    }
  }
  return rooms::RoomTopology(rooms, walk);
}

// The one that names things in pictures to come. nullptr: none.
Expected<const network::Classifier*> network_for_names(const home::Home& home,
                                                       const Networks& networks) {
  const network::Classifier* best = naming_network(networks);
  std::size_t most = 1;  // key-frames that it looked at
  ROOMWISE_TRY(const auto stored, home.networks());
  for (const auto& [id, record] : stored) {
    const auto same = std::ranges::find_if(networks, [&](const auto& network) {
      return !network->labels().empty() && network->fingerprint() == record.fingerprint;
    });
    if (same == networks.end()) continue;
    ROOMWISE_TRY(const auto predictions, home.predictions(id));
    if (predictions.size() < most) continue;
    most = predictions.size();
    best = same->get();
  }
  return best;
}

}  // namespace

Expected<RoomRecognizer> RoomRecognizer::create(const home::Home& home, const Networks& networks) {
  ROOMWISE_TRY(const auto record, home.room_classifier());
  if (!record) return fail("{}: no rooms were learned yet; use rooms learn", home.file());
  ROOMWISE_TRY(auto classifier,
               in_context(home.file(), rooms::RoomClassifier::from_bytes(record->classifier)));
  const auto same = std::ranges::find_if(networks, [&](const auto& network) {
    return network->fingerprint() == record->network_fingerprint;
  });
  if (same == networks.end()) {
    const auto changed = std::ranges::find_if(
        networks, [&](const auto& network) { return network->name() == record->network_name; });
    if (changed != networks.end()) {
      return fail("{}", in_words({record->network_name, record->network_fingerprint,
                                  (*changed)->fingerprint()},
                                 home.file()));
    }
    return fail(
        "{}: its rooms were learned with the network {}; give that file by --network or, where it "
        "is not one in 8 bits, its folder as ROOMWISE_MODELS",
        home.file(), record->network_name);
  }
  ROOMWISE_TRY(classifier, with_visit_pictures(home, std::move(classifier)));
  ROOMWISE_TRY(rooms::Concepts concepts, home.concepts());
  ROOMWISE_TRY(const std::vector<rooms::Room> rooms, home.rooms());
  for (const std::string& learned : classifier.rooms()) {
    if (std::ranges::find(rooms, learned, &rooms::Room::name) != rooms.end()) continue;
    return fail(
        "{}: what was learned knows a room '{}', which is none of this home any more; learn the "
        "rooms anew",
        home.file(), learned);
  }
  std::vector<rooms::Room> learned = in_order(classifier.rooms(), rooms);
  ROOMWISE_TRY(const network::Classifier* const naming, network_for_names(home, networks));
  rooms::RoomObjects room_objects;
  if (naming != nullptr) {
    ROOMWISE_TRY(room_objects, pipeline::room_objects(home, naming->fingerprint()));
  }
  ROOMWISE_TRY(rooms::RoomTopology topology, topology_of(home, classifier.rooms()));
  return RoomRecognizer(std::move(classifier), std::move(concepts), std::move(learned),
                        std::move(room_objects), std::move(topology), same->get(), naming);
}

Expected<std::vector<objects::ObjectScore>> RoomRecognizer::objects_in(
    const PredictLabels& names) const {
  constexpr std::size_t kTop = 3;  // the paper looks at the three best
  if (naming_ == nullptr || !names) return std::vector<objects::ObjectScore>{};
  ROOMWISE_TRY(const network::Prediction seen, names());
  return objects::top_objects(seen.scores, naming_->labels(), concepts_.vocabulary, kTop);
}

Expected<std::optional<rooms::LocalizationEvidence>> RoomRecognizer::localize_if_needed(
    const rooms::PictureEvidence& pictures, const Localize& localize) const {
  const bool is_asked = localize && rooms::place_may_tell(pictures, model());
  if (!is_asked) return std::optional<rooms::LocalizationEvidence>();
  return localize();
}

Expected<rooms::RoomDecision> RoomRecognizer::decide(
    std::span<const rooms::PictureEvidence> pictures, const PredictLabels& predict_labels,
    const Localize& localize) const {
  rooms::PictureEvidence combined = rooms::combine(pictures);
  ROOMWISE_TRY(const auto place, localize_if_needed(combined, localize));
  if (place) combined = rooms::with_place(combined, *place, model());
  rooms::RoomDecision decision = rooms::decide(combined, rooms(), model());
  const bool is_open =
      decision.verdict == rooms::Verdict::kNotSure || decision.verdict == rooms::Verdict::kEither;
  const bool objects_may_tell = is_open && combined.familiarity >= 0;
  if (objects_may_tell) {
    ROOMWISE_TRY(const auto objects, objects_in(predict_labels));
    decision =
        rooms::decide_with_objects(combined, objects, concepts_, rooms_, model(), room_objects_);
  }
  if (place) decision.why += "; " + place->why;
  return decision;
}

Expected<rooms::RoomDecision> RoomRecognizer::recognize(std::span<const image::ColorImage> pictures,
                                                        const Localize& localize) const {
  if (pictures.empty()) return fail("no picture is given; give at least one");
  std::vector<rooms::PictureEvidence> seen;
  for (const image::ColorImage& picture : pictures) {
    ROOMWISE_TRY(const network::Prediction prediction, features_->predict(picture));
    ROOMWISE_TRY(seen.emplace_back(), evidence(prediction));
  }
  return decide(
      seen, [&] { return naming_->predict(pictures.back()); }, localize);
}

Expected<rooms::RoomDecision> RoomRecognizer::update(rooms::RoomStream& stream,
                                                     const rooms::PictureEvidence& picture,
                                                     double elapsed_s,
                                                     const Localize& localize) const {
  ROOMWISE_TRY(const auto place, localize_if_needed(picture, localize));
  if (!place) return stream.update(picture, elapsed_s);
  rooms::RoomDecision decision =
      stream.update(rooms::with_place(picture, *place, model()), elapsed_s);
  decision.why += "; " + place->why;
  return decision;
}

Expected<rooms::RoomAnswer> RoomRecognizer::paper_decide(
    const rooms::RoomScore& first, const rooms::RoomScore& second,
    const PredictLabels& predict_labels) const {
  Expected<void> status;
  const auto objects = [&]() -> std::vector<objects::ObjectScore> {
    auto found = objects_in(predict_labels);
    if (!found) {
      status = Unexpected(found.error());
      return {};
    }
    return *std::move(found);
  };
  const rooms::RoomAnswer answer = rooms::decide(first, second, objects, concepts_, rooms_);
  ROOMWISE_RETURN_IF_ERROR(status);
  return answer;
}

Expected<rooms::RoomAnswer> RoomRecognizer::paper_recognize(
    const image::ColorImage& first, const std::optional<image::ColorImage>& second) const {
  ROOMWISE_TRY(const network::Prediction seen_first, features_->predict(first));
  ROOMWISE_TRY(const auto first_scores, paper_scores(seen_first));
  if (!second)
    return rooms::RoomAnswer{first_scores[0].room, first_scores[0].score,
                             rooms::Reason::kSingleFrame, ""};
  ROOMWISE_TRY(const network::Prediction seen_second, features_->predict(*second));
  ROOMWISE_TRY(const auto second_scores, paper_scores(seen_second));
  return paper_decide(first_scores[0], second_scores[0], [&] { return naming_->predict(*second); });
}

}  // namespace roomwise::pipeline
