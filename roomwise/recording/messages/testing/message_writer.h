#pragma once

#include "roomwise/recording/messages/messages.h"
#include "roomwise/recording/messages/testing/byte_writer.h"

// Messages as robots write them.
namespace roomwise::recording::testing {

// ROS 1, or CDR, little-endian.
class RosWriter {
 public:
  explicit RosWriter(Encoding encoding) : is_cdr_(encoding == Encoding::kCdr) {
    if (is_cdr_) out_.number<std::uint32_t>(0x00000100);
  }
  template <typename Number>
  RosWriter& number(std::type_identity_t<Number> value) {
    while (is_cdr_ && (out_.size() - 4) % sizeof(Number) != 0) out_.number<std::uint8_t>(0);
    out_.number<Number>(value);
    return *this;
  }
  RosWriter& text(const std::string& text) {
    number<std::uint32_t>(static_cast<std::uint32_t>(text.size() + (is_cdr_ ? 1 : 0)));
    out_.text(text);
    if (is_cdr_) out_.number<std::uint8_t>(0);
    return *this;
  }
  RosWriter& blob(std::span<const std::uint8_t> bytes) {
    number<std::uint32_t>(static_cast<std::uint32_t>(bytes.size()));
    out_.bytes(bytes);
    return *this;
  }
  RosWriter& header(const MessageHeader& header) {
    if (!is_cdr_) number<std::uint32_t>(7);
    number<std::uint32_t>(static_cast<std::uint32_t>(header.timestamp_ns / 1'000'000'000));
    number<std::uint32_t>(static_cast<std::uint32_t>(header.timestamp_ns % 1'000'000'000));
    return text(header.frame);
  }
  RosWriter& transform(const geometry::RigidTransform& transform) {
    for (int i = 0; i < 3; ++i) number<double>(transform.translation[i]);
    for (int i = 0; i < 4; ++i) number<double>(transform.rotation.coeffs()[i]);
    return *this;
  }
  [[nodiscard]] Bytes take() { return std::move(out_.all()); }

 private:
  ByteWriter out_;
  bool is_cdr_;
};

inline Bytes write_image(Encoding encoding, const ImageMessage& image) {
  RosWriter out(encoding);
  out.header(image.header).number<std::uint32_t>(image.height).number<std::uint32_t>(image.width);
  out.text(image.pixels).number<std::uint8_t>(image.is_big_endian ? 1 : 0);
  out.number<std::uint32_t>(image.step).blob(image.data);
  if (image.depth_unit_m) out.number<float>(static_cast<float>(*image.depth_unit_m));
  return out.take();
}

inline Bytes write_inertial(Encoding encoding, const InertialMessage& inertial) {
  RosWriter out(encoding);
  out.header(inertial.header);
  const auto numbers = [&](int count) {
    for (int i = 0; i < count; ++i) out.number<double>(0.5);
  };
  numbers(4 + 9);
  for (const double number : inertial.sample.turning_rad_s) out.number<double>(number);
  numbers(9);
  for (const double number : inertial.sample.force_m_s2) out.number<double>(number);
  numbers(9);
  return out.take();
}

inline Bytes write_compressed_image(Encoding encoding, const CompressedImageMessage& image) {
  return RosWriter(encoding).header(image.header).text(image.format).blob(image.data).take();
}

inline Bytes write_camera_info(Encoding encoding, const CameraInfoMessage& camera) {
  RosWriter out(encoding);
  out.header(camera.header).number<std::uint32_t>(camera.height);
  out.number<std::uint32_t>(camera.width).text(camera.distortion_model);
  out.number<std::uint32_t>(static_cast<std::uint32_t>(camera.distortion.size()));
  for (const double number : camera.distortion) out.number<double>(number);
  for (const double number : camera.k) out.number<double>(number);
  for (const double number : {1, 0, 0, 0, 1, 0, 0, 0, 1}) out.number<double>(number);
  for (const double number : camera.p) out.number<double>(number);
  for (int i = 0; i < 6; ++i) out.number<std::uint32_t>(0);  // binning and region of interest
  out.number<std::uint8_t>(0);
  return out.take();
}

inline Bytes write_transforms(Encoding encoding, const std::vector<TransformMessage>& transforms) {
  RosWriter out(encoding);
  out.number<std::uint32_t>(static_cast<std::uint32_t>(transforms.size()));
  for (const TransformMessage& one : transforms) {
    out.header(one.header).text(one.child).transform(one.parent_from_child);
  }
  return out.take();
}

inline Bytes write_odometry(Encoding encoding, const TransformMessage& pose) {
  RosWriter out(encoding);
  out.header(pose.header).text(pose.child).transform(pose.parent_from_child);
  for (int i = 0; i < 36 + 6 + 36; ++i) out.number<double>(0);  // covariance, speeds
  return out.take();
}

// Protobuf, field after field.
class ProtoWriter {
 public:
  ProtoWriter& varint(std::uint32_t field, std::uint64_t value) {
    put(field << 3U);
    put(value);
    return *this;
  }
  ProtoWriter& fixed32(std::uint32_t field, std::uint32_t value) {
    put(field << 3U | 5U);
    out_.number<std::uint32_t>(value);
    return *this;
  }
  ProtoWriter& number(std::uint32_t field, double value) {
    put(field << 3U | 1U);
    out_.number<double>(value);
    return *this;
  }
  ProtoWriter& blob(std::uint32_t field, std::span<const std::uint8_t> bytes) {
    put(field << 3U | 2U);
    put(bytes.size());
    out_.bytes(bytes);
    return *this;
  }
  ProtoWriter& text(std::uint32_t field, const std::string& text) {
    return blob(field, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  }
  ProtoWriter& numbers(std::uint32_t field, std::span<const double> values) {
    ByteWriter packed;
    for (const double value : values) packed.number<double>(value);
    return blob(field, packed.all());
  }
  ProtoWriter& time(std::uint32_t field, TimestampNs time) {
    ProtoWriter within;
    within.varint(1, static_cast<std::uint64_t>(time / 1'000'000'000));
    within.varint(2, static_cast<std::uint64_t>(time % 1'000'000'000));
    return blob(field, within.all());
  }
  [[nodiscard]] const Bytes& all() const { return out_.all(); }

 private:
  void put(std::uint64_t value) {
    for (; value >= 128; value >>= 7U) {
      out_.number<std::uint8_t>(static_cast<std::uint8_t>(value | 128U));
    }
    out_.number<std::uint8_t>(static_cast<std::uint8_t>(value));
  }
  ByteWriter out_;
};

}  // namespace roomwise::recording::testing
