#include "roomwise/recording/phone/video_file.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libswscale/swscale.h>
}

#include <algorithm>
#include <array>
#include <mutex>
#include <optional>
#include <vector>

#include "roomwise/image/codec.h"

namespace roomwise::recording {
namespace {

template <typename Pointer, void (*free)(Pointer**)>
struct FreeAv {
  void operator()(Pointer* pointer) const { free(&pointer); }
};
using Format = std::unique_ptr<AVFormatContext, FreeAv<AVFormatContext, avformat_close_input>>;
using Codec = std::unique_ptr<AVCodecContext, FreeAv<AVCodecContext, avcodec_free_context>>;
using Packet = std::unique_ptr<AVPacket, FreeAv<AVPacket, av_packet_free>>;
using Frame = std::unique_ptr<AVFrame, FreeAv<AVFrame, av_frame_free>>;

std::string av_reason(int code) {
  std::array<char, AV_ERROR_MAX_STRING_SIZE> text{};
  av_strerror(code, text.data(), text.size());
  return text.data();
}

struct Picture {
  std::int64_t time = 0;  // in the stream's units
  bool is_key = false;
};

Expected<Format> open_format(const std::string& path) {
  AVDictionary* options = nullptr;
  // One file, nothing that it may point to.
  av_dict_set(&options, "protocol_whitelist", "file", 0);
  av_dict_set(&options, "format_whitelist", "mov,mp4,m4a,3gp,3g2,mj2", 0);
  AVFormatContext* format = nullptr;
  const int code = avformat_open_input(&format, ("file:" + path).c_str(), nullptr, &options);
  av_dict_free(&options);
  if (code < 0) {
    return fail("{}: is no MP4 video that can be read ({}); was it cut off? Copy it again", path,
                av_reason(code));
  }
  Format owned(format);
  if (const int found = avformat_find_stream_info(format, nullptr); found < 0) {
    return fail("{}: its streams cannot be read: {}", path, av_reason(found));
  }
  return owned;
}

image::ColorImage to_color(const AVFrame& frame, SwsContext* scaler) {
  image::ColorImage color(frame.width, frame.height);
  static_assert(sizeof(Rgb8) == 3);
  const std::array<std::uint8_t*, 1> rows{reinterpret_cast<std::uint8_t*>(color.pixels().data())};
  const std::array<int, 1> strides{3 * frame.width};
  sws_scale(scaler, frame.data, frame.linesize, 0, frame.height, rows.data(), strides.data());
  return color;
}

}  // namespace

struct VideoFile::Stream {
  std::string path;
  Format format;
  Codec codec;
  Packet packet{av_packet_alloc()};
  Frame frame{av_frame_alloc()};
  int index = 0;                  // of the stream in the file
  std::vector<Picture> pictures;  // in the order of their times
  std::mutex mutex;
  std::optional<std::int64_t> last;  // the time of the picture that was decoded last
  bool is_flushed = false;           // all packets were given to the decoder

  Expected<void> open();
  Expected<void> open_decoder();
  Expected<void> list_pictures();
  Expected<void> go_to_key_before(std::size_t place);
  Expected<bool> decode_next();
  Expected<image::ColorImage> read(std::size_t place);
  Expected<image::ColorImage> color() const;
};

Expected<void> VideoFile::Stream::open() {
  ROOMWISE_TRY(format, open_format(path));
  index = av_find_best_stream(format.get(), AVMEDIA_TYPE_VIDEO, -1, -1, nullptr, 0);
  if (index < 0) return fail("{}: holds no video", path);
  ROOMWISE_RETURN_IF_ERROR(open_decoder());
  return list_pictures();
}

Expected<void> VideoFile::Stream::open_decoder() {
  const AVCodecParameters& parameters = *format->streams[index]->codecpar;
  if (std::int64_t{parameters.width} * parameters.height > image::kMaxPixels) {
    return fail("{}: has pictures of {}x{} pixels, more than can be", path, parameters.width,
                parameters.height);
  }
  const AVCodec* decoder = avcodec_find_decoder(parameters.codec_id);
  if (decoder == nullptr) {
    return fail("{}: there is no decoder for {}", path, avcodec_get_name(parameters.codec_id));
  }
  codec.reset(avcodec_alloc_context3(decoder));
  codec->max_pixels = image::kMaxPixels;
  codec->thread_count = 1;
  const int copied = avcodec_parameters_to_context(codec.get(), &parameters);
  const int opened = copied < 0 ? copied : avcodec_open2(codec.get(), decoder, nullptr);
  if (opened < 0) return fail("{}: cannot be decoded: {}", path, av_reason(opened));
  return {};
}

Expected<void> VideoFile::Stream::list_pictures() {
  constexpr std::size_t kMost = 1U << 22U;
  int code = 0;
  bool is_cut_off = false;
  std::int64_t last_decoded = AV_NOPTS_VALUE;
  while ((code = av_read_frame(format.get(), packet.get())) >= 0) {
    const bool is_ours = packet->stream_index == index;
    const std::int64_t time = packet->pts != AV_NOPTS_VALUE ? packet->pts : packet->dts;
    const bool is_key = (packet->flags & AV_PKT_FLAG_KEY) != 0;
    is_cut_off = is_cut_off || (packet->flags & AV_PKT_FLAG_CORRUPT) != 0;
    const std::int64_t decoded = packet->dts;
    av_packet_unref(packet.get());
    if (is_cut_off) break;
    if (!is_ours) continue;
    last_decoded = decoded;
    if (time == AV_NOPTS_VALUE) return fail("{}: has pictures without a time", path);
    pictures.push_back({time, is_key});
    if (pictures.size() > kMost) return fail("{}: has more than {} pictures", path, kMost);
  }
  if (!is_cut_off && code != AVERROR_EOF) {
    return fail("{}: cannot be read: {}", path, av_reason(code));
  }
  std::ranges::sort(pictures, {}, &Picture::time);
  const auto listed = static_cast<std::size_t>(format->streams[index]->nb_frames);
  is_cut_off = is_cut_off || pictures.size() < listed;
  // What is decoded later is shown later, too.
  if (is_cut_off) {
    std::erase_if(pictures, [&](const Picture& one) { return one.time > last_decoded; });
  }
  if (pictures.empty() || !pictures.front().is_key) {
    return fail("{}: does not begin with a whole picture", path);
  }
  return {};
}

Expected<void> VideoFile::Stream::go_to_key_before(std::size_t place) {
  std::size_t key = place;
  while (!pictures[key].is_key) --key;  // the first is one
  const std::int64_t time = pictures[key].time;
  const bool goes_on = last && *last < pictures[place].time && time <= *last;
  if (goes_on) return {};
  const int code = av_seek_frame(format.get(), index, time, AVSEEK_FLAG_BACKWARD);
  if (code < 0) return fail("{}: picture {} is not found: {}", path, place, av_reason(code));
  avcodec_flush_buffers(codec.get());
  is_flushed = false;
  last.reset();
  return {};
}

// The next picture into `frame`; false at the end.
Expected<bool> VideoFile::Stream::decode_next() {
  for (;;) {
    const int got = avcodec_receive_frame(codec.get(), frame.get());
    if (got >= 0) return true;
    if (got == AVERROR_EOF) return false;
    if (got != AVERROR(EAGAIN)) return fail("{}: is damaged: {}", path, av_reason(got));
    const int read = av_read_frame(format.get(), packet.get());
    if (read < 0) {
      if (is_flushed) return false;
      is_flushed = true;
      avcodec_send_packet(codec.get(), nullptr);
      continue;
    }
    const int sent =
        packet->stream_index == index ? avcodec_send_packet(codec.get(), packet.get()) : 0;
    av_packet_unref(packet.get());
    if (sent < 0) return fail("{}: is damaged: {}", path, av_reason(sent));
  }
}

Expected<image::ColorImage> VideoFile::Stream::color() const {
  if (std::int64_t{frame->width} * frame->height > image::kMaxPixels) {
    return fail("{}: a picture has {}x{} pixels", path, frame->width, frame->height);
  }
  const std::unique_ptr<SwsContext, void (*)(SwsContext*)> scaler(
      sws_getContext(frame->width, frame->height, static_cast<AVPixelFormat>(frame->format),
                     frame->width, frame->height, AV_PIX_FMT_RGB24,
                     SWS_BILINEAR | SWS_ACCURATE_RND | SWS_BITEXACT, nullptr, nullptr, nullptr),
      sws_freeContext);
  if (scaler == nullptr) return fail("{}: its pixels are of a kind that is not read", path);
  sws_setColorspaceDetails(scaler.get(), sws_getCoefficients(frame->colorspace),
                           frame->color_range == AVCOL_RANGE_JPEG ? 1 : 0,
                           sws_getCoefficients(SWS_CS_DEFAULT), 1, 0, 1 << 16, 1 << 16);
  return to_color(*frame, scaler.get());
}

Expected<image::ColorImage> VideoFile::Stream::read(std::size_t place) {
  const std::scoped_lock lock(mutex);
  ROOMWISE_RETURN_IF_ERROR(go_to_key_before(place));
  for (;;) {
    const auto decoded = decode_next();
    if (!decoded) {
      last.reset();  // the next one begins at a key picture
      return Unexpected(Error(decoded.error()));
    }
    const bool is_past = *decoded && frame->best_effort_timestamp > pictures[place].time;
    if (!*decoded || is_past) {
      last.reset();
      return fail("{}: picture {} is missing or damaged", path, place);
    }
    last = frame->best_effort_timestamp;
    if (*last == pictures[place].time) return color();
  }
}

VideoFile::VideoFile(std::unique_ptr<Stream> stream) : stream_(std::move(stream)) {}
VideoFile::~VideoFile() = default;

Expected<std::unique_ptr<VideoFile>> VideoFile::open(const std::filesystem::path& path) {
  av_log_set_level(AV_LOG_QUIET);  // what matters is said in errors
  auto stream = std::make_unique<Stream>();
  stream->path = path.string();
  ROOMWISE_RETURN_IF_ERROR(stream->open());
  return std::unique_ptr<VideoFile>(new VideoFile(std::move(stream)));
}

std::size_t VideoFile::size() const {
  return stream_->pictures.size();
}

image::PersonalData VideoFile::personal_data() const {
  image::PersonalData facts;
  const AVDictionaryEntry* entry = nullptr;
  while ((entry = av_dict_get(stream_->format->metadata, "", entry, AV_DICT_IGNORE_SUFFIX))) {
    const std::string_view key = entry->key;
    const auto has = [&](std::string_view part) { return key.find(part) != key.npos; };
    facts.place = facts.place || has("location");
    facts.device = facts.device || has("make") || has("model");
    facts.owner = facts.owner || has("author") || has("artist");
  }
  return facts;
}

Expected<image::ColorImage> VideoFile::read(std::size_t place) {
  return stream_->read(place);
}

}  // namespace roomwise::recording
