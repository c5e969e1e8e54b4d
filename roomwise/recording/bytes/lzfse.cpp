#include "roomwise/recording/bytes/lzfse.h"

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>

#include "roomwise/base/byte_reader.h"
#include "roomwise/recording/bytes/lzvn.h"

namespace roomwise::recording {
namespace {

using Data = std::span<const std::uint8_t>;

constexpr std::uint32_t magic_of(const char (&name)[5]) {
  std::uint32_t magic = 0;
  for (int i = 3; i >= 0; --i) magic = magic << 8U | static_cast<std::uint8_t>(name[i]);
  return magic;
}
constexpr std::uint32_t kEndMagic = magic_of("bvx$");
constexpr std::uint32_t kPlainMagic = magic_of("bvx-");
constexpr std::uint32_t kLzvnMagic = magic_of("bvxn");
constexpr std::uint32_t kTablesMagic = magic_of("bvx1");
constexpr std::uint32_t kPackedTablesMagic = magic_of("bvx2");

// A block of LZFSE holds literals and triples (L, M, D): copy L literals, then M bytes from D back.
// All four kinds of symbols are coded by finite state entropy (FSE, a form of asymmetric numeral
// systems), each with its own number of states. L, M and D are a base and some extra bits.
constexpr std::size_t kLengthSymbols = 20;
constexpr std::size_t kDistanceSymbols = 64;
constexpr std::size_t kLiteralSymbols = 256;
constexpr std::size_t kLengthStates = 64;
constexpr std::size_t kDistanceStates = 256;
constexpr std::size_t kLiteralStates = 1024;
constexpr std::uint32_t kMaxTriples = 10000;
constexpr std::uint32_t kMaxLiterals = 4 * kMaxTriples;

constexpr std::array<std::uint8_t, kLengthSymbols> kLiteralLengthBits{0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
                                                                      0, 0, 0, 0, 0, 0, 2, 3, 5, 8};
constexpr std::array<std::uint8_t, kLengthSymbols> kMatchLengthBits{0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
                                                                    0, 0, 0, 0, 0, 0, 3, 5, 8, 11};
constexpr std::uint8_t distance_bits(std::size_t symbol) {
  return static_cast<std::uint8_t>(symbol / 4);
}

// Each symbol's values begin where those of the one before end.
template <std::size_t kCount, typename BitsOf>
constexpr std::array<std::uint32_t, kCount> bases(BitsOf bits_of) {
  std::array<std::uint32_t, kCount> base{};
  for (std::size_t i = 1; i < kCount; ++i) base[i] = base[i - 1] + (1U << bits_of(i - 1));
  return base;
}

// The bits of a payload, the last ones first: the encoder wrote them in the other order.
class BackwardBits {
 public:
  // `padding`: bits at the end that say nothing, 0 to 7.
  BackwardBits(Data payload, unsigned padding)
      : payload_(payload), left_(payload.size() * 8), ok_(left_ >= padding) {
    if (ok_) left_ -= padding;
  }
  [[nodiscard]] bool ok() const { return ok_; }
  // count <= 32. Beyond the first bit: 0, and ok() is false.
  std::uint32_t pull(unsigned count) {
    if (count > left_) {
      ok_ = false;
      return 0;
    }
    left_ -= count;
    const std::uint64_t word = load_at(left_ / 8) >> (left_ % 8);
    return static_cast<std::uint32_t>(word & ((std::uint64_t{1} << count) - 1));
  }

 private:
  [[nodiscard]] std::uint64_t load_at(std::size_t byte) const {
    if (byte + 8 <= payload_.size()) return load<std::uint64_t>(payload_.data() + byte);
    std::uint64_t word = 0;
    for (std::size_t i = payload_.size(); i-- > byte;) word = word << 8U | payload_[i];
    return word;
  }
  Data payload_;
  std::size_t left_;
  bool ok_;
};

// What a state of FSE says: its symbol, and how the next state is read.
struct FseState {
  std::uint8_t symbol = 0;
  std::uint8_t bits = 0;
  std::uint16_t base = 0;
};

// A symbol that occurs f times among n states owns f of them. As many as are missing to the next
// fit read one bit more than the others, so that together they lead to each of the n states once.
template <std::size_t kStates>
class FseTable {
 public:
  // False where the frequencies claim more states than there are.
  bool set(std::span<const std::uint16_t> frequencies) {
    size_ = 0;
    for (std::size_t symbol = 0; symbol < frequencies.size(); ++symbol) {
      const unsigned f = frequencies[symbol];
      if (f == 0) continue;
      if (f > kStates - size_) return false;
      add(static_cast<std::uint8_t>(symbol), f);
    }
    return true;
  }
  // The state's symbol, or -1 where nothing is known of the state; moves on to the next state.
  int next(std::uint32_t& state, BackwardBits& bits) const {
    if (state >= size_) return -1;
    const FseState& entry = states_[state];
    state = entry.base + bits.pull(entry.bits);
    return entry.symbol;
  }

 private:
  void add(std::uint8_t symbol, unsigned f) {
    const auto bits = static_cast<unsigned>(std::countl_zero(f) - std::countl_zero(kAll));
    const unsigned with_all_bits = ((2 * kAll) >> bits) - f;
    for (unsigned i = 0; i < f; ++i) {
      const bool all = i < with_all_bits;
      const unsigned base = all ? ((f + i) << bits) - kAll : (i - with_all_bits) << (bits - 1);
      states_[size_++] = {symbol, static_cast<std::uint8_t>(all ? bits : bits - 1),
                          static_cast<std::uint16_t>(base)};
    }
  }
  static constexpr auto kAll = static_cast<unsigned>(kStates);
  std::array<FseState, kStates> states_{};
  std::size_t size_ = 0;
};

// How often each symbol occurs, in the order of the file.
struct Frequencies {
  std::array<std::uint16_t, 2 * kLengthSymbols + kDistanceSymbols + kLiteralSymbols> all{};

  [[nodiscard]] auto literal_lengths() const { return part(0, kLengthSymbols); }
  [[nodiscard]] auto match_lengths() const { return part(kLengthSymbols, kLengthSymbols); }
  [[nodiscard]] auto distances() const { return part(2 * kLengthSymbols, kDistanceSymbols); }
  [[nodiscard]] auto literals() const {
    return part(2 * kLengthSymbols + kDistanceSymbols, kLiteralSymbols);
  }

 private:
  [[nodiscard]] std::span<const std::uint16_t> part(std::size_t from, std::size_t count) const {
    return std::span(all).subspan(from, count);
  }
};

struct BlockHeader {
  std::uint32_t size = 0;  // of the decoded bytes
  std::uint32_t literals = 0, literal_bytes = 0, literal_padding = 0;
  std::uint32_t triples = 0, triple_bytes = 0, triple_padding = 0;
  std::array<std::uint32_t, 4> literal_states{};
  std::uint32_t literal_length_state = 0, match_length_state = 0, distance_state = 0;
  Frequencies frequencies;

  [[nodiscard]] bool is_possible() const {
    return literals <= kMaxLiterals && literals % 4 == 0 && triples <= kMaxTriples &&
           literal_padding < 8 && triple_padding < 8;
  }
};

std::uint32_t field(std::uint64_t word, unsigned from, unsigned count) {
  return static_cast<std::uint32_t>(word >> from & ((std::uint64_t{1} << count) - 1));
}

// Bits, the first ones first.
class ForwardBits {
 public:
  explicit ForwardBits(Data bytes) : bytes_(bytes) {}
  [[nodiscard]] std::uint32_t peek(unsigned count) const {
    std::uint32_t bits = 0;
    for (unsigned i = 0; i < count && position_ + i < 8 * bytes_.size(); ++i) {
      const std::size_t at = position_ + i;
      bits |= (std::uint32_t{bytes_[at / 8]} >> (at % 8) & 1U) << i;
    }
    return bits;
  }
  void skip(unsigned count) { position_ += count; }
  // Whether all were read but those that fill the last byte.
  [[nodiscard]] bool at_end() const {
    return position_ <= 8 * bytes_.size() && 8 * bytes_.size() - position_ < 8;
  }

 private:
  Data bytes_;
  std::size_t position_ = 0;
};

// A frequency by a fixed prefix code: 00 and 10 for 0 and 1, 001 and 101 for 2 and 3, xx011 for 4
// to 7, 0111 and four bits for 8 to 23, 1111 and ten bits for the rest (prefixes as peeked, the
// first bit lowest).
std::uint16_t next_frequency(ForwardBits& bits) {
  const std::uint32_t word = bits.peek(14);
  const auto take = [&](unsigned count, std::uint32_t value) {
    bits.skip(count);
    return static_cast<std::uint16_t>(value);
  };
  if ((word & 1U) == 0) return take(2, word >> 1U & 1U);
  if ((word & 2U) == 0) return take(3, 2 + (word >> 2U & 1U));
  if ((word & 4U) == 0) return take(5, 4 + (word >> 3U & 3U));
  if ((word & 8U) == 0) return take(8, 8 + (word >> 4U & 15U));
  return take(14, 24 + (word >> 4U & 1023U));
}

bool read_frequencies(Data packed, Frequencies& frequencies) {
  if (packed.empty()) return true;
  ForwardBits bits(packed);
  for (std::uint16_t& frequency : frequencies.all) frequency = next_frequency(bits);
  return bits.at_end();
}

// bvx2: the fields share three words, the frequencies are packed. False where it is damaged.
bool read_packed_header(ByteReader& in, BlockHeader& header) {
  const std::size_t begin = in.position() - 4;
  header.size = in.number<std::uint32_t>();
  std::array<std::uint64_t, 3> words{};
  for (std::uint64_t& word : words) word = in.number<std::uint64_t>();
  header.literals = field(words[0], 0, 20);
  header.literal_bytes = field(words[0], 20, 20);
  header.triples = field(words[0], 40, 20);
  header.literal_padding = 7 - field(words[0], 60, 3);
  for (unsigned i = 0; i < 4; ++i) header.literal_states[i] = field(words[1], 10 * i, 10);
  header.triple_bytes = field(words[1], 40, 20);
  header.triple_padding = 7 - field(words[1], 60, 3);
  const std::uint32_t header_size = field(words[2], 0, 32);
  header.literal_length_state = field(words[2], 32, 10);
  header.match_length_state = field(words[2], 42, 10);
  header.distance_state = field(words[2], 52, 10);
  const std::size_t read = in.position() - begin;
  if (header_size < read) return false;
  return read_frequencies(in.bytes(header_size - read), header.frequencies);
}

// bvx1: each field by itself.
bool read_plain_header(ByteReader& in, BlockHeader& header) {
  header.size = in.number<std::uint32_t>();
  in.number<std::uint32_t>();  // bytes of both payloads
  header.literals = in.number<std::uint32_t>();
  header.triples = in.number<std::uint32_t>();
  header.literal_bytes = in.number<std::uint32_t>();
  header.triple_bytes = in.number<std::uint32_t>();
  header.literal_padding = 0U - in.number<std::uint32_t>();
  for (std::uint32_t& state : header.literal_states) state = in.number<std::uint16_t>();
  header.triple_padding = 0U - in.number<std::uint32_t>();
  header.literal_length_state = in.number<std::uint16_t>();
  header.match_length_state = in.number<std::uint16_t>();
  header.distance_state = in.number<std::uint16_t>();
  for (std::uint16_t& frequency : header.frequencies.all) frequency = in.number<std::uint16_t>();
  in.bytes(2);  // the structure is padded to whole words
  return true;
}

Unexpected damaged(std::string_view what) {
  return fail("damaged LZFSE data ({}); export the recording again", what);
}

// Four streams of literals take turns.
Expected<Bytes> decode_literals(const BlockHeader& header, Data payload) {
  FseTable<kLiteralStates> table;
  if (!table.set(header.frequencies.literals())) return damaged("literals' frequencies");
  BackwardBits bits(payload, header.literal_padding);
  auto states = header.literal_states;
  Bytes literals(header.literals);
  for (std::size_t i = 0; i < literals.size(); ++i) {
    const int symbol = table.next(states[i % 4], bits);
    if (symbol < 0 || !bits.ok()) return damaged("literals");
    literals[i] = static_cast<std::uint8_t>(symbol);
  }
  return literals;
}

struct Triple {
  std::uint32_t literals = 0, match = 0, distance = 0;
};

class TripleDecoder {
 public:
  TripleDecoder(const BlockHeader& header, Data payload)
      : literal_length_state_(header.literal_length_state),
        match_length_state_(header.match_length_state),
        distance_state_(header.distance_state),
        bits_(payload, header.triple_padding),
        ok_(literal_lengths_.set(header.frequencies.literal_lengths()) &&
            match_lengths_.set(header.frequencies.match_lengths()) &&
            distances_.set(header.frequencies.distances())) {}

  Triple next() {
    static constexpr auto kLiteralBases =
        bases<kLengthSymbols>([](std::size_t i) { return kLiteralLengthBits[i]; });
    static constexpr auto kMatchBases =
        bases<kLengthSymbols>([](std::size_t i) { return kMatchLengthBits[i]; });
    static constexpr auto kDistanceBases = bases<kDistanceSymbols>(distance_bits);
    Triple triple;
    const std::size_t literals = symbol(literal_lengths_, literal_length_state_);
    triple.literals = kLiteralBases[literals] + bits_.pull(kLiteralLengthBits[literals]);
    const std::size_t match = symbol(match_lengths_, match_length_state_);
    triple.match = kMatchBases[match] + bits_.pull(kMatchLengthBits[match]);
    const std::size_t distance = symbol(distances_, distance_state_);
    triple.distance = kDistanceBases[distance] + bits_.pull(distance_bits(distance));
    return triple;
  }
  [[nodiscard]] bool ok() const { return ok_ && bits_.ok(); }

 private:
  template <std::size_t kStates>
  std::size_t symbol(const FseTable<kStates>& table, std::uint32_t& state) {
    const int symbol = table.next(state, bits_);
    if (symbol < 0) ok_ = false;
    return symbol < 0 ? 0 : static_cast<std::size_t>(symbol);
  }
  FseTable<kLengthStates> literal_lengths_, match_lengths_;
  FseTable<kDistanceStates> distances_;
  std::uint32_t literal_length_state_, match_length_state_, distance_state_;
  BackwardBits bits_;
  bool ok_;
};

Expected<void> decode_triples(const BlockHeader& header, Data payload, Data literals,
                              LzOutput& out) {
  TripleDecoder decoder(header, payload);
  std::uint32_t distance = 0;
  for (std::uint32_t i = 0; i < header.triples; ++i) {
    const Triple triple = decoder.next();
    if (!decoder.ok() || triple.literals > literals.size()) return damaged("lengths");
    if (triple.distance != 0) distance = triple.distance;
    if (!out.append(literals.first(triple.literals)) || !out.repeat(distance, triple.match)) {
      return damaged("a match");
    }
    literals = literals.subspan(triple.literals);
  }
  return {};
}

Expected<void> decode_block(ByteReader& in, bool tables_are_packed, LzOutput& out) {
  BlockHeader header;
  const bool read =
      tables_are_packed ? read_packed_header(in, header) : read_plain_header(in, header);
  if (!in.ok()) return damaged("it was cut off");
  if (!read || !header.is_possible()) return damaged("a block's head");
  const Data literal_payload = in.bytes(header.literal_bytes);
  const Data triple_payload = in.bytes(header.triple_bytes);
  if (!in.ok()) return damaged("it was cut off");
  ROOMWISE_TRY(const Bytes literals, decode_literals(header, literal_payload));
  const std::size_t before = out.size();
  ROOMWISE_RETURN_IF_ERROR(decode_triples(header, triple_payload, literals, out));
  if (out.size() - before != header.size) return damaged("a block's size");
  return {};
}

Expected<void> decode_lzvn_block(ByteReader& in, LzOutput& out) {
  const auto size = in.number<std::uint32_t>();
  const Data payload = in.counted_bytes<std::uint32_t>();
  if (!in.ok()) return damaged("it was cut off");
  const std::size_t before = out.size();
  if (!decode_lzvn(payload, out) || out.size() - before != size) return damaged("LZVN");
  return {};
}

Expected<void> copy_plain_block(ByteReader& in, LzOutput& out) {
  const Data payload = in.counted_bytes<std::uint32_t>();
  if (!in.ok()) return damaged("it was cut off");
  if (!out.append(payload)) return damaged("larger than it should be");
  return {};
}

}  // namespace

bool is_lzfse(Data packed) {
  if (packed.size() < 4) return false;
  const auto magic = load<std::uint32_t>(packed.data());
  return magic == kEndMagic || magic == kPlainMagic || magic == kLzvnMagic ||
         magic == kTablesMagic || magic == kPackedTablesMagic;
}

Expected<Bytes> decode_lzfse(Data packed, std::size_t max_size) {
  ByteReader in(packed);
  LzOutput out(max_size);
  for (;;) {
    const auto magic = in.number<std::uint32_t>();
    if (!in.ok()) return damaged("it was cut off");
    if (magic == kEndMagic) return std::move(out).take();
    if (magic == kPlainMagic) {
      ROOMWISE_RETURN_IF_ERROR(copy_plain_block(in, out));
    } else if (magic == kLzvnMagic) {
      ROOMWISE_RETURN_IF_ERROR(decode_lzvn_block(in, out));
    } else if (magic == kTablesMagic || magic == kPackedTablesMagic) {
      ROOMWISE_RETURN_IF_ERROR(decode_block(in, magic == kPackedTablesMagic, out));
    } else {
      return damaged("an unknown block");
    }
  }
}

}  // namespace roomwise::recording
