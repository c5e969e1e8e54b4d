#include "roomwise/pipeline/objects/own_things.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "roomwise/base/calendar_time.h"
#include "roomwise/base/median.h"
#include "roomwise/base/spread.h"
#include "roomwise/pipeline/stored/keyframe_images.h"
#include "roomwise/pipeline/stored/made_from.h"

namespace roomwise::pipeline {
namespace {

constexpr const char* kOwnThingsData = "own_things";

// What is usual in the pictures of a home: learned from them by calibrate_own_things().
struct OwnThingCalibration {
  objects::HomeBackground background;
  std::map<home::OwnThingId, double> thresholds;
};

Bytes to_bytes(const OwnThingCalibration& usual) {
  nlohmann::json json{{"mean", usual.background.mean}, {"thresholds", nlohmann::json::array()}};
  for (const auto& [id, threshold] : usual.thresholds)
    json["thresholds"].push_back({id, threshold});
  return nlohmann::json::to_cbor(json);
}

Expected<OwnThingCalibration> from_bytes(const Bytes& bytes, const std::string& file) {
  OwnThingCalibration usual;
  try {
    const auto json = nlohmann::json::from_cbor(bytes);
    json.at("mean").get_to(usual.background.mean);
    for (const auto& one : json.at("thresholds")) {
      usual.thresholds[one.at(0).get<home::OwnThingId>()] = one.at(1).get<double>();
    }
  } catch (const nlohmann::json::exception& error) {
    return fail("{}: what is usual in it is damaged ({}); teach a thing anew, or map a walk", file,
                error.what());
  }
  return usual;
}

std::string made_from(std::span<const home::Keyframe> keyframes,
                      std::span<const home::OwnThing> things, const network::Classifier& network,
                      const objects::DetectionFinders& detectors) {
  MadeFrom from;
  from.add("own things 1");
  from.add(network.fingerprint());
  for (const auto& detector : detectors) from.add(detector->fingerprint());
  for (const home::Keyframe& keyframe : keyframes) from.add(keyframe.id);
  for (const home::OwnThing& thing : things) from.add(static_cast<std::uint64_t>(thing.id));
  return from.digest();
}

Expected<std::vector<objects::PreparedThing>> prepare_all(const home::Home& home,
                                                          std::span<const home::OwnThing> things,
                                                          const objects::OwnThingFinder& finder) {
  std::vector<objects::PreparedThing> prepared;
  for (const home::OwnThing& thing : things) {
    ROOMWISE_TRY(const auto views, home.own_thing_views(thing.id));
    auto one = finder.prepare(views);
    if (!one) {
      // By number: its name may be its owner's alone, and this stands in logs.
      return Unexpected(std::move(one).error().with_context(fmt::format(
          "{}: taught thing {}, which can be forgotten and taught anew", home.file(), thing.id)));
    }
    prepared.push_back(*std::move(one));
  }
  return prepared;
}

Expected<const network::Classifier*> needed_network(const Networks& networks) {
  const network::Classifier* const network = network_of_own_things(networks);
  if (network == nullptr) {
    return fail("taught things are looked for by a network, and there is none; see networks list");
  }
  return network;
}

Expected<objects::HomeBackground> background_of_home(const home::Home& home,
                                                     std::span<const home::Keyframe> keyframes,
                                                     const objects::OwnThingFinder& uncalibrated,
                                                     RunContext& run) {
  using Features = Expected<std::vector<std::vector<float>>>;
  std::vector<std::vector<float>> places;
  ROOMWISE_RETURN_IF_ERROR(for_each_keyframe(
      home, keyframes, "looking at what is usual", run,
      [&](const home::Keyframe&, const DecodedImages& images) -> Features {
        return uncalibrated.place_features(images.color);
      },
      [&](const home::Keyframe&, Features features) -> Expected<void> {
        if (!features) return Unexpected(std::move(features).error());
        std::ranges::move(*features, std::back_inserter(places));
        return {};
      }));
  return objects::background_of(places);
}

// When a key-frame was taken, where its stamp tells the date.
std::optional<std::int64_t> seconds_of(TimestampNs timestamp_ns) {
  constexpr TimestampNs kSecond_ns = 1'000'000'000;
  if (!calendar_time(timestamp_ns)) return std::nullopt;
  return timestamp_ns / kSecond_ns;
}

// The same walk, looked through again, tells nothing that was not known.
bool is_news(const home::OwnThingSighting& one, const home::OwnThingSighting& known) {
  if (one == known) return false;
  if (!known.is_known() || !known.seen_s) return true;
  return one.seen_s && *one.seen_s >= *known.seen_s;
}

}  // namespace

// Puts together what is looked for.
class OwnThingWatchBuilder {
 public:
  static std::shared_ptr<const OwnThingWatch> watch(
      std::vector<home::OwnThing> things, std::unique_ptr<const objects::OwnThingFinder> finder,
      std::vector<objects::PreparedThing> prepared, std::vector<double> thresholds) {
    OwnThingWatch watch;
    watch.things_ = std::move(things);
    watch.finder_ = std::move(finder);
    watch.prepared_ = std::move(prepared);
    watch.thresholds_ = std::move(thresholds);
    return std::make_shared<const OwnThingWatch>(std::move(watch));
  }
};

const network::Classifier* network_of_own_things(const Networks& networks) {
  const auto names = std::ranges::find_if(
      networks, [](const auto& network) { return !network->labels().empty(); });
  if (names != networks.end()) return names->get();
  return networks.empty() ? nullptr : networks.front().get();
}

Expected<std::vector<FoundOwnThing>> OwnThingWatch::look(const image::ColorImage& picture) const {
  ROOMWISE_TRY(const auto likeliest, finder_->find(picture, prepared_));
  std::vector<FoundOwnThing> found;
  for (const objects::OwnThingCandidate& one : likeliest) {
    const double above = one.log_odds - thresholds_[one.thing];
    if (above >= 0) found.push_back({things_[one.thing].id, one.box, above});
  }
  return found;
}

Expected<void> calibrate_own_things(home::Home& home, const Networks& networks,
                                    const objects::DetectionFinders& detectors, RunContext& run) {
  ROOMWISE_TRY(const auto things, home.own_things());
  if (things.empty()) return {};
  ROOMWISE_TRY(const network::Classifier* const network, needed_network(networks));
  ROOMWISE_TRY(const auto all, home.keyframes());
  const std::string from = made_from(all, things, *network, detectors);
  ROOMWISE_TRY(const auto kept, home.derived_data(kOwnThingsData));
  if (kept && kept->made_from == from) return {};
  if (all.size() < objects::kMinCalibrationPictures) {
    return fail(
        "{}: has {} pictures of walks; taught things are looked for once there are {}, that tell "
        "what is usual there",
        home.file(), all.size(), objects::kMinCalibrationPictures);
  }
  const std::vector<home::Keyframe> keyframes = spread_evenly(all, kCalibrationPictures);
  const objects::OwnThingModel& model = objects::OwnThingModel::built_in();
  OwnThingCalibration usual;
  {
    const objects::OwnThingFinder uncalibrated(*network, detectors, {}, model);
    ROOMWISE_TRY(usual.background, background_of_home(home, keyframes, uncalibrated, run));
  }
  const objects::OwnThingFinder finder(*network, detectors, usual.background, model);
  ROOMWISE_TRY(const auto prepared, prepare_all(home, things, finder));
  using Scores = Expected<std::vector<objects::OwnThingCandidate>>;
  std::vector<std::vector<double>> scores(things.size());
  ROOMWISE_RETURN_IF_ERROR(for_each_keyframe(
      home, keyframes, "comparing with what was taught", run,
      [&](const home::Keyframe&, const DecodedImages& images) -> Scores {
        return finder.find(images.color, prepared);
      },
      [&](const home::Keyframe&, Scores best) -> Expected<void> {
        if (!best) return Unexpected(std::move(best).error());
        for (const objects::OwnThingCandidate& one : *best) {
          scores[one.thing].push_back(one.log_odds);
        }
        return {};
      }));
  for (std::size_t i = 0; i < things.size(); ++i) {
    ROOMWISE_TRY(usual.thresholds[things[i].id],
                 objects::found_threshold(std::move(scores[i]), model));
  }
  return home.put_derived_data({kOwnThingsData, from, to_bytes(usual)});
}

Expected<std::shared_ptr<const OwnThingWatch>> watch_own_things(
    const home::Home& home, const Networks& networks, const objects::DetectionFinders& detectors) {
  ROOMWISE_TRY(auto things, home.own_things());
  if (things.empty()) return std::shared_ptr<const OwnThingWatch>();
  ROOMWISE_TRY(const network::Classifier* const network, needed_network(networks));
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  ROOMWISE_TRY(const auto kept, home.derived_data(kOwnThingsData));
  if (!kept || kept->made_from != made_from(keyframes, things, *network, detectors)) {
    return fail("{}: what is usual in its pictures is not known yet", home.file());
  }
  ROOMWISE_TRY(const OwnThingCalibration usual, from_bytes(kept->data, home.file()));
  auto finder = std::make_unique<const objects::OwnThingFinder>(
      *network, detectors, usual.background, objects::OwnThingModel::built_in());
  ROOMWISE_TRY(auto prepared, prepare_all(home, things, *finder));
  std::vector<double> thresholds;
  for (const home::OwnThing& thing : things) {
    const auto threshold = usual.thresholds.find(thing.id);
    if (threshold == usual.thresholds.end()) {
      return fail("{}: what is usual in its pictures is not known of taught thing {}", home.file(),
                  thing.id);
    }
    thresholds.push_back(threshold->second);
  }
  return OwnThingWatchBuilder::watch(std::move(things), std::move(finder), std::move(prepared),
                                     std::move(thresholds));
}

Expected<void> check_own_thing_name(const home::Home& home, const std::string& name) {
  ROOMWISE_TRY(const auto rooms, home.rooms());
  if (std::ranges::find(rooms, name, &rooms::Room::name) != rooms.end()) {
    return fail_with(ErrorCode::kRefused,
                     "{0} is a room of this home; say more of the thing, such as \"my {0}\"", name);
  }
  ROOMWISE_TRY(const rooms::Concepts concepts, home.concepts());
  ROOMWISE_TRY(const auto instances, home.instances());
  const bool is_found =
      std::ranges::find(instances, name, &objects::Instance::name) != instances.end();
  if (is_found || concepts.vocabulary.objects().contains(name)) {
    return fail_with(ErrorCode::kRefused,
                     "any {0} is called so; say whose or which it is, such as \"my {0}\"", name);
  }
  return {};
}

Expected<home::OwnThingId> teach_own_thing(home::Home& home, home::OwnThing thing,
                                           std::span<const objects::ShownThing> shown,
                                           const Networks& networks) {
  ROOMWISE_RETURN_IF_ERROR(check_own_thing_name(home, thing.name));
  if (shown.size() < kMinPicturesShown) {
    return fail("{} pictures show it well enough; {} are needed: show it from all sides",
                shown.size(), kMinPicturesShown);
  }
  ROOMWISE_TRY(const network::Classifier* const network, needed_network(networks));
  const objects::DetectionFinders none;
  const objects::OwnThingFinder finder(*network, none, {}, objects::OwnThingModel::built_in());
  ROOMWISE_TRY(const auto chosen, finder.choose_views(shown, kViewsOfAThing));
  std::vector<objects::TaughtView> views;
  for (const std::size_t i : chosen) views.push_back(objects::taught_view(shown[i]));
  return home.add_own_thing(thing, views);
}

std::optional<Eigen::Vector3d> middle_by_depth(const image::DepthImage& depth,
                                               const geometry::PinholeCamera& camera,
                                               const network::PixelBox& box) {
  const auto inner = [](float low, float high) {
    const float third = (high - low) / 3;
    return std::pair(static_cast<int>(low + third), static_cast<int>(high - third) + 1);
  };
  const auto [left, right] = inner(box.left, box.right);
  const auto [top, bottom] = inner(box.top, box.bottom);
  std::vector<double> measured_m;
  for (int y = top; y < bottom; ++y) {
    for (int x = left; x < right; ++x) {
      if (!depth.contains(x, y) || depth.at(x, y) == 0) continue;
      measured_m.push_back(image::depth_m(depth, camera, x, y));
    }
  }
  if (measured_m.empty()) return std::nullopt;
  const Eigen::Vector2d middle((box.left + box.right) / 2, (box.top + box.bottom) / 2);
  return camera.unproject(middle, median_of(measured_m));
}

Expected<OwnThingSightings> own_things_in(const OwnThingPicture& picture,
                                          const OwnThingWatch& watch) {
  ROOMWISE_TRY(const auto found, watch.look(picture.color));
  OwnThingSightings seen;
  for (const FoundOwnThing& one : found) {
    auto middle = middle_by_depth(picture.depth, picture.camera, one.box);
    if (middle) middle = picture.keyframe_from_camera * *middle;
    seen[one.id] = {seconds_of(picture.timestamp_ns), std::nullopt, picture.keyframe, middle};
  }
  return seen;
}

Expected<OwnThingSightings> find_own_things(const home::Home& home, home::RecordingId walk,
                                            const OwnThingWatch& watch, RunContext& run) {
  ROOMWISE_TRY(const auto all, home.keyframes());
  ROOMWISE_TRY(const auto cameras, recording_cameras(home));
  std::vector<home::Keyframe> of_walk;
  std::ranges::copy_if(all, std::back_inserter(of_walk),
                       [&](const home::Keyframe& keyframe) { return keyframe.recording == walk; });
  const std::vector<home::Keyframe> looked_at = spread_evenly(of_walk, kWalkPictures);
  OwnThingSightings last;
  ROOMWISE_RETURN_IF_ERROR(for_each_keyframe(
      home, looked_at, "looking for what was taught", run,
      [&](const home::Keyframe& keyframe, const DecodedImages& images) {
        return own_things_in({images.color, images.depth, cameras.at(keyframe.recording),
                              keyframe.timestamp_ns, keyframe.id},
                             watch);
      },
      [&](const home::Keyframe&, Expected<OwnThingSightings> seen) -> Expected<void> {
        if (!seen) return Unexpected(std::move(seen).error());
        for (const auto& [id, sighting] : *seen) last[id] = sighting;
        return {};
      }));
  return last;
}

Expected<std::size_t> note_own_things(home::Home& home, const OwnThingSightings& seen) {
  ROOMWISE_TRY(const auto things, home.own_things());
  std::size_t noted = 0;
  for (const home::OwnThing& thing : things) {
    const auto found = seen.find(thing.id);
    if (found == seen.end() || !is_news(found->second, thing.last_seen)) continue;
    ROOMWISE_RETURN_IF_ERROR(home.put_own_thing_sighting(thing.id, found->second));
    ++noted;
  }
  return noted;
}

Expected<OwnThingLook> look_for_own_things(home::Home& home, const Networks& networks,
                                           const objects::DetectionFinders& detectors,
                                           RunContext& run) {
  OwnThingLook look;
  if (const auto usual = calibrate_own_things(home, networks, detectors, run); !usual) {
    if (usual.error().code == ErrorCode::kInterrupted) return Unexpected(usual.error());
    look.is_looked_for = false;
    look.why = usual.error().message;
    return look;
  }
  ROOMWISE_TRY(const auto watch, watch_own_things(home, networks, detectors));
  ROOMWISE_TRY(const auto recordings, home.recordings());
  if (watch == nullptr || recordings.empty()) return look;
  ROOMWISE_TRY(const auto seen, find_own_things(home, recordings.back().id, *watch, run));
  ROOMWISE_RETURN_IF_ERROR(note_own_things(home, seen).map([](std::size_t) {}));
  look.seen = seen.size();
  return look;
}

}  // namespace roomwise::pipeline
