#include "roomwise/recording/messages/foxglove_messages.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "roomwise/base/protobuf_reader.h"

namespace roomwise::recording::foxglove {
namespace {

using Json = nlohmann::json;

// JSON needs many times its size when it is read; a picture as JSON is some MB.
constexpr std::size_t kMaxJsonBytes = std::size_t{1} << 26;
// So that any two times have a difference.
constexpr std::int64_t kMaxSeconds = 4'000'000'000;
constexpr std::size_t kMaxCoefficients = 64;

Unexpected broken() {
  return fail("the message is damaged or cut off");
}

std::string plain_frame(std::string_view frame) {
  return std::string(frame.starts_with('/') ? frame.substr(1) : frame);
}

TimestampNs time_from(std::int64_t seconds, std::int64_t nanoseconds) {
  return std::clamp(seconds, -kMaxSeconds, kMaxSeconds) * 1'000'000'000 +
         std::clamp(nanoseconds, std::int64_t{0}, std::int64_t{999'999'999});
}

// --- protobuf -------------------------------------------------------------------------------

TimestampNs proto_time(MessageBytes message) {
  ProtobufReader reader(message);
  std::int64_t seconds = 0, nanoseconds = 0;
  while (const auto field = reader.next()) {
    if (field->number == 1) seconds = static_cast<std::int64_t>(field->value);
    if (field->number == 2) nanoseconds = static_cast<std::int64_t>(field->value);
  }
  return time_from(seconds, nanoseconds);
}

// Doubles come packed into one field or each in its own.
void append_doubles(const ProtobufReader::Field& field, std::vector<double>& numbers) {
  if (!field.holds_bytes) {
    numbers.push_back(field.as_double());
    return;
  }
  ByteReader reader(field.bytes);
  while (reader.remaining() >= sizeof(double)) numbers.push_back(reader.number<double>());
}

// The first `kCount` fields of a message of doubles: x, y, z, w.
template <std::size_t kCount>
std::array<double, kCount> proto_numbers(MessageBytes message) {
  std::array<double, kCount> numbers{};
  ProtobufReader reader(message);
  while (const auto field = reader.next()) {
    if (field->number >= 1 && field->number <= kCount) {
      numbers[field->number - 1] = field->as_double();
    }
  }
  return numbers;
}

template <std::size_t kCount>
bool copy_exactly(const std::vector<double>& from, std::array<double, kCount>& to) {
  if (from.size() != kCount) return from.empty();
  std::ranges::copy(from, to.begin());
  return true;
}

Expected<ImageMessage> proto_image(MessageBytes message) {
  ProtobufReader reader(message);
  ImageMessage image;
  while (const auto field = reader.next()) {
    if (field->number == 1) image.header.timestamp_ns = proto_time(field->bytes);
    if (field->number == 2) image.width = field->as_count();
    if (field->number == 3) image.height = field->as_count();
    if (field->number == 4) image.pixels = field->text();
    if (field->number == 5) image.step = field->as_count();
    if (field->number == 6) image.data.assign(field->bytes.begin(), field->bytes.end());
    if (field->number == 7) image.header.frame = plain_frame(field->text());
  }
  if (!reader.ok()) return broken();
  return image;
}

Expected<CompressedImageMessage> proto_compressed_image(MessageBytes message) {
  ProtobufReader reader(message);
  CompressedImageMessage image;
  while (const auto field = reader.next()) {
    if (field->number == 1) image.header.timestamp_ns = proto_time(field->bytes);
    if (field->number == 2) image.data.assign(field->bytes.begin(), field->bytes.end());
    if (field->number == 3) image.format = field->text();
    if (field->number == 4) image.header.frame = plain_frame(field->text());
  }
  if (!reader.ok()) return broken();
  return image;
}

Expected<CameraInfoMessage> proto_camera_info(MessageBytes message) {
  ProtobufReader reader(message);
  CameraInfoMessage camera;
  std::vector<double> k, p;
  while (const auto field = reader.next()) {
    if (field->number == 1) camera.header.timestamp_ns = proto_time(field->bytes);
    if (field->number == 2) camera.width = field->as_count();
    if (field->number == 3) camera.height = field->as_count();
    if (field->number == 4) camera.distortion_model = field->text();
    if (field->number == 5) append_doubles(*field, camera.distortion);
    if (field->number == 6) append_doubles(*field, k);
    if (field->number == 8) append_doubles(*field, p);
    if (field->number == 9) camera.header.frame = plain_frame(field->text());
  }
  if (!reader.ok() || !copy_exactly(k, camera.k) || !copy_exactly(p, camera.p)) return broken();
  return camera;
}

Expected<TransformMessage> proto_transform(MessageBytes message) {
  ProtobufReader reader(message);
  TransformMessage transform;
  std::array<double, 4> rotation{0, 0, 0, 1};
  std::array<double, 3> translation{};
  while (const auto field = reader.next()) {
    if (field->number == 1) transform.header.timestamp_ns = proto_time(field->bytes);
    if (field->number == 2) transform.header.frame = plain_frame(field->text());
    if (field->number == 3) transform.child = plain_frame(field->text());
    if (field->number == 4) translation = proto_numbers<3>(field->bytes);
    if (field->number == 5) rotation = proto_numbers<4>(field->bytes);
  }
  if (!reader.ok()) return broken();
  transform.parent_from_child.translation = {translation[0], translation[1], translation[2]};
  transform.parent_from_child.rotation = {rotation[3], rotation[0], rotation[1], rotation[2]};
  return transform;
}

// --- JSON -----------------------------------------------------------------------------------

Expected<Json> parse(MessageBytes message) {
  if (message.size() > kMaxJsonBytes) return fail("{} bytes of JSON are too many", message.size());
  Json json = Json::parse(message.begin(), message.end(), nullptr, false);
  if (!json.is_object()) return broken();
  return json;
}

double number_in(const Json& json, const char* name, double otherwise = 0) {
  const auto found = json.find(name);
  return found != json.end() && found->is_number() ? found->get<double>() : otherwise;
}

std::uint32_t count_in(const Json& json, const char* name) {
  const double number = number_in(json, name);
  return number >= 0 && number <= 4e9 ? static_cast<std::uint32_t>(number) : 0;
}

std::string text_in(const Json& json, const char* name) {
  const auto found = json.find(name);
  return found != json.end() && found->is_string() ? found->get<std::string>() : std::string();
}

std::vector<double> numbers_in(const Json& json, const char* name) {
  std::vector<double> numbers;
  const auto found = json.find(name);
  if (found == json.end() || !found->is_array()) return numbers;
  for (const Json& number : *found) {
    if (number.is_number() && numbers.size() < kMaxCoefficients) {
      numbers.push_back(number.get<double>());
    }
  }
  return numbers;
}

const Json& object_in(const Json& json, const char* name) {
  static const Json kEmpty = Json::object();
  const auto found = json.find(name);
  return found != json.end() && found->is_object() ? *found : kEmpty;
}

std::int64_t whole(double number) {
  return std::isfinite(number) && std::abs(number) < 1e18 ? static_cast<std::int64_t>(number) : 0;
}

MessageHeader json_header(const Json& json, const char* frame_name = "frame_id") {
  const Json& time = object_in(json, "timestamp");
  const double nanoseconds = number_in(time, "nsec", number_in(time, "nanos"));
  const double seconds = number_in(time, "sec", number_in(time, "seconds"));
  return {time_from(whole(seconds), whole(nanoseconds)), plain_frame(text_in(json, frame_name))};
}

// RFC 4648, with or without the signs that fill it up.
std::optional<Bytes> decode_base64(std::string_view text) {
  while (text.ends_with('=')) text.remove_suffix(1);
  const auto value = [](char c) -> int {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    return c == '+' ? 62 : c == '/' ? 63 : -1;
  };
  Bytes bytes;
  bytes.reserve(text.size() * 3 / 4);
  std::uint32_t word = 0;
  unsigned bits = 0;
  for (const char c : text) {
    const int six = value(c);
    if (six < 0) return std::nullopt;
    word = (word << 6U | static_cast<std::uint32_t>(six)) & 0xFFFFFFU;
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes.push_back(static_cast<std::uint8_t>(word >> bits));
  }
  return bytes;
}

Expected<Bytes> data_in(const Json& json) {
  const auto found = json.find("data");
  if (found == json.end() || !found->is_string()) return broken();
  auto bytes = decode_base64(found->get_ref<const std::string&>());
  if (!bytes) return fail("its data is not base64");
  return *std::move(bytes);
}

Expected<ImageMessage> json_image(MessageBytes message) {
  ROOMWISE_TRY(const Json json, parse(message));
  ImageMessage image;
  image.header = json_header(json);
  image.width = count_in(json, "width");
  image.height = count_in(json, "height");
  image.pixels = text_in(json, "encoding");
  image.step = count_in(json, "step");
  ROOMWISE_TRY(image.data, data_in(json));
  return image;
}

Expected<CompressedImageMessage> json_compressed_image(MessageBytes message) {
  ROOMWISE_TRY(const Json json, parse(message));
  CompressedImageMessage image;
  image.header = json_header(json);
  image.format = text_in(json, "format");
  ROOMWISE_TRY(image.data, data_in(json));
  return image;
}

Expected<CameraInfoMessage> json_camera_info(MessageBytes message) {
  ROOMWISE_TRY(const Json json, parse(message));
  CameraInfoMessage camera;
  camera.header = json_header(json);
  camera.width = count_in(json, "width");
  camera.height = count_in(json, "height");
  camera.distortion_model = text_in(json, "distortion_model");
  camera.distortion = numbers_in(json, "D");
  if (!copy_exactly(numbers_in(json, "K"), camera.k) ||
      !copy_exactly(numbers_in(json, "P"), camera.p)) {
    return broken();
  }
  return camera;
}

TransformMessage json_transform(const Json& json) {
  TransformMessage transform;
  transform.header = json_header(json, "parent_frame_id");
  transform.child = plain_frame(text_in(json, "child_frame_id"));
  const Json& moved = object_in(json, "translation");
  const Json& turned = object_in(json, "rotation");
  transform.parent_from_child.translation = {number_in(moved, "x"), number_in(moved, "y"),
                                             number_in(moved, "z")};
  transform.parent_from_child.rotation = {number_in(turned, "w", 1), number_in(turned, "x"),
                                          number_in(turned, "y"), number_in(turned, "z")};
  return transform;
}

}  // namespace

Expected<ImageMessage> image(Encoding encoding, MessageBytes message) {
  return encoding == Encoding::kJson ? json_image(message) : proto_image(message);
}

Expected<CompressedImageMessage> compressed_image(Encoding encoding, MessageBytes message) {
  return encoding == Encoding::kJson ? json_compressed_image(message)
                                     : proto_compressed_image(message);
}

Expected<CameraInfoMessage> camera_info(Encoding encoding, MessageBytes message) {
  return encoding == Encoding::kJson ? json_camera_info(message) : proto_camera_info(message);
}

Expected<TransformMessage> transform(Encoding encoding, MessageBytes message) {
  if (encoding != Encoding::kJson) return proto_transform(message);
  ROOMWISE_TRY(const Json json, parse(message));
  return json_transform(json);
}

Expected<std::vector<TransformMessage>> transforms(Encoding encoding, MessageBytes message) {
  std::vector<TransformMessage> transforms;
  if (encoding == Encoding::kJson) {
    ROOMWISE_TRY(const Json json, parse(message));
    const auto list = json.find("transforms");
    if (list == json.end() || !list->is_array()) return broken();
    for (const Json& one : *list) {
      if (one.is_object()) transforms.push_back(json_transform(one));
    }
    return transforms;
  }
  ProtobufReader reader(message);
  while (const auto field = reader.next()) {
    if (field->number != 1) continue;
    ROOMWISE_TRY(TransformMessage one, proto_transform(field->bytes));
    transforms.push_back(std::move(one));
  }
  if (!reader.ok()) return broken();
  return transforms;
}

std::optional<TimestampNs> time(Encoding encoding, MessageBytes message) {
  if (encoding == Encoding::kJson) {
    const auto json = parse(message);
    if (!json || object_in(*json, "timestamp").empty()) return std::nullopt;
    return json_header(*json).timestamp_ns;
  }
  ProtobufReader reader(message);
  while (const auto field = reader.next()) {
    if (field->number == 1) return proto_time(field->bytes);
  }
  return std::nullopt;
}

}  // namespace roomwise::recording::foxglove
