#include "roomwise/recording/bytes/lzvn.h"

#include <algorithm>

#include "roomwise/base/byte_reader.h"

namespace roomwise::recording {
namespace {

// What an opcode says: copy `literals` bytes that follow it, then `match` bytes from `distance`
// back (0: from as far as the last time).
struct LzvnStep {
  std::size_t literals = 0, match = 0, distance = 0;
};

enum class LzvnKind { kStep, kNothing, kEnd, kDamaged };

constexpr std::size_t kMinMatch = 3;
constexpr std::size_t kLongBias = 16;  // what does not fit into four bits begins here
constexpr std::size_t kEndBytes = 8;   // the opcode and zeros

// 1110LLLL, 1111MMMM: literals or a match alone; four zero bits: the length follows.
LzvnStep read_single(std::uint8_t opcode, ByteReader& in) {
  const std::size_t length =
      (opcode & 15U) != 0 ? opcode & 15U : in.number<std::uint8_t>() + kLongBias;
  return opcode >= 0xF0 ? LzvnStep{0, length, 0} : LzvnStep{length, 0, 0};
}

// 101LLMMM DDDDDDMM DDDDDDDD
LzvnStep read_medium(std::uint8_t opcode, ByteReader& in) {
  const auto word = in.number<std::uint16_t>();
  return {static_cast<std::size_t>(opcode >> 3U & 3U),
          ((opcode & 7U) << 2U | (word & 3U)) + kMinMatch, static_cast<std::size_t>(word >> 2U)};
}

// LLMMMDDD DDDDDDDD, LLMMM111 DDDDDDDD DDDDDDDD, and LLMMM110 for the last distance
LzvnKind read_common(std::uint8_t opcode, ByteReader& in, LzvnStep& step) {
  step.literals = opcode >> 6U;
  step.match = (opcode >> 3U & 7U) + kMinMatch;
  const std::size_t low = opcode & 7U;
  if (low == 7) {
    step.distance = in.number<std::uint16_t>();
  } else if (low < 6) {
    step.distance = low << 8U | in.number<std::uint8_t>();
  }
  // A far or a near match of distance 0 would read as "the last one".
  return low != 6 && step.distance == 0 ? LzvnKind::kDamaged : LzvnKind::kStep;
}

LzvnKind read_step(ByteReader& in, LzvnStep& step) {
  const auto opcode = in.number<std::uint8_t>();
  if (opcode >= 0xE0) {
    step = read_single(opcode, in);
    return LzvnKind::kStep;
  }
  if ((opcode & 0xE0U) == 0xA0) {
    step = read_medium(opcode, in);
    return step.distance == 0 ? LzvnKind::kDamaged : LzvnKind::kStep;
  }
  if (opcode == 6) return LzvnKind::kEnd;
  if (opcode == 14 || opcode == 22) return LzvnKind::kNothing;
  const bool unused =
      (opcode & 0xF0U) == 0x70 || (opcode & 0xF0U) == 0xD0 || ((opcode & 7U) == 6 && opcode < 0x40);
  return unused ? LzvnKind::kDamaged : read_common(opcode, in, step);
}

}  // namespace

bool LzOutput::append(std::span<const std::uint8_t> bytes) {
  if (bytes.size() > max_size_ - bytes_.size()) return false;
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  return true;
}

bool LzOutput::repeat(std::size_t distance, std::size_t count) {
  if (count == 0) return true;
  const std::size_t begin = bytes_.size();
  if (distance == 0 || distance > begin || count > max_size_ - begin) return false;
  bytes_.resize(begin + count);
  std::uint8_t* to = bytes_.data() + begin;
  const std::uint8_t* from = bytes_.data() + (begin - distance);
  if (distance >= count) {
    std::copy_n(from, count, to);
  } else {
    for (std::size_t i = 0; i < count; ++i) to[i] = from[i];
  }
  return true;
}

bool decode_lzvn(std::span<const std::uint8_t> payload, LzOutput& out) {
  ByteReader in(payload);
  std::size_t distance = 0;
  for (;;) {
    LzvnStep step;
    const LzvnKind kind = read_step(in, step);
    if (!in.ok() || kind == LzvnKind::kDamaged) return false;
    if (kind == LzvnKind::kEnd) return in.remaining() == kEndBytes - 1;
    if (step.distance != 0) distance = step.distance;
    const auto literals = in.bytes(step.literals);
    if (!in.ok() || !out.append(literals) || !out.repeat(distance, step.match)) return false;
  }
}

}  // namespace roomwise::recording
