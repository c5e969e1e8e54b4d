#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <functional>
#include <numbers>

#include "roomwise/base/testing/testing.h"
#include "roomwise/home/home.h"

// A small home with something in every table, for the tests of home/.
namespace roomwise::home::testing {

inline geometry::PinholeCamera sample_camera() {
  return {.fx = 517.3,
          .fy = 516.5,
          .cx = 318.6,
          .cy = 255.3,
          .width = 640,
          .height = 480,
          .distortion = {0.2624, -0.9531, -0.0054, 0.0026, 1.1633},
          .depth_units_per_metre = 5000};
}

inline Recording sample_recording() {
  return {
      .name = "walk", .folder = "../recordings/walk", .camera = sample_camera(), .frame_count = 40};
}

// A pose whose numbers have no short decimal form.
inline geometry::RigidTransform sample_pose(double seed) {
  geometry::Vector6d twist;
  twist << 0.1, 0.2, 0.3, 1.0, -2.0, 0.7;
  return geometry::RigidTransform::exp(twist * (seed + 1) / std::numbers::pi);
}

inline Network sample_network() {
  return {.name = "net",
          .fingerprint = "c0ffee",
          .labels = {"studio couch", "\"lamp\", née"},
          .feature_size = 3};
}

inline network::Prediction sample_prediction(KeyframeId id) {
  const auto x = static_cast<float>(id);
  return {.features = {x / 3, -x, 1e-30F}, .scores = {0.25F, 0.75F}};
}

inline KeyframeImages sample_images(KeyframeId id) {
  return {.color = Bytes(3000 + id, static_cast<std::uint8_t>(id)),
          .depth = Bytes(9000 + id, static_cast<std::uint8_t>(~id))};
}

inline scene::PoseGraphEdge sample_edge(KeyframeId from, KeyframeId to, bool is_robust) {
  scene::PoseGraphEdge edge{.from = from, .to = to, .from_from_to = sample_pose(0.3)};
  edge.information.setConstant(-0.0);
  edge.information.diagonal() << 1, 1.0 / 3, 1e300, 1e-300, 0.1, 7;
  edge.information(0, 5) = edge.information(5, 0) = 2.0 / 3;
  edge.is_robust = is_robust;
  return edge;
}

// Key-frame `id` at frame 3 * id, the two frames before it (the second of which has no pose), its
// edge from the key-frame before.
inline MapCommit sample_commit(RecordingId recording, NetworkId network, KeyframeId id) {
  const std::uint64_t index = 3 * id;
  MapCommit step{.recording = recording,
                 .keyframes = {},
                 .edges = {},
                 .frames = {},
                 .next_frame_index = index + 1};
  NewKeyframe& keyframe = step.keyframes.emplace_back();
  keyframe.id = id;
  keyframe.frame_index = index;
  keyframe.timestamp_ns = 1'305'031'229'000'000'000 + static_cast<int>(index);
  keyframe.pose = {sample_pose(static_cast<double>(id)), id % 2};
  keyframe.images = sample_images(id);
  keyframe.predictions = {{network, sample_prediction(id)}};
  keyframe.observations = {{"lamp", 0.9}, {"bed", 0.5}};
  keyframe.depth_views = {{keyframe.timestamp_ns + 100, sample_pose(0.1), sample_images(id).depth}};
  if (id > 0) {
    step.edges.push_back(sample_edge(id - 1, id, false));
    const scene::FrameMotion motion{{sample_pose(0.7), Eigen::Vector3d(0, -0.6, 0.8)},
                                    scene::MotionUse::kAlone};
    step.frames.push_back({index - 2, 5, FramePlace{id - 1, sample_pose(0.01)}, "", motion});
    step.frames.push_back({index - 1, 6, std::nullopt, "too few matches"});
  }
  step.frames.push_back({index, 7, FramePlace{id, geometry::RigidTransform::identity()}, ""});
  return step;
}

inline objects::KeyframeDetections sample_look(KeyframeId id) {
  objects::KeyframeDetections look;
  look.coarse_depth = image::DepthImage(3, 2, static_cast<std::uint16_t>(1000 + id));
  look.coarse_depth.at(2, 1) = 0;
  objects::Detection region{
      .label = "couch", .score = 0.625F, .box = {1.5F, 2, 30.25F, 40}, .surface = {}};
  region.surface.points = {{0.1F, -0.2F, 1.5F}, {1.0F / 3, 0, 2}};
  region.surface.share = 0.75F;
  region.surface.measured = 0.5F;
  look.detections = {region, {"bed", 0.3F, {0, 0, 5, 5}, {}}};
  return look;
}

inline objects::Instance sample_instance(KeyframeId id) {
  objects::Instance instance;
  instance.name = "sofa";
  instance.probability = 0.875;
  instance.names = {{"sofa", 0.8}, {"bed", 0.2}};
  instance.observations = 5;
  instance.expected = 7;
  instance.keyframe_id = id;
  instance.picture_box = {1.5F, 2, 30.25F, 40};
  instance.box_keyframe = {sample_pose(0.2), {2, 0.9, 1.0 / 3}};
  instance.sigma_m = {0.05, 0.1, 1.0 / 7};
  return instance;
}

inline VisitPicture sample_visit_picture(KeyframeId keyframe) {
  return {.keyframe = keyframe,
          .timestamp_ns = 1'305'031'229'000'000'000,
          .picture_digest = fmt::format("d1ge5t{}", keyframe),
          .room = "kitchen",
          .network_fingerprint = "c0ffee",
          .features = {0.25F, 1.0F / 3, static_cast<float>(keyframe)}};
}

inline HomeChanges sample_changes() {
  HomeChanges changes;
  changes.visit = {"later walk", "../recordings/later", 1'000'000'007, 9'000'000'011, 120, 111};
  changes.kept = {sample_instance(1)};
  changes.arrived = {sample_instance(2)};
  changes.arrived[0].picture_box = {};
  changes.arrived[0].surface_keyframe = {{0.1F, -0.2F, 1.5F}, {1.0F / 3, 0, 2}};
  changes.past.push_back({.instance = sample_instance(0),
                          .reason = PastReason::kMoved,
                          .first_seen_ns = 1'305'031'229'000'000'000,
                          .last_seen_ns = 1'305'031'229'000'000'009});
  changes.pictures = std::vector{sample_visit_picture(1), sample_visit_picture(2)};
  return changes;
}

inline Edit sample_edit(std::optional<KeyframeId> keyframe) {
  const EditPlace point{"", keyframe, {}, {sample_pose(0.3), {0, 0, 0}}};
  return {
      .made_s = 1'753'000'000,
      .made_by = "Anna's phone",
      .what = "rename thing",
      .change = R"({"name":"divan"})",
      .before = "{}",
      .places = {{"sofa", keyframe, {1.5F, 2, 30.25F, 40}, {sample_pose(0.2), {2, 0.9, 1.0 / 3}}},
                 point,
                 point}};
}

inline OwnThing sample_own_thing() {
  return {.name = "my blue mug",
          .owner = "Anna's phone",
          .is_shared = false,
          .taught_s = 1'753'000'000,
          .last_seen = {1'753'000'100, "kitchen", 2, Eigen::Vector3d(0.1, -0.2, 1.5)}};
}

#define ROOMWISE_MUST(expression)                                                  \
  do {                                                                             \
    const auto done_ = (expression);                                               \
    if (!done_) throw std::runtime_error("sample home: " + done_.error().message); \
  } while (false)

// Two visits: the second took what the first had brought.
inline Expected<void> add_visits(Home& home) {
  ROOMWISE_RETURN_IF_ERROR(home.apply_changes(sample_changes()));
  HomeChanges second = sample_changes();
  ROOMWISE_TRY(second.kept, home.instances());
  second.arrived.clear();
  ROOMWISE_TRY(second.pictures, home.visit_pictures());
  second.pictures->erase(second.pictures->begin());
  second.pictures->push_back(sample_visit_picture(3));
  second.past[0].instance.visit = 1;
  second.past[0].reason = PastReason::kRemoved;
  return home.apply_changes(second).map([](auto) {});
}

inline Expected<void> teach(Home& home, const OwnThing& thing) {
  ROOMWISE_TRY(
      const OwnThingId id,
      home.add_own_thing(thing, std::vector<objects::TaughtView>{{{0xFF, 0xD8, 1}, {2, 3}}}));
  return home.put_own_thing_sighting(id, thing.last_seen);
}

// Fills an empty home with something in every table.
inline void fill(Home& home) {
  ROOMWISE_MUST(home.put_setting("seed", "7"));
  ROOMWISE_MUST(home.add_recording(sample_recording()));
  ROOMWISE_MUST(home.put_readout(1, 0.02));
  ROOMWISE_MUST(home.put_derived_data({"floor", "c0ffee", {1, 2, 3}}));
  ROOMWISE_MUST(home.add_network(sample_network()));
  for (KeyframeId id = 0; id < 4; ++id) ROOMWISE_MUST(home.commit(sample_commit(1, 1, id)));
  ROOMWISE_MUST(home.replace_confirmed_objects(std::vector<objects::ConfirmedObject>{
      {"bed", 1, 0.5, 4, Eigen::Vector3d(0.1, -0.2, 2.5)}, {"lamp", 2, 0.9, 4, std::nullopt}}));
  ROOMWISE_MUST(home.add_region_finder({"finder", "f1nd", {"couch", "bed"}}));
  ROOMWISE_MUST(home.put_detections(1, 1, sample_look(1)));
  objects::KeyframeDetections one = sample_look(2);
  one.detections.resize(1);
  ROOMWISE_MUST(home.put_detections(2, 1, one));
  ROOMWISE_MUST(add_visits(home));
  ROOMWISE_MUST(home.add_edit(sample_edit(2)));
  ROOMWISE_MUST(teach(home, sample_own_thing()));
  ROOMWISE_MUST(home.replace_concepts(rooms::Concepts::standard()));
  ROOMWISE_MUST(home.replace_rooms(
      std::vector<rooms::Room>{{"Anna's room", "bedroom"}, {"kitchen", "kitchen"}}));
  ROOMWISE_MUST(home.replace_room_ranges(1, {{0, 4, "kitchen", 1}, {5, 9, "Anna's room", 1}}));
  ROOMWISE_MUST(home.put_room_classifier({"net", "c0ffee", {1, 2, 0, 3}, R"({"held_out":0.9})"}));
  ROOMWISE_MUST(home.replace_keyframe_rooms({{0, {{"kitchen", 0.8}, {"Anna's room", 0.2}}}}));
  ROOMWISE_MUST(home.replace_picture_features(
      "c0ffee", "1: 0.8",
      std::vector<PictureFeatures>{{"abc", 0, 0, {0.25F, -3}},
                                   {"def", 2, std::nullopt, {0.5F, 1}}}));
  ROOMWISE_MUST(home.add_stage_timings({{"features", {4, 0.5, 0.4}}}));
}

// Runs work() in a process of its own; how that ended, as waitpid() says it.
inline int run_in_child(const std::function<int()>& work) {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(work());
  int status = 0;
  ::waitpid(child, &status, 0);
  return status;
}

}  // namespace roomwise::home::testing
