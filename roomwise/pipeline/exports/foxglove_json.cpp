#include "roomwise/pipeline/exports/foxglove_json.h"

#include <array>
#include <cstring>

#include "roomwise/base/encodings.h"
#include "roomwise/base/file.h"
#include "roomwise/image/codec.h"

namespace roomwise::pipeline {
namespace {

using nlohmann::ordered_json;

constexpr std::int64_t kNsPerSecond = 1'000'000'000;

// ---- schemas: JSON Schemas made of a few words ----

ordered_json object(ordered_json properties) {
  return {{"type", "object"}, {"properties", std::move(properties)}};
}
ordered_json list_of(ordered_json items) {
  return {{"type", "array"}, {"items", std::move(items)}};
}
const ordered_json kNumber{{"type", "number"}}, kInteger{{"type", "integer"}},
    kString{{"type", "string"}}, kBoolean{{"type", "boolean"}},
    kBinary{{"type", "string"}, {"contentEncoding", "base64"}};

ordered_json time_schema() {
  return object({{"sec", kInteger}, {"nsec", kInteger}});
}
ordered_json vector_schema() {
  return object({{"x", kNumber}, {"y", kNumber}, {"z", kNumber}});
}
ordered_json rotation_schema() {
  return object({{"x", kNumber}, {"y", kNumber}, {"z", kNumber}, {"w", kNumber}});
}
ordered_json pose_schema() {
  return object({{"position", vector_schema()}, {"orientation", rotation_schema()}});
}
ordered_json color_schema() {
  return object({{"r", kNumber}, {"g", kNumber}, {"b", kNumber}, {"a", kNumber}});
}

FoxgloveSchema schema(const std::string& name, ordered_json properties) {
  ordered_json json = object(std::move(properties));
  json["title"] = "foxglove." + name;
  return {"foxglove." + name, json.dump()};
}

// ---- messages ----

ordered_json time_json(TimestampNs time_ns) {
  return {{"sec", time_ns / kNsPerSecond}, {"nsec", time_ns % kNsPerSecond}};
}
ordered_json xyz_json(const Eigen::Vector3d& v) {
  return {{"x", v.x()}, {"y", v.y()}, {"z", v.z()}};
}
ordered_json rotation_json(const Eigen::Quaterniond& q) {
  return {{"x", q.x()}, {"y", q.y()}, {"z", q.z()}, {"w", q.w()}};
}
ordered_json pose_json(const geometry::RigidTransform& pose) {
  return {{"position", xyz_json(pose.translation)}, {"orientation", rotation_json(pose.rotation)}};
}
ordered_json color_json(double r, double g, double b, double a) {
  return {{"r", r}, {"g", g}, {"b", b}, {"a", a}};
}

// A point as the message holds it.
constexpr std::size_t kFoxglovePointBytes = 3 * sizeof(float) + 4;

ordered_json field_json(const std::string& name, std::size_t offset, int type) {
  return {{"name", name}, {"offset", offset}, {"type", type}};
}

ordered_json empty_scene() {
  return {{"deletions", ordered_json::array()}, {"entities", ordered_json::array()}};
}

// What of an entity stays empty here; Foxglove's schema asks for it all the same.
constexpr std::array kNotShown{"metadata", "arrows", "spheres", "cylinders", "triangles", "models"};

// With none of what it shows.
ordered_json entity_json(TimestampNs time_ns, const std::string& frame, const std::string& id) {
  ordered_json entity{{"timestamp", time_json(time_ns)},
                      {"frame_id", frame},
                      {"id", id},
                      {"lifetime", time_json(0)},
                      {"frame_locked", true}};
  for (const char* const list : {"lines", "cubes", "texts"}) entity[list] = ordered_json::array();
  for (const char* const list : kNotShown) entity[list] = ordered_json::array();
  return entity;
}

ordered_json text_json(const std::string& text, const geometry::RigidTransform& place,
                       double font_size_m) {
  return {{"pose", pose_json(place)},        {"billboard", true},
          {"font_size", font_size_m},        {"scale_invariant", false},
          {"color", color_json(1, 1, 1, 1)}, {"text", text}};
}

}  // namespace

FoxgloveSchema foxglove_transform_schema() {
  return schema("FrameTransform", {{"timestamp", time_schema()},
                                   {"parent_frame_id", kString},
                                   {"child_frame_id", kString},
                                   {"translation", vector_schema()},
                                   {"rotation", rotation_schema()}});
}

FoxgloveSchema foxglove_image_schema() {
  return schema("CompressedImage", {{"timestamp", time_schema()},
                                    {"frame_id", kString},
                                    {"data", kBinary},
                                    {"format", kString}});
}

FoxgloveSchema foxglove_calibration_schema() {
  return schema("CameraCalibration", {{"timestamp", time_schema()},
                                      {"frame_id", kString},
                                      {"width", kInteger},
                                      {"height", kInteger},
                                      {"distortion_model", kString},
                                      {"D", list_of(kNumber)},
                                      {"K", list_of(kNumber)},
                                      {"R", list_of(kNumber)},
                                      {"P", list_of(kNumber)}});
}

FoxgloveSchema foxglove_cloud_schema() {
  return schema(
      "PointCloud",
      {{"timestamp", time_schema()},
       {"frame_id", kString},
       {"pose", pose_schema()},
       {"point_stride", kInteger},
       {"fields", list_of(object({{"name", kString}, {"offset", kInteger}, {"type", kInteger}}))},
       {"data", kBinary}});
}

FoxgloveSchema foxglove_scene_schema() {
  const ordered_json cube =
      object({{"pose", pose_schema()}, {"size", vector_schema()}, {"color", color_schema()}});
  const ordered_json text = object({{"pose", pose_schema()},
                                    {"billboard", kBoolean},
                                    {"font_size", kNumber},
                                    {"scale_invariant", kBoolean},
                                    {"color", color_schema()},
                                    {"text", kString}});
  const ordered_json line = object({{"type", kInteger},
                                    {"pose", pose_schema()},
                                    {"thickness", kNumber},
                                    {"scale_invariant", kBoolean},
                                    {"points", list_of(vector_schema())},
                                    {"color", color_schema()},
                                    {"colors", list_of(color_schema())},
                                    {"indices", list_of(kInteger)}});
  ordered_json members{
      {"timestamp", time_schema()}, {"frame_id", kString},      {"id", kString},
      {"lifetime", time_schema()},  {"frame_locked", kBoolean}, {"lines", list_of(line)},
      {"cubes", list_of(cube)},     {"texts", list_of(text)}};
  for (const char* const list : kNotShown) members[list] = list_of(object(ordered_json::object()));
  const ordered_json entity = object(std::move(members));
  return schema("SceneUpdate", {{"deletions", list_of(object(ordered_json::object()))},
                                {"entities", list_of(entity)}});
}

FoxgloveSchema foxglove_log_schema() {
  return schema("Log", {{"timestamp", time_schema()},
                        {"level", kInteger},
                        {"message", kString},
                        {"name", kString},
                        {"file", kString},
                        {"line", kInteger}});
}

ordered_json foxglove_transform(TimestampNs time_ns, const std::string& parent,
                                const std::string& child,
                                const geometry::RigidTransform& parent_from_child) {
  return {{"timestamp", time_json(time_ns)},
          {"parent_frame_id", parent},
          {"child_frame_id", child},
          {"translation", xyz_json(parent_from_child.translation)},
          {"rotation", rotation_json(parent_from_child.rotation)}};
}

ordered_json foxglove_image(TimestampNs time_ns, const std::string& frame,
                            std::span<const std::uint8_t> file) {
  return {{"timestamp", time_json(time_ns)},
          {"frame_id", frame},
          {"data", base64(file)},
          {"format", image::is_png(file) ? "png" : "jpeg"}};
}

ordered_json foxglove_calibration(TimestampNs time_ns, const std::string& frame,
                                  const geometry::PinholeCamera& camera) {
  const geometry::LensDistortion& lens = camera.distortion;
  return {{"timestamp", time_json(time_ns)},
          {"frame_id", frame},
          {"width", camera.width},
          {"height", camera.height},
          {"distortion_model", "plumb_bob"},
          {"D", {lens.k1, lens.k2, lens.p1, lens.p2, lens.k3}},
          {"K", {camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1}},
          {"R", {1, 0, 0, 0, 1, 0, 0, 0, 1}},
          {"P", {camera.fx, 0, camera.cx, 0, 0, camera.fy, camera.cy, 0, 0, 0, 1, 0}}};
}

ordered_json foxglove_cloud(TimestampNs time_ns, const std::string& frame,
                            const geometry::PointCloud& cloud) {
  constexpr int kUint8 = 1, kFloat32 = 7;
  Bytes data(cloud.size() * kFoxglovePointBytes);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    std::uint8_t* const point = data.data() + i * kFoxglovePointBytes;
    std::memcpy(point, cloud.points[i].data(), 3 * sizeof(float));
    point[12] = cloud.colors[i].r;
    point[13] = cloud.colors[i].g;
    point[14] = cloud.colors[i].b;
    point[15] = 255;
  }
  return {
      {"timestamp", time_json(time_ns)},
      {"frame_id", frame},
      {"pose", pose_json(geometry::RigidTransform::identity())},
      {"point_stride", kFoxglovePointBytes},
      {"fields",
       {field_json("x", 0, kFloat32), field_json("y", 4, kFloat32), field_json("z", 8, kFloat32),
        field_json("red", 12, kUint8), field_json("green", 13, kUint8),
        field_json("blue", 14, kUint8), field_json("alpha", 15, kUint8)}},
      {"data", base64(data)}};
}

ordered_json foxglove_scene(TimestampNs time_ns, const std::string& frame,
                            std::span<const NamedBox> boxes) {
  constexpr double kFontSize_m = 0.12;
  ordered_json scene = empty_scene();
  for (const NamedBox& one : boxes) {
    geometry::RigidTransform above = one.box.world_from_box;
    above.translation.z() += one.box.size_m.z() / 2 + kFontSize_m;
    const ordered_json cube{{"pose", pose_json(one.box.world_from_box)},
                            {"size", xyz_json(one.box.size_m)},
                            {"color", color_json(0.2, 0.6, 1, 0.35)}};
    ordered_json entity = entity_json(time_ns, frame, one.id);
    entity["cubes"] = ordered_json::array({cube});
    entity["texts"] = ordered_json::array({text_json(one.name, above, kFontSize_m)});
    scene["entities"].push_back(std::move(entity));
  }
  return scene;
}

ordered_json foxglove_outlines(TimestampNs time_ns, const std::string& frame,
                               std::span<const NamedOutline> outlines) {
  constexpr double kFontSize_m = 0.25, kThickness_m = 0.03;
  constexpr int kLineLoop = 1;
  ordered_json scene = empty_scene();
  for (const NamedOutline& one : outlines) {
    ordered_json entity = entity_json(time_ns, frame, one.id);
    for (const auto& ring : one.rings) {
      ordered_json points = ordered_json::array();
      for (const Eigen::Vector3d& corner : ring) points.push_back(xyz_json(corner));
      entity["lines"].push_back({{"type", kLineLoop},
                                 {"pose", pose_json(geometry::RigidTransform::identity())},
                                 {"thickness", kThickness_m},
                                 {"scale_invariant", false},
                                 {"points", std::move(points)},
                                 {"color", color_json(1, 0.8, 0.2, 1)},
                                 {"colors", ordered_json::array()},
                                 {"indices", ordered_json::array()}});
    }
    geometry::RigidTransform place = geometry::RigidTransform::identity();
    place.translation = one.name_at;
    entity["texts"] = ordered_json::array({text_json(one.name, place, kFontSize_m)});
    scene["entities"].push_back(std::move(entity));
  }
  return scene;
}

ordered_json foxglove_log(TimestampNs time_ns, const std::string& name,
                          const std::string& message) {
  constexpr int kInfo = 2;
  return {{"timestamp", time_json(time_ns)},
          {"level", kInfo},
          {"message", message},
          {"name", name},
          {"file", ""},
          {"line", 0}};
}

}  // namespace roomwise::pipeline
