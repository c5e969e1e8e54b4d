// The part of Home that stores what key-frames and rooms mean: networks, objects, concepts, rooms.

#include "roomwise/base/in_context.h"
#include "roomwise/home/home.h"
#include "roomwise/home/stored_values.h"

namespace roomwise::home {
namespace {

// A point in the three columns from `first` on, which are NULL together.
std::optional<Eigen::Vector3d> point_column(const Statement& row, int first) {
  if (!row.column<std::optional<double>>(first)) return std::nullopt;
  const auto [x, y, z] = row.columns<3>(first);
  return Eigen::Vector3d(x, y, z);
}

}  // namespace

Expected<NetworkId> Home::add_network(const Network& network) {
  ROOMWISE_TRY(const auto stored, networks());
  for (const auto& [id, other] : stored) {
    if (other.fingerprint != network.fingerprint) continue;
    if (other == network) return id;
    return fail(
        "{}: knows the network {} by another name, other labels or another feature size (as "
        "{}); give it as it was when the home was made",
        file(), network.name, other.name);
  }
  ROOMWISE_TRY(const std::string labels, labels_to_json("network " + network.name, network.labels));
  return database_.insert("networks (name, fingerprint, labels, feature_size)", network.name,
                          network.fingerprint, labels, network.feature_size);
}

Expected<std::map<NetworkId, Network>> Home::networks() const {
  return collect<std::map<NetworkId, Network>>(
      database_, "SELECT network_id, name, fingerprint, labels, feature_size FROM networks",
      [&](const Statement& row) -> Expected<std::pair<NetworkId, Network>> {
        const auto name = row.column<std::string>(1);
        ROOMWISE_TRY(auto labels, labels_column(row, 3, file(), "network " + name));
        return std::pair(row.column<NetworkId>(0),
                         Network{name, row.column<std::string>(2), std::move(labels),
                                 row.column<std::size_t>(4)});
      });
}

Expected<void> Home::put_prediction(KeyframeId keyframe, NetworkId network,
                                    const network::Prediction& prediction) {
  ROOMWISE_TRY(const auto feature_size,
               database_.find<std::size_t>("SELECT feature_size FROM networks WHERE network_id = ?",
                                           network));
  if (!feature_size) return fail("{}: has no network {}", file(), network);
  if (prediction.features.size() != *feature_size) {
    return fail("{}: a prediction for key-frame {} has {} features, but its network gives {}",
                file(), keyframe, prediction.features.size(), *feature_size);
  }
  return database_.put("keyframe_predictions (keyframe_id, network_id, features, scores)", keyframe,
                       network, to_blob(prediction.features), to_blob(prediction.scores));
}

Expected<std::optional<network::Prediction>> Home::prediction(KeyframeId keyframe,
                                                              NetworkId network) const {
  std::optional<network::Prediction> prediction;
  ROOMWISE_RETURN_IF_ERROR(database_.for_each(
      "SELECT features, scores FROM keyframe_predictions WHERE keyframe_id = ? AND network_id = ?",
      [&](const Statement& row) {
        prediction = {to_floats(row.column<Bytes>(0)), to_floats(row.column<Bytes>(1))};
      },
      keyframe, network));
  return prediction;
}

Expected<std::map<KeyframeId, network::Prediction>> Home::predictions(NetworkId network) const {
  return collect<std::map<KeyframeId, network::Prediction>>(
      database_,
      "SELECT keyframe_id, features, scores FROM keyframe_predictions WHERE network_id = ?",
      [](const Statement& row) {
        return std::pair(
            row.column<KeyframeId>(0),
            network::Prediction{to_floats(row.column<Bytes>(1)), to_floats(row.column<Bytes>(2))});
      },
      network);
}

Expected<void> Home::put_observations(KeyframeId keyframe,
                                      std::span<const objects::ObjectScore> observations) {
  return atomically([&]() -> Expected<void> {
    ROOMWISE_RETURN_IF_ERROR(
        database_.run("DELETE FROM keyframe_observations WHERE keyframe_id = ?", keyframe));
    for (const objects::ObjectScore& observation : observations) {
      ROOMWISE_RETURN_IF_ERROR(database_.add("keyframe_observations (keyframe_id, object, score)",
                                             keyframe, observation.object, observation.score));
    }
    return {};
  });
}

Expected<std::map<KeyframeId, std::vector<objects::ObjectScore>>> Home::observations() const {
  std::map<KeyframeId, std::vector<objects::ObjectScore>> observations;
  ROOMWISE_RETURN_IF_ERROR(
      database_.for_each("SELECT keyframe_id, object, score FROM keyframe_observations "
                         "ORDER BY keyframe_id, score DESC, object",
                         [&](const Statement& row) {
                           observations[row.column<KeyframeId>(0)].push_back(
                               {row.column<std::string>(1), row.column<double>(2)});
                         }));
  return observations;
}

Expected<void> Home::replace_confirmed_objects(std::span<const objects::ConfirmedObject> objects) {
  return atomically([&]() -> Expected<void> {
    ROOMWISE_RETURN_IF_ERROR(database_.run("DELETE FROM objects"));
    for (const objects::ConfirmedObject& object : objects) {
      std::optional<std::array<double, 3>> position;
      if (const auto& p = object.position_keyframe) {
        if (!p->allFinite()) {
          return fail("{}: the position of object '{}' is not finite", file(), object.name);
        }
        position = {p->x(), p->y(), p->z()};
      }
      ROOMWISE_RETURN_IF_ERROR(database_.add(
          "objects (name, keyframe_id, score, observations, x_m, y_m, z_m)", object.name,
          object.keyframe_id, object.score, object.observations, position));
    }
    return {};
  });
}

Expected<std::vector<objects::ConfirmedObject>> Home::confirmed_objects() const {
  return collect<std::vector<objects::ConfirmedObject>>(
      database_,
      "SELECT name, keyframe_id, score, observations, x_m, y_m, z_m FROM objects "
      "ORDER BY object_id",
      [](const Statement& row) {
        return objects::ConfirmedObject{.name = row.column<std::string>(0),
                                        .keyframe_id = row.column<KeyframeId>(1),
                                        .score = row.column<double>(2),
                                        .observations = row.column<int>(3),
                                        .position_keyframe = point_column(row, 4)};
      });
}

Expected<void> Home::replace_concepts(const rooms::Concepts& concepts) {
  return atomically([&]() -> Expected<void> {
    ROOMWISE_RETURN_IF_ERROR(database_.run_script(
        "DELETE FROM has_a; DELETE FROM room_types; DELETE FROM object_labels; "
        "DELETE FROM object_kinds;"));
    const auto& vocabulary = concepts.vocabulary.objects();
    for (const auto& [object, labels] : vocabulary) {
      ROOMWISE_RETURN_IF_ERROR(database_.add("object_kinds (object)", object));
      for (const std::string& label : labels) {
        ROOMWISE_RETURN_IF_ERROR(database_.add("object_labels (label, object)", label, object));
      }
    }
    for (const auto& [room_type, objects] : concepts.objects_of_room_type) {
      ROOMWISE_RETURN_IF_ERROR(database_.add("room_types (room_type)", room_type));
      for (const std::string& object : objects) {
        if (!vocabulary.contains(object)) {
          return fail(
              "{}: room type '{}' is said to have a '{}', which is no known object; add the "
              "object first",
              file(), room_type, object);
        }
        ROOMWISE_RETURN_IF_ERROR(database_.add("has_a (room_type, object)", room_type, object));
      }
    }
    return {};
  });
}

Expected<rooms::Concepts> Home::concepts() const {
  std::map<std::string, std::vector<std::string>> labels;
  ROOMWISE_RETURN_IF_ERROR(database_.for_each(
      "SELECT object, label FROM object_kinds LEFT JOIN object_labels USING (object)",
      [&](const Statement& row) {
        auto& of_object = labels[row.column<std::string>(0)];
        if (auto label = row.column<std::optional<std::string>>(1)) {
          of_object.push_back(*std::move(label));
        }
      }));
  rooms::Concepts concepts;
  for (const auto& [object, of_object] : labels) {
    if (auto added = concepts.vocabulary.add(object, of_object); !added) {
      return Unexpected(std::move(added).error().with_context(file()));
    }
  }
  ROOMWISE_RETURN_IF_ERROR(database_.for_each(
      "SELECT room_type, object FROM room_types LEFT JOIN has_a USING (room_type)",
      [&](const Statement& row) {
        auto& objects = concepts.objects_of_room_type[row.column<std::string>(0)];
        if (auto object = row.column<std::optional<std::string>>(1)) {
          objects.insert(*std::move(object));
        }
      }));
  return concepts;
}

Expected<void> Home::replace_rooms(std::span<const rooms::Room> rooms) {
  return atomically([&]() -> Expected<void> {
    // Rooms that ranges belong to may be missing until the new ones are in.
    ROOMWISE_RETURN_IF_ERROR(database_.run("PRAGMA defer_foreign_keys = ON"));
    ROOMWISE_RETURN_IF_ERROR(database_.run("DELETE FROM rooms"));
    for (const rooms::Room& room : rooms) {
      ROOMWISE_RETURN_IF_ERROR(recording::validate_room_name(room.name));
      ROOMWISE_RETURN_IF_ERROR(database_.add("rooms (room, room_type)", room.name, room.type));
    }
    ROOMWISE_TRY(const auto orphan,
                 database_.find<std::string>("SELECT room FROM room_ranges WHERE room NOT IN "
                                             "(SELECT room FROM rooms) ORDER BY room"));
    if (!orphan) return {};
    return fail(
        "{}: room '{}' cannot go, since frames of a recording belong to it; name their rooms "
        "anew first",
        file(), *orphan);
  });
}

Expected<std::vector<rooms::Room>> Home::rooms() const {
  return collect<std::vector<rooms::Room>>(
      database_, "SELECT room, room_type FROM rooms ORDER BY room", [](const Statement& row) {
        return rooms::Room{row.column<std::string>(0), row.column<std::string>(1)};
      });
}

Expected<void> Home::replace_room_ranges(RecordingId id,
                                         const std::vector<recording::RoomRange>& ranges) {
  ROOMWISE_TRY(const auto labels, recording::RoomLabels::from_ranges(ranges));
  return atomically([&]() -> Expected<void> {
    ROOMWISE_RETURN_IF_ERROR(database_.run("DELETE FROM room_ranges WHERE recording_id = ?", id));
    for (const recording::RoomRange& range : labels.ranges()) {
      ROOMWISE_TRY(const bool known,
                   database_.get<bool>("SELECT count(*) FROM rooms WHERE room = ?", range.room));
      if (!known) {
        return fail(
            "{}: frames {} to {} are said to show '{}', which is no room of this home; add "
            "the room first",
            file(), range.first_frame, range.last_frame, range.room);
      }
      ROOMWISE_RETURN_IF_ERROR(database_.add(
          "room_ranges (recording_id, first_frame_index, last_frame_index, room, visit)", id,
          range.first_frame, range.last_frame, range.room, range.stay));
    }
    return {};
  });
}

Expected<recording::RoomLabels> Home::room_ranges(RecordingId id) const {
  ROOMWISE_TRY(auto ranges,
               collect<std::vector<recording::RoomRange>>(
                   database_,
                   "SELECT first_frame_index, last_frame_index, room, visit FROM room_ranges "
                   "WHERE recording_id = ? ORDER BY first_frame_index",
                   [](const Statement& row) {
                     return recording::RoomRange{row.column<std::uint64_t>(0),
                                                 row.column<std::uint64_t>(1),
                                                 row.column<std::string>(2), row.column<int>(3)};
                   },
                   id));
  return in_context(file(), recording::RoomLabels::from_ranges(std::move(ranges)));
}

Expected<void> Home::put_room_classifier(const RoomClassifierRecord& classifier) {
  return atomically([&]() -> Expected<void> {
    ROOMWISE_RETURN_IF_ERROR(
        database_.run("DELETE FROM room_classifiers WHERE network_fingerprint = ?",
                      classifier.network_fingerprint));
    return database_.add("room_classifiers (network_name, network_fingerprint, classifier, report)",
                         classifier.network_name, classifier.network_fingerprint,
                         classifier.classifier, classifier.report_json);
  });
}

Expected<void> Home::forget_learned_rooms() {
  return atomically([&]() -> Expected<void> {
    ROOMWISE_RETURN_IF_ERROR(database_.run("DELETE FROM room_classifiers"));
    ROOMWISE_RETURN_IF_ERROR(database_.run("DELETE FROM keyframe_rooms"));
    ROOMWISE_RETURN_IF_ERROR(database_.run("DELETE FROM visit_pictures"));
    return database_.run("DELETE FROM picture_features");
  });
}

Expected<std::optional<RoomClassifierRecord>> Home::room_classifier() const {
  ROOMWISE_TRY(auto all, room_classifiers());
  if (all.empty()) return std::optional<RoomClassifierRecord>();
  return std::optional(std::move(all.front()));
}

Expected<std::vector<RoomClassifierRecord>> Home::room_classifiers() const {
  return collect<std::vector<RoomClassifierRecord>>(
      database_,
      "SELECT network_name, network_fingerprint, classifier, report FROM room_classifiers "
      "ORDER BY classifier_id DESC",
      [](const Statement& row) {
        return RoomClassifierRecord{row.column<std::string>(0), row.column<std::string>(1),
                                    row.column<Bytes>(2), row.column<std::string>(3)};
      });
}

Expected<void> Home::replace_picture_features(const std::string& network_fingerprint,
                                              const std::string& augmentation,
                                              std::span<const PictureFeatures> features) {
  return atomically([&]() -> Expected<void> {
    ROOMWISE_RETURN_IF_ERROR(database_.run("DELETE FROM picture_features"));
    for (const PictureFeatures& of_picture : features) {
      ROOMWISE_RETURN_IF_ERROR(
          database_.add("picture_features (picture_digest, network_fingerprint, augmentation, "
                        "variant, keyframe_id, features)",
                        of_picture.picture_digest, network_fingerprint, augmentation,
                        of_picture.variant, of_picture.keyframe, to_blob(of_picture.features)));
    }
    return {};
  });
}

Expected<std::vector<PictureFeatures>> Home::picture_features(
    const std::string& network_fingerprint, const std::string& augmentation) const {
  return collect<std::vector<PictureFeatures>>(
      database_,
      "SELECT picture_digest, variant, keyframe_id, features FROM picture_features "
      "WHERE network_fingerprint = ? AND augmentation = ? ORDER BY picture_digest, variant",
      [](const Statement& row) {
        return PictureFeatures{row.column<std::string>(0), row.column<int>(1),
                               row.column<std::optional<KeyframeId>>(2),
                               to_floats(row.column<Bytes>(3))};
      },
      network_fingerprint, augmentation);
}

Expected<void> Home::replace_keyframe_rooms(
    const std::map<KeyframeId, std::vector<rooms::RoomScore>>& rooms) {
  return atomically([&]() -> Expected<void> {
    ROOMWISE_RETURN_IF_ERROR(database_.run("DELETE FROM keyframe_rooms"));
    for (const auto& [keyframe, scores] : rooms) {
      for (const rooms::RoomScore& score : scores) {
        ROOMWISE_RETURN_IF_ERROR(database_.add("keyframe_rooms (keyframe_id, room, score)",
                                               keyframe, score.room, score.score));
      }
    }
    return {};
  });
}

Expected<std::map<KeyframeId, std::vector<rooms::RoomScore>>> Home::keyframe_rooms() const {
  std::map<KeyframeId, std::vector<rooms::RoomScore>> rooms;
  ROOMWISE_RETURN_IF_ERROR(
      database_.for_each("SELECT keyframe_id, room, score FROM keyframe_rooms "
                         "ORDER BY keyframe_id, score DESC, room",
                         [&](const Statement& row) {
                           rooms[row.column<KeyframeId>(0)].push_back(
                               {row.column<std::string>(1), row.column<double>(2)});
                         }));
  return rooms;
}

}  // namespace roomwise::home
