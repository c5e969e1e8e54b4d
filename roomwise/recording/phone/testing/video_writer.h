#pragma once

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
}

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <functional>

namespace roomwise::recording::testing {

// An MP4 file of `count` pictures without colour, of the brightness of the i-th at (x, y), with
// pictures that are predicted from later ones and a whole one every `gop`; its index before or
// behind them. False where it cannot be made.
[[nodiscard]] inline bool write_video(const std::filesystem::path& path, int count,
                                      const std::function<std::uint8_t(int i, int x, int y)>& luma,
                                      AVCodecID kind, int gop, int width, int height,
                                      bool index_first = false) {
  AVFormatContext* format = nullptr;
  const AVCodec* encoder = avcodec_find_encoder(kind);
  if (encoder == nullptr ||
      avformat_alloc_output_context2(&format, nullptr, "mp4", path.c_str()) < 0) {
    return false;
  }
  format->flags |= AVFMT_FLAG_BITEXACT;  // the same bytes at any time
  AVStream* stream = avformat_new_stream(format, nullptr);
  AVCodecContext* codec = avcodec_alloc_context3(encoder);
  codec->width = width;
  codec->height = height;
  codec->pix_fmt = AV_PIX_FMT_YUV420P;
  codec->time_base = {1, 30};
  codec->gop_size = gop;
  codec->max_b_frames = 2;
  codec->thread_count = 1;
  codec->flags |= AV_CODEC_FLAG_GLOBAL_HEADER | AV_CODEC_FLAG_QSCALE | AV_CODEC_FLAG_BITEXACT;
  codec->global_quality = FF_QP2LAMBDA * 2;
  av_opt_set(codec->priv_data, "x265-params", "log-level=none:pools=none:frame-threads=1", 0);
  bool is_fine = avcodec_open2(codec, encoder, nullptr) >= 0 &&
                 avcodec_parameters_from_context(stream->codecpar, codec) >= 0;
  stream->time_base = codec->time_base;
  AVDictionary* options = nullptr;
  av_dict_set(&options, "movflags", "faststart", 0);
  is_fine = is_fine && avio_open(&format->pb, path.c_str(), AVIO_FLAG_WRITE) >= 0 &&
            avformat_write_header(format, index_first ? &options : nullptr) >= 0;
  av_dict_free(&options);

  AVPacket* packet = av_packet_alloc();
  const auto write_packets = [&] {
    while (is_fine && avcodec_receive_packet(codec, packet) >= 0) {
      av_packet_rescale_ts(packet, codec->time_base, stream->time_base);
      packet->stream_index = stream->index;
      is_fine = av_interleaved_write_frame(format, packet) >= 0;
    }
  };
  AVFrame* frame = av_frame_alloc();
  frame->format = codec->pix_fmt;
  frame->width = width;
  frame->height = height;
  is_fine = is_fine && av_frame_get_buffer(frame, 0) >= 0;
  for (int i = 0; i < count && is_fine; ++i) {
    is_fine = av_frame_make_writable(frame) >= 0;
    for (int y = 0; y < height && is_fine; ++y) {
      std::uint8_t* const row = frame->data[0] + std::ptrdiff_t{y} * frame->linesize[0];
      for (int x = 0; x < width; ++x) row[x] = luma(i, x, y);
    }
    for (const int plane : {1, 2}) {
      for (int y = 0; y < height / 2 && is_fine; ++y) {
        std::fill_n(frame->data[plane] + y * frame->linesize[plane], width / 2, std::uint8_t{128});
      }
    }
    frame->pts = i;
    is_fine = is_fine && avcodec_send_frame(codec, frame) >= 0;
    write_packets();
  }
  if (is_fine) avcodec_send_frame(codec, nullptr);
  write_packets();
  is_fine = is_fine && av_write_trailer(format) >= 0;
  avio_closep(&format->pb);
  av_frame_free(&frame);
  av_packet_free(&packet);
  avcodec_free_context(&codec);
  avformat_free_context(format);
  return is_fine;
}

// The same of grey pictures, the i-th of brightness 20 + 6 * (i % 32).
[[nodiscard]] inline bool write_grey_video(const std::filesystem::path& path, int count,
                                           AVCodecID kind = AV_CODEC_ID_MPEG4, int gop = 6,
                                           int width = 64, int height = 48,
                                           bool index_first = false) {
  const auto luma = [](int i, int, int) { return static_cast<std::uint8_t>(20 + 6 * (i % 32)); };
  return write_video(path, count, luma, kind, gop, width, height, index_first);
}

// What a picture of such a video shows: luma 16 to 235 spread to 0 to 255.
inline int brightness_of_grey_video(int i) {
  return static_cast<int>((20 + 6 * (i % 32) - 16) * 255 / 219.0 + 0.5);
}

}  // namespace roomwise::recording::testing
