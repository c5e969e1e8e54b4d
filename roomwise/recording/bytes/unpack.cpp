#include "roomwise/recording/bytes/unpack.h"

#include <bzlib.h>
#include <lz4frame.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <memory>

namespace roomwise::recording {
namespace {

constexpr std::size_t kFirstRoom = std::size_t{1} << 16;
// bzlib and zlib count in 32 bits; files keep each chunk far below.
constexpr std::uint64_t kMaxPacked = std::uint64_t{1} << 30, kMaxStep = kMaxPacked;
// A Zstandard frame may ask for a window of any size; the library's own default for streams.
constexpr int kMaxZstdWindowLog = 27;

using Packed = std::span<const std::uint8_t>;

struct Step {
  std::size_t taken = 0;  // of the packed bytes
  std::size_t given = 0;  // into the room
  bool ended = false;     // the stream says that it is whole
};

// The unpackers: each takes what it can of `packed` and fills what it can of `room`.
class Lz4 {
 public:
  Lz4() { LZ4F_createDecompressionContext(&context_, LZ4F_VERSION); }
  ~Lz4() { LZ4F_freeDecompressionContext(context_); }
  Lz4(const Lz4&) = delete;
  Lz4& operator=(const Lz4&) = delete;
  Expected<Step> step(Packed packed, std::span<std::uint8_t> room) {
    Step step{packed.size(), room.size(), false};
    const std::size_t hint =
        LZ4F_decompress(context_, room.data(), &step.given, packed.data(), &step.taken, nullptr);
    if (LZ4F_isError(hint) != 0) return fail("damaged LZ4 data ({})", LZ4F_getErrorName(hint));
    step.ended = hint == 0;
    return step;
  }

 private:
  LZ4F_dctx* context_ = nullptr;
};

class Zstd {
 public:
  Zstd() : context_(ZSTD_createDCtx()) {
    ZSTD_DCtx_setParameter(context_, ZSTD_d_windowLogMax, kMaxZstdWindowLog);
  }
  ~Zstd() { ZSTD_freeDCtx(context_); }
  Zstd(const Zstd&) = delete;
  Zstd& operator=(const Zstd&) = delete;
  Expected<Step> step(Packed packed, std::span<std::uint8_t> room) {
    ZSTD_inBuffer in{packed.data(), packed.size(), 0};
    ZSTD_outBuffer out{room.data(), room.size(), 0};
    const std::size_t hint = ZSTD_decompressStream(context_, &out, &in);
    if (ZSTD_isError(hint) != 0) {
      return fail("damaged Zstandard data ({})", ZSTD_getErrorName(hint));
    }
    return Step{in.pos, out.pos, hint == 0};
  }

 private:
  ZSTD_DCtx* context_;
};

class Bz2 {
 public:
  Bz2() { BZ2_bzDecompressInit(&stream_, 0, 0); }
  ~Bz2() { BZ2_bzDecompressEnd(&stream_); }
  Bz2(const Bz2&) = delete;
  Bz2& operator=(const Bz2&) = delete;
  Expected<Step> step(Packed packed, std::span<std::uint8_t> room) {
    // bzlib takes no const, but changes nothing there.
    stream_.next_in = const_cast<char*>(reinterpret_cast<const char*>(packed.data()));
    stream_.avail_in = static_cast<unsigned>(packed.size());
    stream_.next_out = reinterpret_cast<char*>(room.data());
    stream_.avail_out = static_cast<unsigned>(room.size());
    const int result = BZ2_bzDecompress(&stream_);
    if (result != BZ_OK && result != BZ_STREAM_END) return fail("damaged bzip2 data ({})", result);
    return Step{packed.size() - stream_.avail_in, room.size() - stream_.avail_out,
                result == BZ_STREAM_END};
  }

 private:
  bz_stream stream_{};
};

class Zlib {
 public:
  Zlib() { inflateInit(&stream_); }
  ~Zlib() { inflateEnd(&stream_); }
  Zlib(const Zlib&) = delete;
  Zlib& operator=(const Zlib&) = delete;
  Expected<Step> step(Packed packed, std::span<std::uint8_t> room) {
    // zlib takes no const, but changes nothing there.
    stream_.next_in = const_cast<Bytef*>(packed.data());
    stream_.avail_in = static_cast<uInt>(packed.size());
    stream_.next_out = room.data();
    stream_.avail_out = static_cast<uInt>(room.size());
    const int result = inflate(&stream_, Z_NO_FLUSH);
    if (result != Z_OK && result != Z_STREAM_END && result != Z_BUF_ERROR) {
      return fail("damaged zlib data ({})", stream_.msg != nullptr ? stream_.msg : "no zlib");
    }
    return Step{packed.size() - stream_.avail_in, room.size() - stream_.avail_out,
                result == Z_STREAM_END};
  }

 private:
  z_stream stream_{};
};

// Gives room for more, up to one byte beyond `size`: that there is nothing more must be seen.
void grow(Bytes& out, std::size_t filled, std::uint64_t size) {
  if (filled < out.size()) return;
  const std::uint64_t wanted = std::max<std::uint64_t>(kFirstRoom, 2 * std::uint64_t{out.size()});
  out.resize(static_cast<std::size_t>(std::min(wanted, size + 1)));
}

template <typename Unpacker>
Expected<Bytes> unpack_with(Packed packed, std::uint64_t size) {
  Unpacker unpacker;
  Bytes out;
  std::size_t filled = 0;
  bool ended = false;
  for (bool moves = true; moves && !(ended && packed.empty());) {
    grow(out, filled, size);
    const std::size_t room = std::min<std::size_t>(out.size() - filled, kMaxStep);
    ROOMWISE_TRY(const Step step,
                 unpacker.step(packed, std::span<std::uint8_t>(out).subspan(filled, room)));
    packed = packed.subspan(step.taken);
    filled += step.given;
    if (filled > size) return fail("holds more than the {} bytes that it should", size);
    ended = step.ended;
    moves = step.taken > 0 || step.given > 0;
  }
  if (filled != size) return fail("holds {} bytes instead of {}", filled, size);
  if (!ended || !packed.empty()) return fail("does not end where it should");
  out.resize(filled);
  return out;
}

}  // namespace

Expected<Packing> packing_named(std::string_view name) {
  if (name.empty() || name == "none") return Packing::kNone;
  if (name == "lz4") return Packing::kLz4;
  if (name == "zstd") return Packing::kZstd;
  if (name == "bz2") return Packing::kBz2;
  return fail("is compressed by '{}', which is unknown here; write it with lz4, zstd, bz2 or none",
              name);
}

Expected<Bytes> unpack(Packing packing, Packed packed, std::uint64_t size) {
  if (packed.size() > kMaxPacked) return fail("{} packed bytes are too many", packed.size());
  switch (packing) {
    case Packing::kNone:
      if (packed.size() != size) return fail("holds {} bytes instead of {}", packed.size(), size);
      return Bytes(packed.begin(), packed.end());
    case Packing::kLz4:
      return unpack_with<Lz4>(packed, size);
    case Packing::kZstd:
      return unpack_with<Zstd>(packed, size);
    case Packing::kBz2:
      return unpack_with<Bz2>(packed, size);
    case Packing::kZlib:
      return unpack_with<Zlib>(packed, size);
  }
  return fail("is packed in no known way");
}

}  // namespace roomwise::recording
