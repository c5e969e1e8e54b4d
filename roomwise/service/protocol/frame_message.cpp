#include <Eigen/Eigenvalues>
#include <cstring>

#include "roomwise/base/in_context.h"
#include "roomwise/service/protocol/json_members.h"
#include "roomwise/service/protocol/messages.h"

namespace roomwise::service {
namespace {

constexpr std::string_view kFrameMagic = "RWF1";
constexpr std::size_t kPrefixBytes = 8;
constexpr std::size_t kMaxHeaderBytes = 2048;
constexpr std::int64_t kHeaderVersion = 2;
constexpr int kMaxImageSide_px = 4096;
constexpr double kMaxDistance_m = 1e5;
constexpr std::size_t kCovarianceValues = 21;  // of the upper triangle of 6 x 6
using Covariance = Eigen::Matrix<double, 6, 6>;

ImageSize read_size(Members& members) {
  return {static_cast<int>(members.integer("width", 1, kMaxImageSide_px)),
          static_cast<int>(members.integer("height", 1, kMaxImageSide_px))};
}

Expected<geometry::PinholeCamera> read_camera_of_frame(const OrderedJson& json) {
  Members members(json);
  const ImageSize size = read_size(members);
  geometry::PinholeCamera camera;
  camera.width = size.width;
  camera.height = size.height;
  camera.fx = members.number("fx", 1e-3, 1e6);
  camera.fy = members.number("fy", 1e-3, 1e6);
  camera.cx = members.number("cx", -1e6, 1e6);
  camera.cy = members.number("cy", -1e6, 1e6);
  if (!members.error()) ROOMWISE_RETURN_IF_ERROR(camera.validate());
  return members.finish(camera);
}

// A vector of length 1, but for rounding.
template <int N>
Eigen::Matrix<double, N, 1> read_unit(Members& members, const char* name) {
  const std::vector<double> values = members.numbers(name, N, -2, 2);
  if (members.error()) return {};
  const Eigen::Matrix<double, N, 1> vector =
      Eigen::Map<const Eigen::Matrix<double, N, 1>>(values.data());
  constexpr double kRounding = 0.01;
  if (std::abs(vector.norm() - 1) < kRounding) return vector.normalized();
  members.wrong(name, "of length 1");
  return {};
}

Covariance read_covariance(Members& members) {
  const std::vector<double> values = members.numbers("covariance", kCovarianceValues, -1e6, 1e6);
  Covariance covariance = Covariance::Zero();
  if (members.error()) return covariance;
  std::size_t next = 0;
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) {
      covariance(row, column) = covariance(column, row) = values[next++];
    }
  }
  const Eigen::SelfAdjointEigenSolver<Covariance> solver(covariance, Eigen::EigenvaluesOnly);
  if (solver.eigenvalues().minCoeff() < -1e-9 * (1 + covariance.trace())) {
    members.wrong("covariance", "a covariance: no direction may have a negative variance");
  }
  return covariance;
}

Expected<FramePose> read_pose(const OrderedJson& json) {
  Members members(json);
  FramePose pose;
  pose.source = members.text("source");
  const auto position = members.numbers("position", 3, -kMaxDistance_m, kMaxDistance_m);
  const Eigen::Vector4d xyzw = read_unit<4>(members, "rotation_xyzw");
  std::optional<Eigen::Vector3d> up;
  if (members.has("up")) up = read_unit<3>(members, "up");
  if (members.has("covariance")) pose.covariance = read_covariance(members);
  if (members.error()) return Unexpected(Error(*members.error()));
  geometry::RigidTransform& world_from_camera = pose.motion.world_from_camera;
  world_from_camera.rotation = Eigen::Quaterniond(xyzw[3], xyzw[0], xyzw[1], xyzw[2]);
  world_from_camera.translation = {position[0], position[1], position[2]};
  if (up) pose.motion.up_camera = world_from_camera.rotation.conjugate() * *up;
  return pose;
}

// What version 2 adds. Each may be missing.
Expected<void> read_additions(const OrderedJson& json, FrameMessage& frame) {
  Members members(json);
  const auto part = [&](const char* name) -> const OrderedJson* {
    return members.has(name) ? members.object(name) : nullptr;
  };
  if (const OrderedJson* const camera = part("camera")) {
    ROOMWISE_TRY(frame.camera, in_context("'camera'", read_camera_of_frame(*camera)));
  }
  if (const OrderedJson* const depth = part("depth")) {
    Members size(*depth);
    frame.depth_size = read_size(size);
    if (size.error()) return Unexpected(Error(*size.error()).with_context("'depth'"));
  }
  if (const OrderedJson* const pose = part("pose")) {
    ROOMWISE_TRY(frame.pose, in_context("'pose'", read_pose(*pose)));
  }
  if (members.error()) return Unexpected(Error(*members.error()));
  return {};
}

OrderedJson pose_json(const FramePose& pose) {
  const geometry::RigidTransform& world_from_camera = pose.motion.world_from_camera;
  const Eigen::Vector3d& at = world_from_camera.translation;
  const Eigen::Quaterniond& q = world_from_camera.rotation;
  OrderedJson json{{"source", pose.source},
                   {"position", {at.x(), at.y(), at.z()}},
                   {"rotation_xyzw", {q.x(), q.y(), q.z(), q.w()}}};
  if (pose.motion.up_camera) {
    const Eigen::Vector3d up = q * *pose.motion.up_camera;
    json["up"] = {up.x(), up.y(), up.z()};
  }
  if (pose.covariance) {
    OrderedJson values = OrderedJson::array();
    for (int row = 0; row < 6; ++row) {
      for (int column = row; column < 6; ++column) {
        values.push_back((*pose.covariance)(row, column));
      }
    }
    json["covariance"] = values;
  }
  return json;
}

OrderedJson header_json(const FrameMessage& frame) {
  OrderedJson json{
      {"t", frame.t_ms}, {"color_bytes", frame.color.size()}, {"depth_bytes", frame.depth.size()}};
  if (frame.camera || frame.depth_size || frame.pose) json["version"] = kHeaderVersion;
  if (const auto& camera = frame.camera) {
    json["camera"] = {{"width", camera->width}, {"height", camera->height}, {"fx", camera->fx},
                      {"fy", camera->fy},       {"cx", camera->cx},         {"cy", camera->cy}};
  }
  if (const auto& size = frame.depth_size) {
    json["depth"] = {{"width", size->width}, {"height", size->height}};
  }
  if (frame.pose) json["pose"] = pose_json(*frame.pose);
  return json;
}

}  // namespace

namespace {

// JSON, after what tells its length.
Expected<std::span<const std::uint8_t>> header_of(std::span<const std::uint8_t> message) {
  if (message.size() < kPrefixBytes ||
      std::memcmp(message.data(), kFrameMagic.data(), kFrameMagic.size()) != 0) {
    return fail("the binary message is no frame: it does not begin with {}", kFrameMagic);
  }
  std::size_t header_bytes = 0;
  for (std::size_t i = 0; i < 4; ++i) header_bytes |= std::size_t{message[4 + i]} << (8 * i);
  if (header_bytes > kMaxHeaderBytes || header_bytes > message.size() - kPrefixBytes) {
    return fail("the frame's header of {} bytes is too long", header_bytes);
  }
  return message.subspan(kPrefixBytes, header_bytes);
}

constexpr std::string_view kHeader = "the frame's header";

Expected<OrderedJson> read_header(std::span<const std::uint8_t> header) {
  return in_context(
      kHeader,
      parse_object({reinterpret_cast<const char*>(header.data()), header.size()}, kMaxHeaderBytes));
}

}  // namespace

std::optional<double> time_of_frame(std::span<const std::uint8_t> message) {
  const auto header = header_of(message);
  if (!header) return std::nullopt;
  const auto json = read_header(*header);
  if (!json) return std::nullopt;
  Members members(*json);
  const double t_ms = members.number("t", -kMaxTime_ms, kMaxTime_ms);
  return members.error() ? std::nullopt : std::optional(t_ms);
}

Expected<FrameMessage> read_frame(std::span<const std::uint8_t> message) {
  if (message.size() > kMaxFrameBytes) {
    return fail("the frame has {} bytes; at most {} are taken", message.size(), kMaxFrameBytes);
  }
  ROOMWISE_TRY(const auto header, header_of(message));
  ROOMWISE_TRY(const OrderedJson json, read_header(header));
  Members members(json);
  const auto images = message.subspan(kPrefixBytes + header.size());
  const auto most = static_cast<std::int64_t>(images.size());
  FrameMessage frame;
  frame.t_ms = members.number("t", -kMaxTime_ms, kMaxTime_ms);
  const auto color_bytes = static_cast<std::size_t>(members.integer("color_bytes", 1, most));
  const auto depth_bytes = static_cast<std::size_t>(members.integer("depth_bytes", 0, most));
  if (!members.error() && color_bytes + depth_bytes != images.size()) {
    members.wrong("depth_bytes",
                  fmt::format("with color_bytes the {} bytes that follow", images.size()));
  }
  const bool has_version = members.has("version");
  const auto version = has_version ? members.integer("version", 1, kHeaderVersion) : 1;
  if (members.error()) return Unexpected(Error(*members.error()).with_context(kHeader));
  if (version > 1) ROOMWISE_RETURN_IF_ERROR(in_context(kHeader, read_additions(json, frame)));
  frame.color = images.first(color_bytes);
  frame.depth = images.subspan(color_bytes);
  return frame;
}

Bytes write(const FrameMessage& frame) {
  const std::string header = dump(header_json(frame));
  Bytes message(kFrameMagic.begin(), kFrameMagic.end());
  message.reserve(kPrefixBytes + header.size() + frame.color.size() + frame.depth.size());
  for (std::size_t i = 0; i < 4; ++i) {
    message.push_back(static_cast<std::uint8_t>(header.size() >> (8 * i)));
  }
  message.insert(message.end(), header.begin(), header.end());
  message.insert(message.end(), frame.color.begin(), frame.color.end());
  message.insert(message.end(), frame.depth.begin(), frame.depth.end());
  return message;
}

}  // namespace roomwise::service
