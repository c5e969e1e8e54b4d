#include "roomwise/pipeline/room_recognizer.h"

#include <algorithm>

#include "roomwise/pipeline/room_learning.h"

namespace roomwise::pipeline {

Expected<RoomRecognizer> RoomRecognizer::create(const home::Home& home, const Networks& networks) {
  ROOMWISE_TRY(const auto record, home.room_classifier());
  if (!record) return fail("{}: no rooms were learned yet; use rooms learn", home.file());
  auto classifier = rooms::RoomClassifier::from_bytes(record->classifier);
  if (!classifier) return Unexpected(std::move(classifier).error().in(home.file()));
  const auto same = std::ranges::find_if(networks, [&](const auto& network) {
    return network->fingerprint() == record->network_fingerprint;
  });
  if (same == networks.end()) {
    return fail(
        "{}: its rooms were learned with the network {}; give that file by --network, or its "
        "folder as ROOMWISE_MODELS",
        home.file(), record->network_name);
  }
  ROOMWISE_TRY(rooms::Concepts concepts, home.concepts());
  ROOMWISE_TRY(std::vector<rooms::Room> rooms, home.rooms());
  std::erase_if(rooms, [&](const rooms::Room& room) {
    return std::ranges::count(classifier->rooms(), room.name) == 0;
  });
  return RoomRecognizer(*std::move(classifier), std::move(concepts), std::move(rooms), same->get(),
                        naming_network(networks));
}

Expected<rooms::RoomAnswer> RoomRecognizer::decide(const rooms::RoomScore& first,
                                                   const rooms::RoomScore& second,
                                                   const SeeNames& named_second) const {
  constexpr std::size_t kTop = 3;  // the paper looks at the three best
  Expected<void> status;
  const auto objects = [&]() -> std::vector<objects::Sighting> {
    if (naming_ == nullptr) return {};
    const auto seen = named_second();
    if (!seen) {
      status = Unexpected(seen.error());
      return {};
    }
    return objects::top_objects(seen->scores, naming_->labels(), concepts_.vocabulary, kTop);
  };
  const rooms::RoomAnswer answer = rooms::decide(first, second, objects, concepts_, rooms_);
  ROOMWISE_CHECK_OK(status);
  return answer;
}

Expected<rooms::RoomAnswer> RoomRecognizer::recognize(
    const image::ColorImage& first, const std::optional<image::ColorImage>& second) const {
  ROOMWISE_TRY(const network::Prediction seen_first, features_->predict(first));
  ROOMWISE_TRY(const auto first_scores, scores(seen_first));
  if (!second)
    return rooms::RoomAnswer{first_scores[0].room, first_scores[0].score,
                             rooms::Reason::kSingleFrame, ""};
  ROOMWISE_TRY(const network::Prediction seen_second, features_->predict(*second));
  ROOMWISE_TRY(const auto second_scores, scores(seen_second));
  return decide(first_scores[0], second_scores[0], [&] { return naming_->predict(*second); });
}

}  // namespace roomwise::pipeline
