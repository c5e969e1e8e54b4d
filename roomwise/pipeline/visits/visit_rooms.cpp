#include "roomwise/pipeline/visits/visit_rooms.h"

#include <algorithm>
#include <map>

#include "roomwise/base/file.h"
#include "roomwise/image/codec.h"

namespace roomwise::pipeline {
namespace {

// What is remembered of earlier visits, with this visit's pictures after them; of each room the
// oldest go until no more are left than may be.
std::vector<home::VisitPicture> joined(const std::vector<home::VisitPicture>& before,
                                       std::vector<home::VisitPicture> now, std::size_t most,
                                       const std::string& network, RoomUpdate& update) {
  std::map<std::string, std::size_t> too_many;
  for (RoomUpdate::OfRoom& of_room : update.rooms) {
    const auto known = static_cast<std::size_t>(
        std::ranges::count_if(before, [&](const home::VisitPicture& picture) {
          return picture.room == of_room.room && picture.network_fingerprint == network;
        }));
    of_room.outdated = known + of_room.learned > most ? known + of_room.learned - most : 0;
    too_many[of_room.room] = of_room.outdated;
  }
  std::vector<home::VisitPicture> pictures;
  for (const home::VisitPicture& picture : before) {
    const auto left = too_many.find(picture.room);
    if (picture.network_fingerprint == network && left != too_many.end() && left->second > 0) {
      --left->second;
      continue;
    }
    pictures.push_back(picture);
  }
  std::ranges::move(now, std::back_inserter(pictures));
  return pictures;
}

}  // namespace

Expected<VisitRooms> VisitRooms::create(const home::Home& home, const Networks& networks,
                                        const rooms::VisitLearningOptions& options,
                                        const mapping::LocalizerOptions& localizer,
                                        RunContext& run) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  ROOMWISE_TRY(RoomRecognizer recognizer, RoomRecognizer::create(home, networks));
  ROOMWISE_TRY(HomePlaces places, HomePlaces::create(home, localizer, run));
  return VisitRooms(std::move(places), std::move(recognizer), options);
}

Expected<SeenPicture> VisitRooms::look(const image::RgbdFrame& frame,
                                       const mapping::Localization& found) const {
  ROOMWISE_TRY(network::Prediction seen, recognizer_.features().predict(frame.color));
  ROOMWISE_TRY(rooms::PictureEvidence evidence, recognizer_.evidence(seen));
  return SeenPicture{.picture = {.keyframe = found.keyframe,
                                 .timestamp_ns = frame.timestamp_ns,
                                 .picture_digest = sha256_hex(image::color_file(frame)),
                                 .room = {},
                                 .network_fingerprint = recognizer_.features().fingerprint(),
                                 .features = std::move(seen.features)},
                     .evidence = std::move(evidence),
                     .place = places_.evidence(found, /*has_depth=*/true, recognizer_.rooms())};
}

Expected<RoomUpdate> VisitRooms::update(const home::Home& home,
                                        std::span<const SeenPicture> walk) const {
  if (!places_.tells_rooms()) {
    return RoomUpdate{.why_not = "the map does not show where they lie"};
  }
  rooms::RoomStream stream = recognizer_.stream();
  ROOMWISE_TRY(const auto before, home.visit_pictures());
  const auto looks =
      observations_along_walk(std::move(stream), recognizer_.rooms(), walk, options_);
  return refresh_rooms(recognizer_.classifier(), looks, before, options_);
}

std::vector<RoomObservation> observations_along_walk(rooms::RoomStream stream,
                                                     std::span<const std::string> names,
                                                     std::span<const SeenPicture> walk,
                                                     const rooms::VisitLearningOptions& options) {
  std::vector<RoomObservation> looks;
  for (std::size_t i = 0; i < walk.size(); ++i) {
    const SeenPicture& seen = walk[i];
    const TimestampNs before_ns = walk[i == 0 ? 0 : i - 1].picture.timestamp_ns;
    const rooms::RoomDecision decision = stream.update(
        seen.evidence, 1e-9 * static_cast<double>(seen.picture.timestamp_ns - before_ns));
    RoomObservation& look =
        looks.emplace_back(RoomObservation{seen.picture.picture_digest, {}, {}});
    look.agreement = {rooms::room_by_picture(seen.evidence, decision, names),
                      rooms::room_by_place(seen.place, options)};
    if (!look.agreement.is_agreed()) continue;
    look.picture = seen.picture;
    look.picture->room = names[*look.agreement.by_place];
  }
  return looks;
}

Expected<RoomUpdate> refresh_rooms(const rooms::RoomClassifier& classifier,
                                   std::span<const RoomObservation> looks,
                                   const std::vector<home::VisitPicture>& before,
                                   const rooms::VisitLearningOptions& options) {
  RoomUpdate update;
  for (const std::string& room : classifier.rooms()) update.rooms.push_back({.room = room});
  std::map<std::string, std::string> known;  // the rooms of remembered pictures, by digest
  for (const home::VisitPicture& picture : before) {
    if (picture.network_fingerprint == classifier.network().fingerprint)
      known.emplace(picture.picture_digest, picture.room);
  }
  std::map<std::string, std::size_t> remembered;  // of this walk, by room
  std::vector<rooms::RoomPicture> agreed;
  std::vector<const home::VisitPicture*> pictures;  // the same
  for (const RoomObservation& look : looks) {
    const auto found = known.find(look.picture_digest);
    if (found != known.end()) ++remembered[found->second];
    if (look.agreement.is_contradictory()) ++update.contradictory;
    if (!look.picture && !look.agreement.is_contradictory()) ++update.unsure;
    if (!look.picture) continue;
    ++update.rooms[*look.agreement.by_place].agreed;
    if (found != known.end()) continue;
    agreed.push_back({look.picture->features, look.picture->room});
    pictures.push_back(&*look.picture);
  }
  ROOMWISE_TRY(const auto chosen, rooms::choose_pictures(classifier, agreed, options, remembered));
  if (chosen.empty()) {
    update.was_learned = !remembered.empty();
    return update;
  }
  std::vector<home::VisitPicture> now;
  for (const std::size_t i : chosen) {
    now.push_back(*pictures[i]);
    ++std::ranges::find(update.rooms, now.back().room, &RoomUpdate::OfRoom::room)->learned;
  }
  update.pictures =
      joined(before, std::move(now), options.max_of_room, classifier.network().fingerprint, update);
  return update;
}

Expected<std::string> why_rooms_cannot_be_refreshed(const home::Home& home) {
  ROOMWISE_TRY(const auto record, home.room_classifier());
  if (!record) return "no rooms were learned yet; learn them: roomwise rooms learn";
  const auto classifier = rooms::RoomClassifier::from_bytes(record->classifier);
  if (!classifier) return Unexpected(Error(classifier.error()).with_context(home.file()));
  return std::string();
}

}  // namespace roomwise::pipeline
