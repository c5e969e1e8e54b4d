#include "roomwise/recording/robot/streams.h"

#include <algorithm>
#include <tuple>

#include "roomwise/image/codec.h"
#include "roomwise/recording/phone/one_camera.h"
#include "roomwise/recording/robot/camera_model.h"

namespace roomwise::recording {
namespace {

// Cameras this much closer together count as closer.
constexpr double kBaselineStep_m = 0.02;

std::vector<std::string_view> parts_of(std::string_view topic) {
  std::vector<std::string_view> parts;
  while (!topic.empty()) {
    const std::size_t end = std::min(topic.find('/'), topic.size());
    if (end > 0) parts.push_back(topic.substr(0, end));
    topic.remove_prefix(std::min(end + 1, topic.size()));
  }
  return parts;
}

std::string frame_of(const std::string& topic, const std::string& frame) {
  const std::string stream = realsense_stream_of(topic);
  return stream.empty() ? frame : stream;
}

struct InfoStream {
  std::string topic;
  std::string frame;
  CameraInfoMessage info;
};

std::vector<InfoStream> find_infos(const MessageLog& log, std::vector<std::string>& notes) {
  std::vector<InfoStream> infos;
  for (std::size_t i = 0; i < log.channels().size(); ++i) {
    const Channel& channel = log.channels()[i];
    if (channel.type != MessageType::kCameraInfo || log.messages(i).empty()) continue;
    const auto bytes = log.read(log.messages(i).front());
    auto info = bytes ? decode_camera_info(channel, *bytes) : Unexpected(bytes.error());
    if (!info) {
      notes.push_back(fmt::format("{} is left out: {}", channel.topic, info.error().message));
      continue;
    }
    infos.push_back({channel.topic, frame_of(channel.topic, info->header.frame), *std::move(info)});
  }
  return infos;
}

// The part of a topic's name under which the images of its camera lie: "/camera/color" of
// "/camera/color/camera_info", RealSense's ".../Color_0" of ".../Color_0/info/camera_info".
std::vector<std::string_view> namespace_of(const InfoStream& info) {
  auto parts = parts_of(info.topic);
  if (!parts.empty()) parts.pop_back();
  if (!parts.empty() && parts.back() == "info") parts.pop_back();
  return parts;
}

// How well an info belongs to a stream: the parts of the namespace that holds it, whether the frame
// is the same, the letters that their topics begin with alike. Nothing where it does not.
std::optional<std::tuple<std::size_t, bool, std::size_t>> fit_of(const InfoStream& one,
                                                                 const ImageStream& stream) {
  const bool has_size = one.info.width != 0 && one.info.height != 0;
  const bool is_of_size = !has_size || (static_cast<int>(one.info.width) == stream.width &&
                                        static_cast<int>(one.info.height) == stream.height);
  const auto above = namespace_of(one);
  const auto topic = parts_of(stream.topic);
  const bool holds = !above.empty() && std::ranges::mismatch(above, topic).in1 == above.end();
  const bool is_of_frame = !one.frame.empty() && one.frame == stream.frame;
  if (!is_of_size || (!holds && !is_of_frame)) return std::nullopt;
  const auto alike = std::ranges::mismatch(one.topic, stream.topic).in1 - one.topic.begin();
  return std::tuple(holds ? above.size() : 0, is_of_frame, static_cast<std::size_t>(alike));
}

const InfoStream* info_of(const ImageStream& stream, const std::vector<InfoStream>& infos) {
  const InfoStream* best = nullptr;
  for (const InfoStream& one : infos) {
    const auto fit = fit_of(one, stream);
    if (fit && (best == nullptr || *fit > *fit_of(*best, stream))) best = &one;
  }
  return best;
}

void give_camera(ImageStream& stream, const std::vector<InfoStream>& infos) {
  const InfoStream* found = info_of(stream, infos);
  if (found == nullptr) {
    stream.no_camera_reason =
        fmt::format("no camera info of {}x{} pixels belongs to it", stream.width, stream.height);
    return;
  }
  CameraInfoMessage info = found->info;
  info.width = static_cast<std::uint32_t>(stream.width);
  info.height = static_cast<std::uint32_t>(stream.height);
  const auto camera = camera_of(info, stream.topic.find("image_rect") != std::string::npos);
  if (camera) {
    stream.camera = *camera;
    stream.camera->depth_units_per_metre = 1 / stream.depth_unit_m;
  } else {
    stream.no_camera_reason = fmt::format("{}: {}", found->topic, camera.error().message);
  }
}

// mono16 is as well a grey picture; a depth image's topic says so.
bool is_called_depth(std::string topic) {
  std::ranges::transform(topic, topic.begin(), [](unsigned char c) { return std::tolower(c); });
  return topic.find("depth") != std::string::npos;
}

// A size counts only where a picture has it, whatever the message says.
template <typename Message>
Expected<void> take_size(const Message& image, ImageStream& stream) {
  const auto set_size = [&](const auto& picture) {
    stream.width = picture.width();
    stream.height = picture.height();
  };
  if (stream.kind == PixelKind::kDepth) {
    ROOMWISE_TRY(const auto depth, depth_of(image));
    set_size(depth);
  } else if (stream.kind != PixelKind::kOther) {
    ROOMWISE_TRY(const auto color, color_of(image));
    set_size(color);
  }
  return {};
}

Expected<void> look_at(const Channel& channel, const Bytes& bytes, ImageStream& stream) {
  if (stream.is_compressed) {
    ROOMWISE_TRY(const CompressedImageMessage image, decode_compressed_image(channel, bytes));
    stream.kind = pixel_kind(image);
    const bool is_packed_for_depth = image.format.find("compressedDepth") != std::string::npos;
    if (image.format.starts_with("mono16") && !is_packed_for_depth &&
        !is_called_depth(channel.topic)) {
      stream.kind = PixelKind::kOther;
    }
    stream.frame = image.header.frame;
    return take_size(image, stream);
  }
  ROOMWISE_TRY(const ImageMessage image, decode_image(channel, bytes));
  stream.kind = pixel_kind(image);
  if (image.pixels == "mono16" && !is_called_depth(channel.topic)) stream.kind = PixelKind::kOther;
  stream.frame = image.header.frame;
  if (image.depth_unit_m && *image.depth_unit_m > 0) stream.depth_unit_m = *image.depth_unit_m;
  return take_size(image, stream);
}

// As the first says that has the size of most of the first few that can be read.
Expected<void> look_at_some(const MessageLog& log, const Channel& channel, ImageStream& stream) {
  constexpr std::size_t kEnough = 5, kMaxUnreadable = 20;
  std::size_t unreadable = 0;
  std::vector<ImageStream> seen;
  std::vector<PictureSize> sizes;
  std::optional<Error> why;
  for (const MessagePlace& message : log.messages(stream.channel)) {
    if (seen.size() == kEnough || unreadable == kMaxUnreadable) break;
    ImageStream one = stream;
    const auto looked = log.read(message).and_then(
        [&](const Bytes& bytes) { return look_at(channel, bytes, one); });
    if (!looked && !why) why = looked.error();
    if (!looked) {
      ++unreadable;
      continue;
    }
    sizes.emplace_back(one.width, one.height);
    seen.push_back(std::move(one));
  }
  if (seen.empty()) return Unexpected(*std::move(why));
  stream = seen[first_of_most(sizes)];
  return {};
}

// What "Depth Units" of the stream's sensor says, where RealSense's recorder wrote it.
std::optional<double> realsense_unit_m(const MessageLog& log, const std::string& stream) {
  const std::string sensor = stream.substr(0, stream.rfind('/'));
  for (std::size_t i = 0; i < log.channels().size(); ++i) {
    const Channel& channel = log.channels()[i];
    const bool is_unit = channel.topic == sensor + "/option/Depth_Units/value" ||
                         channel.topic == sensor + "/option/Depth Units/value";
    if (!is_unit || channel.type != MessageType::kFloat || log.messages(i).empty()) continue;
    const auto bytes = log.read(log.messages(i).front());
    const auto unit = bytes ? decode_float(channel, *bytes) : Unexpected(bytes.error());
    if (unit && *unit > 0) return *unit;
  }
  return std::nullopt;
}

// A float of 0.001 is not quite a thousandth.
double rounded_unit(double unit_m) {
  const double per_metre = 1 / unit_m;
  const double whole = std::round(per_metre);
  return std::abs(per_metre - whole) < 1e-5 * per_metre ? 1 / whole : unit_m;
}

Expected<ImageStream> stream_of(const MessageLog& log, std::size_t number) {
  const Channel& channel = log.channels()[number];
  ImageStream stream;
  stream.channel = number;
  stream.topic = channel.topic;
  stream.is_compressed = channel.type == MessageType::kCompressedImage;
  stream.count = log.messages(number).size();
  stream.first_ns = log.messages(number).front().timestamp_ns;
  ROOMWISE_RETURN_IF_ERROR(look_at_some(log, channel, stream));
  if (const std::string realsense = realsense_stream_of(stream.topic); !realsense.empty()) {
    stream.frame = realsense;
    if (const auto unit = realsense_unit_m(log, realsense)) stream.depth_unit_m = *unit;
  }
  stream.depth_unit_m = rounded_unit(stream.depth_unit_m);
  return stream;
}

// Two calibrations of one camera differ in the last digits.
bool is_one_view(const geometry::PinholeCamera& a, const geometry::PinholeCamera& b) {
  constexpr double kSame_px = 0.5;
  const auto is_near = [](double x, double y) { return std::abs(x - y) < kSame_px; };
  geometry::PinholeCamera b_with_lens_of_a = a;
  b_with_lens_of_a.distortion = b.distortion;
  return is_near(a.fx, b.fx) && is_near(a.fy, b.fy) && is_near(a.cx, b.cx) && is_near(a.cy, b.cy) &&
         a == b_with_lens_of_a;
}

// Why the two do not belong together, or how they do.
Expected<StreamPair> pair_of(const ImageStream& color, const ImageStream& depth,
                             const TransformTree& tree) {
  StreamPair pair{color, depth, false, {}};
  if (!color.camera) return fail("{}: {}", color.topic, color.no_camera_reason);
  const bool is_one_frame = color.frame == depth.frame;
  const bool has_one_size = color.width == depth.width && color.height == depth.height;
  const bool is_one_camera = !depth.camera || is_one_view(*color.camera, *depth.camera);
  pair.is_registered = is_one_frame && has_one_size && is_one_camera;
  if (pair.is_registered) return pair;
  if (!depth.camera) return fail("{}: {}", depth.topic, depth.no_camera_reason);
  if (is_one_frame) return pair;
  const auto color_from_depth = tree.look_up(color.frame, depth.frame, depth.first_ns);
  if (!color_from_depth) {
    return fail(
        "{} (frame '{}') and {} (frame '{}'): no transform between them was recorded; record "
        "/tf_static, or depth that is registered to colour",
        depth.topic, depth.frame, color.topic, color.frame);
  }
  pair.color_from_depth = *color_from_depth;
  return pair;
}

// Less is better.
auto rank_of(const StreamPair& pair) {
  const auto baseline = std::floor(pair.color_from_depth.distance_m() / kBaselineStep_m);
  const std::size_t count = std::min(pair.color.count, pair.depth.count);
  const int compressed = pair.color.is_compressed + pair.depth.is_compressed;
  return std::tuple(pair.color.kind == PixelKind::kGray, !pair.is_registered, baseline,
                    -static_cast<int>(std::bit_width(count)), compressed, pair.color.topic,
                    pair.depth.topic);
}

bool is_color(const ImageStream& stream) {
  return stream.kind == PixelKind::kColor || stream.kind == PixelKind::kGray;
}

template <typename Wanted>
std::string topics_of(const std::vector<ImageStream>& streams, Wanted wanted) {
  std::string topics;
  for (const ImageStream& stream : streams) {
    if (wanted(stream)) topics += (topics.empty() ? "" : ", ") + stream.topic;
  }
  return topics.empty() ? "none" : topics;
}

Unexpected nothing_fits(const std::vector<ImageStream>& streams, std::vector<std::string> reasons) {
  constexpr std::size_t kMaxReasons = 3;
  const auto is_depth = [](const ImageStream& one) { return one.kind == PixelKind::kDepth; };
  const auto is_other = [](const ImageStream& one) { return one.kind == PixelKind::kOther; };
  std::string why;
  for (std::size_t i = 0; i < std::min(reasons.size(), kMaxReasons); ++i) why += "; " + reasons[i];
  return fail(
      "no colour and depth images that fit together: colour {}; depth {}; of other kinds {}{}",
      topics_of(streams, is_color), topics_of(streams, is_depth), topics_of(streams, is_other),
      why);
}

void note_others(const std::vector<ImageStream>& streams, const StreamPair& chosen,
                 std::vector<std::string>& notes) {
  const auto is_other = [&](const ImageStream& stream) {
    return stream.topic != chosen.color.topic && stream.topic != chosen.depth.topic;
  };
  const std::string others = topics_of(streams, is_other);
  notes.push_back(fmt::format("colour is {}, depth {}{}{}", chosen.color.topic, chosen.depth.topic,
                              chosen.is_registered ? "" : ", registered to colour here",
                              others == "none" ? "" : "; not taken: " + others));
}

}  // namespace

std::string realsense_stream_of(const std::string& topic) {
  const auto parts = parts_of(topic);
  const bool is_realsense =
      parts.size() > 3 && parts[0].starts_with("device_") && parts[1].starts_with("sensor_");
  return is_realsense ? fmt::format("/{}/{}/{}", parts[0], parts[1], parts[2]) : std::string();
}

std::vector<ImageStream> find_image_streams(const MessageLog& log,
                                            std::vector<std::string>& notes) {
  const std::vector<InfoStream> infos = find_infos(log, notes);
  std::vector<ImageStream> streams;
  for (std::size_t i = 0; i < log.channels().size(); ++i) {
    const Channel& channel = log.channels()[i];
    const bool is_image =
        channel.type == MessageType::kImage || channel.type == MessageType::kCompressedImage;
    if (!is_image || log.messages(i).empty()) continue;
    auto stream = stream_of(log, i);
    if (!stream) {
      notes.push_back(fmt::format("{} is left out: {}", channel.topic, stream.error().message));
      continue;
    }
    give_camera(*stream, infos);
    streams.push_back(*std::move(stream));
  }
  return streams;
}

Expected<StreamPair> choose_streams(const std::vector<ImageStream>& streams,
                                    const TransformTree& tree, std::vector<std::string>& notes) {
  std::optional<StreamPair> best;
  std::vector<std::string> reasons;
  for (const ImageStream& color : streams) {
    for (const ImageStream& depth : streams) {
      if (!is_color(color) || depth.kind != PixelKind::kDepth) continue;
      auto pair = pair_of(color, depth, tree);
      if (!pair) {
        reasons.push_back(pair.error().message);
      } else if (!best || rank_of(*pair) < rank_of(*best)) {
        best = *std::move(pair);
      }
    }
  }
  if (!best) return nothing_fits(streams, std::move(reasons));
  note_others(streams, *best, notes);
  return *std::move(best);
}

}  // namespace roomwise::recording
