#include "roomwise/live/device/frame_processor.h"

#include <algorithm>
#include <cmath>

namespace roomwise::live {
namespace {

// After a gap this long the room may be any again, s: nobody stays that long without a picture.
constexpr double kForgetAfter_s = 60;

// What stands ahead, as the camera sees it (ahead, left); by the place on the map its height and
// tilt are known.
Expected<std::vector<Eigen::Vector2d>> obstacles_ahead(const image::DepthImage& depth,
                                                       const geometry::PinholeCamera& camera,
                                                       const std::optional<CameraPose>& place,
                                                       const LiveMap* map) {
  guide::ObstacleOptions options;
  const bool has_floor = map != nullptr && map->frame.has_floor;
  // Over stairs each step would be one, and who climbs them knows.
  if (place && has_floor && map->frame.storeys.stairs_at(place->position_plan().head<2>())) {
    return std::vector<Eigen::Vector2d>();
  }
  if (place) {
    options.up_camera = place->plan_from_camera.rotation.inverse() * Eigen::Vector3d::UnitZ();
    if (has_floor) options.camera_height_m = place->position_plan().z();
  }
  return guide::obstacles_seen(depth, camera, options);
}

}  // namespace

double CameraPose::heading_rad() const {
  const Eigen::Vector3d axis = plan_from_camera.rotation * Eigen::Vector3d::UnitZ();
  return std::atan2(axis.y(), axis.x());
}

guide::Pose CameraPose::on_floor() const {
  return {position_plan().head<2>(), heading_rad(), sigma_m};
}

Expected<std::optional<rooms::RoomDecision>> FrameProcessor::decide(
    const image::ColorImage& color, const std::optional<mapping::Localization>& answer,
    bool has_depth, const std::shared_ptr<const HomeView>& home) {
  if (!home->recognizer) return std::optional<rooms::RoomDecision>();
  const pipeline::RoomRecognizer& recognizer = *home->recognizer;
  double elapsed_s = decided_s_ ? passed_s_ - *decided_s_ : 0;
  if (stream_recognizer_ != home->recognizer || !(elapsed_s < kForgetAfter_s)) {
    stream_ = recognizer.stream();
    stream_recognizer_ = home->recognizer;
    elapsed_s = 0;
  }
  ROOMWISE_TRY(const auto seen, recognizer.features().predict(color));
  ROOMWISE_TRY(const rooms::PictureEvidence evidence, recognizer.evidence(seen));
  decided_s_ = passed_s_;
  pipeline::RoomRecognizer::Localize localize;
  // What a picture alone does not tell of the place is no evidence of its own.
  if (answer && !answer->is_carried) {
    localize = [&]() -> Expected<rooms::LocalizationEvidence> {
      return rooms::localization_evidence(*answer, has_depth, home->map->frame, home->layout,
                                          recognizer.rooms());
    };
  }
  return recognizer.update(*stream_, evidence, elapsed_s, localize);
}

Expected<std::optional<mapping::Localization>> FrameProcessor::locate(
    const image::ColorImage& color, const std::optional<image::DepthImage>& depth,
    const HomeView& home, FrameResult& result) {
  if (!home.map || !home.map->localizer) return std::optional<mapping::Localization>();
  if (!camera_->calibrated) {
    ROOMWISE_TRY(const mapping::Localization answer,
                 home.map->localizer->locate_uncalibrated(color, lens_.estimate()));
    if (lens_.add(answer)) result.lens = lens_;
    return std::optional(answer);
  }
  const geometry::PinholeCamera& camera = *camera_->calibrated;
  ROOMWISE_TRY(motion::FrameMeasurements measured,
               home.map->localizer->measure({color, depth, camera}));
  if (track_localizer_ != home.map->localizer) {
    track_.forget();
    track_localizer_ = home.map->localizer;
  }
  return track_.locate(track_localizer_->localizer(), std::move(measured), camera,
                       result.t_ms / 1000);
}

// What it costs does not grow with the number of things: OwnThingSearch bounds the places that a
// picture is compared at, and this how often.
Expected<void> FrameProcessor::look_for_own_things(const FrameImages& images, const HomeView& home,
                                                   FrameResult& result) {
  constexpr double kBetweenLooks_s = 1;
  if (home.own_thing_watch == nullptr) return {};
  if (looked_for_own_s_ && passed_s_ - *looked_for_own_s_ < kBetweenLooks_s) return {};
  looked_for_own_s_ = passed_s_;
  ROOMWISE_TRY(const auto found, home.own_thing_watch->look(images.color));
  for (const pipeline::FoundOwnThing& one : found) {
    SeenOwnThing seen{one.id, std::nullopt, std::nullopt};
    if (images.depth && result.place && camera_->calibrated) {
      const auto middle = pipeline::middle_by_depth(*images.depth, *camera_->calibrated, one.box);
      if (middle) seen.place_plan = result.place->plan_from_camera * *middle;
    }
    if (seen.place_plan) seen.room = home.room_at(*seen.place_plan);
    if (!seen.room && result.place) seen.room = result.place->room;
    if (!seen.room && result.decision) seen.room = result.decision->room();
    result.own_things.push_back(std::move(seen));
  }
  return {};
}

Expected<FrameResult> FrameProcessor::look(CameraFrame frame,
                                           const std::shared_ptr<const HomeView>& home) {
  if (!camera_) return fail("this device said in its hello that it has no camera");
  if (last_) {
    const double by_device_s = (frame.t_ms - last_->t_ms) / 1000;
    passed_s_ += std::max({0.0, by_device_s, frame.came_s - last_->came_s});
  }
  last_ = {frame.t_ms, frame.came_s};
  ROOMWISE_TRY(FrameImages read, images_of(frame, *camera_));
  const auto images = std::make_shared<const FrameImages>(std::move(read));
  const image::ColorImage& color = images->color;
  const std::optional<image::DepthImage>& depth = images->depth;
  FrameResult result;
  result.images = images;
  result.t_ms = frame.t_ms;
  result.has_depth = depth.has_value();
  ROOMWISE_TRY(const auto answer, locate(color, depth, *home, result));
  if (answer && answer->found()) {
    result.place = CameraPose{
        home->map->frame.on_plan(answer->world_from_camera), answer->position_sigma_m(), {}};
    result.place->room = home->room_at(result.place->position_plan());
  }
  ROOMWISE_TRY(result.decision, decide(color, answer, depth.has_value(), home));
  ROOMWISE_RETURN_IF_ERROR(look_for_own_things(*images, *home, result));
  if (depth) {
    ROOMWISE_TRY(const auto seen,
                 obstacles_ahead(*depth, *camera_->calibrated, result.place, home->map.get()));
    result.obstacle = guide::nearest_ahead(seen);
    const double farthest_m = guide::ObstacleOptions().farthest_m;
    if (const auto ahead = guide::nearest_ahead(seen, {.length_m = farthest_m})) {
      result.seen_ahead_m = ahead->ahead_left_m.x();
    }
    if (result.place) {
      const guide::Pose pose = result.place->on_floor();
      for (const Eigen::Vector2d& one : seen) result.obstacles.push_back(pose.place_of(one));
    }
  }
  if (result.decision && result.decision->verdict != rooms::Verdict::kRoom) {
    result.more_to_see = pipeline::side_with_more_to_see(color);
  }
  result.picture = std::move(frame.color);
  return result;
}

}  // namespace roomwise::live
