#include "roomwise/pipeline/report/home_report.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <ranges>

#include "roomwise/evaluation/drawing/framed_picture.h"
#include "roomwise/image/codec.h"
#include "roomwise/mapping/frontend/loop_closer.h"
#include "roomwise/pipeline/mapping/map_cloud.h"
#include "roomwise/pipeline/objects/home_things.h"
#include "roomwise/pipeline/rooms/home_layout.h"
#include "roomwise/pipeline/rooms/room_outline.h"
#include "roomwise/pipeline/stored/stored_edits.h"
#include "roomwise/pipeline/stored/stored_map.h"
#include "roomwise/pipeline/stored/stored_rooms.h"

namespace roomwise::pipeline {
namespace {

using evaluation::ReportContent;

constexpr double kVoxelSize_m = 0.02;
constexpr int kPictureWidth_px = 320;

// An object as the key-frame shows it that saw it best.
struct ShownObject {
  std::string name;
  double score = 0;
  int observations = 0;
  home::KeyframeId keyframe = 0;
  Eigen::Vector3d place_keyframe = Eigen::Vector3d::Zero();
  Eigen::AlignedBox2f picture_box = {};    // empty: not known
  std::optional<std::string> put_in = {};  // the room, by hand
};

// Where a detector looked at the home, what its regions were joined into; else what the paper's
// rules confirmed.
Expected<std::vector<ShownObject>> shown_objects(const home::Home& home) {
  std::vector<ShownObject> shown;
  ROOMWISE_TRY(const auto finders, home.region_finders());
  if (finders.empty()) {
    ROOMWISE_TRY(const auto confirmed, home.confirmed_objects());
    for (const objects::ConfirmedObject& object : confirmed) {
      // Without depth at the centre, the place from which it was seen stands in.
      shown.push_back({object.name,
                       object.score,
                       object.observations,
                       object.keyframe_id,
                       object.position_keyframe.value_or(Eigen::Vector3d::Zero()),
                       {}});
    }
    return shown;
  }
  ROOMWISE_TRY(const HomeThings things, find_home_things(home));
  for (const HomeThing& instance : things.things) {
    const network::PixelBox& box = instance.picture_box;
    ShownObject& one = shown.emplace_back(ShownObject{instance.name,
                                                      instance.probability,
                                                      instance.observations,
                                                      instance.keyframe_id,
                                                      instance.box_keyframe.center(),
                                                      {}});
    one.put_in = instance.room;
    if (instance.visit == 0 && instance.added_by_edit == 0) {
      one.picture_box = {Eigen::Vector2f(box.left, box.top),
                         Eigen::Vector2f(box.right, box.bottom)};
    }
  }
  return shown;
}

// Everything of the home that the report is made from, read once: without what walks showed that
// are taken away.
struct Stored {
  std::vector<home::StoredRecording> recordings;
  std::map<home::KeyframeId, home::Keyframe> keyframes;
  std::vector<mapping::PoseGraphEdge> edges;
  std::vector<ShownObject> objects;
  std::vector<rooms::Room> rooms;
  KeyframeRooms named_rooms;  // of key-frames: as a person named them
  std::map<home::KeyframeId, std::vector<rooms::RoomScore>> believed_rooms;  // as the classifier
  std::optional<home::RoomClassifierRecord> classifier;
  std::uint64_t frames = 0;
  std::uint64_t placed = 0;
};

Expected<Stored> read(const home::Home& home) {
  Stored stored;
  ROOMWISE_TRY(stored.recordings, walks_that_stay(home));
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  for (const home::Keyframe& keyframe : keyframes) stored.keyframes[keyframe.id] = keyframe;
  ROOMWISE_TRY(stored.edges, home.edges());
  ROOMWISE_TRY(stored.objects, shown_objects(home));
  ROOMWISE_TRY(stored.rooms, home.rooms());
  ROOMWISE_TRY(stored.named_rooms, rooms_of_keyframes(home));
  ROOMWISE_TRY(stored.believed_rooms, home.keyframe_rooms());
  ROOMWISE_TRY(stored.classifier, home.room_classifier());
  for (const home::StoredRecording& recording : stored.recordings) {
    ROOMWISE_TRY(const auto frames, home.frames(recording.id));
    stored.frames += frames.size();
    stored.placed +=
        static_cast<std::uint64_t>(std::ranges::count_if(frames, [&](const home::Frame& frame) {
          return frame.place && stored.keyframes.at(frame.place->keyframe).pose.component == 0;
        }));
  }
  std::erase_if(stored.keyframes, [&](const auto& one) {
    return std::ranges::find(stored.recordings, one.second.recording, &home::StoredRecording::id) ==
           stored.recordings.end();
  });
  const auto is_gone = [&](home::KeyframeId id) { return !stored.keyframes.contains(id); };
  std::erase_if(stored.edges, [&](const mapping::PoseGraphEdge& edge) {
    return is_gone(edge.from) || is_gone(edge.to);
  });
  std::erase_if(stored.objects, [&](const ShownObject& one) { return is_gone(one.keyframe); });
  std::erase_if(stored.named_rooms, [&](const auto& one) { return is_gone(one.first); });
  return stored;
}

// The room of a key-frame: as a person named it, else as the classifier believes.
std::string room_of(const Stored& stored, home::KeyframeId keyframe) {
  const auto named = stored.named_rooms.find(keyframe);
  if (named != stored.named_rooms.end()) return named->second;
  const auto believed = stored.believed_rooms.find(keyframe);
  return believed == stored.believed_rooms.end() ? "" : believed->second.front().room;
}

double path_length_m(std::span<const recording::StampedPose> trajectory) {
  double length_m = 0;
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    length_m += (trajectory[i].world_from_camera.translation -
                 trajectory[i - 1].world_from_camera.translation)
                    .norm();
  }
  return length_m;
}

std::vector<evaluation::NamedFigure> summary(const Stored& stored, double path_m) {
  const auto loops = std::ranges::count_if(stored.edges, mapping::spans_long_loop);
  std::vector<evaluation::NamedFigure> figures;
  for (const home::StoredRecording& recording : stored.recordings) {
    figures.push_back({"Recording", recording.recording.name});
  }
  figures.push_back({"Frames", fmt::format("{}", stored.frames)});
  figures.push_back({"Frames with a place on the map", fmt::format("{}", stored.placed)});
  figures.push_back({"Key-frames", fmt::format("{}", stored.keyframes.size())});
  figures.push_back({"Edges of the pose graph", fmt::format("{}", stored.edges.size())});
  figures.push_back({"Returns to a place", fmt::format("{}", loops)});
  figures.push_back({"Length of the walk", fmt::format("{:.1f} m", path_m)});
  figures.push_back({"Objects", fmt::format("{}", stored.objects.size())});
  figures.push_back({"Rooms", fmt::format("{}", stored.rooms.size())});
  return figures;
}

// On whose floor it stands, or where somebody put it; empty where neither is known.
std::string room_of(const ShownObject& object, const home::Keyframe& keyframe,
                    const std::optional<HomeLayout>& layout) {
  std::optional<std::string> room;
  if (layout) {
    const Eigen::Vector3d middle =
        layout->frame.on_plan(keyframe.pose.world_from_keyframe * object.place_keyframe);
    room = room_of_thing(middle, keyframe.id, &layout->layout, {}, object.put_in);
  }
  return room.value_or(object.put_in.value_or(""));
}

Expected<std::vector<ReportContent::Object>> report_objects(
    const home::Home& home, const Stored& stored, const std::optional<HomeLayout>& layout) {
  std::vector<ReportContent::Object> objects;
  for (const ShownObject& object : stored.objects) {
    const home::Keyframe& keyframe = stored.keyframes.at(object.keyframe);
    if (keyframe.pose.component != 0) continue;  // nobody knows where on this map it is
    ROOMWISE_TRY(const home::KeyframeImages images, home.images(keyframe.id));
    ROOMWISE_TRY(const image::ColorImage picture, image::decode_color(images.color));
    objects.push_back({{object.name, keyframe.pose.world_from_keyframe * object.place_keyframe},
                       object.score,
                       static_cast<std::uint64_t>(object.observations),
                       room_of(object, keyframe, layout),
                       room_of(stored, keyframe.id),
                       evaluation::framed_picture(picture, object.picture_box, kPictureWidth_px)});
  }
  return objects;
}

Expected<std::vector<ReportContent::Room>> report_rooms(const Stored& stored) {
  nlohmann::json learned;
  if (stored.classifier)
    learned = nlohmann::json::parse(stored.classifier->report_json, nullptr, false);
  std::vector<ReportContent::Room> rooms;
  for (const rooms::Room& room : stored.rooms) {
    ReportContent::Room& entry = rooms.emplace_back();
    entry.name = room.name;
    entry.type = room.type;
    entry.key_frames = static_cast<std::uint64_t>(
        std::ranges::count(stored.named_rooms | std::views::values, room.name));
    if (!learned.is_object()) continue;
    for (const auto& one : learned.value("rooms", nlohmann::json::array())) {
      if (one.value("room", "") != room.name) continue;
      entry.recognition =
          fmt::format("learned from {} pictures; {} of them named rightly while held out",
                      one.value("pictures", 0), one.value("held_out_correct", 0));
    }
  }
  return rooms;
}

std::vector<std::string> warnings(const Stored& stored, const mapping::UpDirection& up) {
  std::vector<std::string> warnings;
  for (const home::StoredRecording& recording : stored.recordings) {
    if (!recording.finished) {
      warnings.push_back(fmt::format(
          "The recording {} was not mapped to its end; go on with roomwise map --resume.",
          recording.recording.name));
    }
  }
  const auto apart = std::ranges::count_if(stored.keyframes | std::views::values,
                                           [](const auto& k) { return k.pose.component != 0; });
  if (apart > 0) {
    warnings.push_back(
        fmt::format("{} key-frames could not be joined to the map and are not shown on it. Walk "
                    "through there again, slowly, "
                    "beginning in a place that is on the map.",
                    apart));
  }
  if (!stored.keyframes.empty() && up.support == 0) {
    warnings.emplace_back(
        "No floor or other level surface was found: the map is drawn along the camera's own up "
        "direction.");
  }
  return warnings;
}

// Turned as the plan of the rooms, where there is one.
evaluation::TopViewOptions top_view_options(const std::optional<HomeLayout>& layout) {
  evaluation::TopViewOptions options;
  if (!layout || layout->frame.storeys.are_several()) return options;
  const double right_rad = drawing_direction_rad(layout->grid, layout->frame.storeys);
  options.right_world = layout->frame.gravity_from_world.rotation.inverse() *
                        Eigen::Vector3d(std::cos(right_rad), std::sin(right_rad), 0);
  return options;
}

}  // namespace

Expected<ReportContent> report_content(const home::Home& home, const ReportExtras& extras,
                                       RunContext& run) {
  ROOMWISE_TRY(const Stored stored, read(home));
  ROOMWISE_TRY(const MapCloud map, build_map_cloud(home, kVoxelSize_m, run));
  ROOMWISE_TRY(const std::optional<HomeLayout> layout, find_home_layout(home, run));

  ReportContent content;
  content.home = extras.name;
  content.warnings = warnings(stored, map.up);
  recording::Trajectory trajectory;
  double length_m = 0;
  for (const home::StoredRecording& recording : stored.recordings) {
    ROOMWISE_TRY(const recording::Trajectory of_walk, stored_trajectory(home, recording.id));
    length_m += path_length_m(of_walk);
    trajectory.insert(trajectory.end(), of_walk.begin(), of_walk.end());
  }
  content.summary = summary(stored, length_m);
  content.recognition = extras.recognition;
  std::vector<Eigen::Vector3d> cameras;
  std::optional<home::RecordingId> walk;
  for (const home::Keyframe& keyframe : stored.keyframes | std::views::values) {
    if (keyframe.pose.component != 0) continue;
    cameras.push_back(keyframe.pose.world_from_keyframe.translation);
    content.key_frames.push_back(
        {cameras.back(), room_of(stored, keyframe.id), walk != keyframe.recording});
    walk = keyframe.recording;
  }
  if (map.cloud.size() > 0 && !cameras.empty()) {
    ROOMWISE_TRY(content.map, evaluation::render_top_view(map.cloud, cameras, map.up.up_world,
                                                          top_view_options(layout)));
  }
  ROOMWISE_TRY(content.objects, report_objects(home, stored, layout));
  ROOMWISE_TRY(content.rooms, report_rooms(stored));
  if (extras.truth) {
    ROOMWISE_TRY(content.trajectory_error,
                 evaluation::absolute_trajectory_error(*extras.truth, trajectory));
    content.truth_up = content.trajectory_error->truth_from_estimate.rotation * map.up.up_world;
  }
  ROOMWISE_TRY(const auto stages, home.stage_timings());
  for (const auto& [name, stage] : stages)
    content.stages.push_back({name, stage.calls, stage.wall_s, stage.cpu_s});
  return content;
}

}  // namespace roomwise::pipeline
