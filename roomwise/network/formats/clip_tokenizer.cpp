#include "roomwise/network/formats/clip_tokenizer.h"

#include <locale.h>
#include <wctype.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <memory>
#include <nlohmann/json.hpp>

#include "roomwise/base/file.h"

namespace roomwise::network {
namespace {

constexpr std::size_t kMaxMerges = 49152 - 256 - 2;  // CLIP's, of a longer list
constexpr const char* kBegin = "<|startoftext|>";
constexpr const char* kEnd = "<|endoftext|>";
constexpr const char* kEndOfWord = "</w>";

// What a text is made of.
enum class Kind { kSpace, kLetter, kDigit, kOther };

// Letters by Unicode, whatever the locale of the program is; absent where the system has none.
locale_t unicode() {
  static const locale_t locale = newlocale(LC_CTYPE_MASK, "C.UTF-8", nullptr);
  return locale;
}

Kind kind_of(char32_t character) {
  const auto within = [&](char32_t first, char32_t last) {
    return character >= first && character <= last;
  };
  if (within('0', '9') || within(0xB2, 0xB3) || character == 0xB9 || within(0xBC, 0xBE) ||
      within(0x2070, 0x2089) || within(0x2150, 0x2189) || within(0x2460, 0x249B)) {
    return Kind::kDigit;
  }
  const auto wide = static_cast<wint_t>(character);
  if (character == 0xA0 || iswspace_l(wide, unicode()) != 0) return Kind::kSpace;
  return iswalpha_l(wide, unicode()) != 0 ? Kind::kLetter : Kind::kOther;
}

// Takes one character off the text; a byte that begins none is U+FFFD.
char32_t take_character(std::string_view& text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  const std::size_t length = first < 0x80                    ? 1
                             : first >= 0xC2 && first < 0xE0 ? 2
                             : first >= 0xE0 && first < 0xF0 ? 3
                             : first >= 0xF0 && first < 0xF5 ? 4
                                                             : 0;
  bool is_whole = length > 0 && length <= text.size();
  for (std::size_t i = 1; is_whole && i < length; ++i) is_whole = (byte(i) & 0xC0U) == 0x80;
  if (!is_whole) {
    text.remove_prefix(1);
    return 0xFFFD;
  }
  constexpr std::array<unsigned, 5> kFirstBits{0, 0x7F, 0x1F, 0x0F, 0x07};
  char32_t character = first & kFirstBits.at(length);
  for (std::size_t i = 1; i < length; ++i) character = character << 6U | (byte(i) & 0x3FU);
  text.remove_prefix(length);
  return character;
}

void add_utf8(char32_t character, std::string& text) {
  const auto bits = static_cast<unsigned>(character);
  const auto add = [&](unsigned byte) { text += static_cast<char>(byte); };
  if (bits < 0x80) return add(bits);
  const unsigned further = bits < 0x800 ? 1 : bits < 0x10000 ? 2 : 3;
  constexpr std::array<unsigned, 4> kFirst{0, 0xC0, 0xE0, 0xF0};
  add(kFirst.at(further) | bits >> 6 * further);
  for (unsigned i = further; i-- > 0;) add(0x80U | (bits >> 6 * i & 0x3FU));
}

bool is_visible(std::size_t byte) {
  return (byte >= '!' && byte <= '~') || (byte >= 0xA1 && byte != 0xAD);
}

// The bytes as characters that can be seen, as the list of pairs writes them: those of Latin 1 that
// can, and for the others, in their order, those from U+0100 on.
const std::array<std::string, 256>& visible_bytes() {
  static const std::array<std::string, 256> letters = [] {
    std::array<std::string, 256> made;
    char32_t next = 0x100;
    for (char32_t byte = 0; byte < 256; ++byte)
      add_utf8(is_visible(byte) ? byte : next++, made.at(byte));
    return made;
  }();
  return letters;
}

// The words of a text in small letters: contractions, letters, single digits, and what else stands
// together.
std::vector<std::string> words_of(std::string_view utf8) {
  std::u32string text;
  while (!utf8.empty()) {
    const char32_t character = take_character(utf8);
    text += static_cast<char32_t>(towlower_l(static_cast<wint_t>(character), unicode()));
  }
  constexpr std::array<std::u32string_view, 7> kContractions{U"'s", U"'t",  U"'re", U"'ve",
                                                             U"'m", U"'ll", U"'d"};
  std::vector<std::string> words;
  for (std::u32string_view rest = text; !rest.empty();) {
    const Kind kind = kind_of(rest.front());
    const auto contraction = std::ranges::find_if(
        kContractions, [&](std::u32string_view each) { return rest.starts_with(each); });
    std::size_t length = 1;
    if (contraction != kContractions.end()) {
      length = contraction->size();
    } else if (kind != Kind::kDigit) {
      while (length < rest.size() && kind_of(rest[length]) == kind) ++length;
    }
    if (kind != Kind::kSpace) {
      std::string& word = words.emplace_back();
      for (const char32_t character : rest.substr(0, length)) add_utf8(character, word);
    }
    rest.remove_prefix(length);
  }
  return words;
}

// A file's bytes, unpacked where gzip packed them.
Expected<std::string> read_plain_or_packed(const std::filesystem::path& path) {
  constexpr std::size_t kMaxBytes = std::size_t{1} << 25;
  const std::unique_ptr<gzFile_s, decltype(&gzclose)> file(gzopen(path.c_str(), "rb"), gzclose);
  if (file == nullptr) return fail("{}: cannot be opened", path.string());
  std::string text;
  std::array<char, 1 << 16> part{};
  for (;;) {
    const int read = gzread(file.get(), part.data(), part.size());
    if (read < 0) return fail("{}: is damaged", path.string());
    if (read == 0) break;
    text.append(part.data(), static_cast<std::size_t>(read));
    if (text.size() > kMaxBytes) return fail("{}: is too large for a list of pairs", path.string());
  }
  int error = Z_OK;
  gzerror(file.get(), &error);
  if (error != Z_OK && error != Z_STREAM_END) return fail("{}: is damaged", path.string());
  return text;
}

using Pair = std::pair<std::string, std::string>;

Expected<std::vector<Pair>> read_merges(const std::filesystem::path& path) {
  ROOMWISE_TRY(const std::string text, read_plain_or_packed(path));
  std::vector<Pair> pairs;
  std::size_t number = 0;
  for (std::string_view rest = text; !rest.empty() && pairs.size() < kMaxMerges;) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    std::string_view line = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);
    ++number;
    if (number == 1) {
      if (line.find("#version") == std::string_view::npos) {
        return fail("{}: expected a list of pairs whose first line says \"#version\"",
                    path.string());
      }
      continue;
    }
    if (line.empty() && rest.empty()) break;
    const std::size_t space = line.find(' ');
    if (space == 0 || space >= line.size() - 1 || line.find(' ', space + 1) != line.npos)
      return fail("{}: line {}: expected two pieces", path.string(), number);
    pairs.emplace_back(line.substr(0, space), line.substr(space + 1));
  }
  return pairs;
}

Expected<std::unordered_map<std::string, std::int64_t>> read_vocabulary(
    const std::filesystem::path& path) {
  ROOMWISE_TRY(const Bytes bytes, read_file(path));
  const nlohmann::json json = nlohmann::json::parse(bytes, nullptr, false);
  constexpr std::int64_t kMaxNumber = 1 << 24;
  std::unordered_map<std::string, std::int64_t> numbers;
  if (!json.is_object()) return fail("{}: expected a number for each piece", path.string());
  for (const auto& [piece, number] : json.items()) {
    if (!number.is_number_integer() || number < 0 || number >= kMaxNumber)
      return fail("{}: expected a number for \"{}\"", path.string(), piece);
    numbers[piece] = number.get<std::int64_t>();
  }
  return numbers;
}

// OpenAI's: the bytes in the order of the characters they are written as, the same at a word's end,
// what is joined, the two marks.
std::unordered_map<std::string, std::int64_t> numbers_of(const std::vector<Pair>& pairs) {
  std::vector<std::string> pieces;
  for (const bool visible : {true, false}) {
    for (std::size_t byte = 0; byte < 256; ++byte) {
      if (is_visible(byte) == visible) pieces.push_back(visible_bytes().at(byte));
    }
  }
  for (std::size_t i = 0; i < 256; ++i) pieces.push_back(pieces[i] + kEndOfWord);
  for (const auto& [first, second] : pairs) pieces.push_back(first + second);
  pieces.insert(pieces.end(), {kBegin, kEnd});
  std::unordered_map<std::string, std::int64_t> numbers;
  for (std::size_t i = 0; i < pieces.size(); ++i) numbers[pieces[i]] = static_cast<std::int64_t>(i);
  return numbers;
}

}  // namespace

Expected<ClipTokenizer> ClipTokenizer::read(
    const std::filesystem::path& merges, const std::optional<std::filesystem::path>& vocabulary) {
  if (unicode() == nullptr) return fail("the system lacks the locale C.UTF-8");
  ClipTokenizer tokenizer;
  ROOMWISE_TRY(const std::vector<Pair> pairs, read_merges(merges));
  for (const auto& [first, second] : pairs)
    tokenizer.ranks_.insert({first + ' ' + second, tokenizer.ranks_.size()});
  if (vocabulary) {
    ROOMWISE_TRY(tokenizer.numbers_, read_vocabulary(*vocabulary));
  } else {
    tokenizer.numbers_ = numbers_of(pairs);
  }
  std::vector<std::string> wanted{kBegin, kEnd};
  for (const std::string& byte : visible_bytes()) {
    wanted.push_back(byte);
    wanted.push_back(byte + kEndOfWord);
  }
  for (const auto& [first, second] : pairs) wanted.push_back(first + second);
  for (const std::string& piece : wanted) {
    if (!tokenizer.numbers_.contains(piece)) {
      return fail("{}: has no number for \"{}\"", vocabulary.value_or(merges).string(), piece);
    }
  }
  tokenizer.begin_ = tokenizer.numbers_.at(kBegin);
  tokenizer.end_ = tokenizer.numbers_.at(kEnd);
  return tokenizer;
}

std::vector<std::string> ClipTokenizer::pieces_of(std::string_view word) const {
  std::vector<std::string> pieces;
  for (const char letter : word)
    pieces.push_back(visible_bytes().at(static_cast<unsigned char>(letter)));
  pieces.back() += kEndOfWord;
  for (;;) {
    // The pair that was joined first when the list was made, wherever it stands.
    auto best = ranks_.end();
    for (std::size_t i = 0; i + 1 < pieces.size(); ++i) {
      const auto found = ranks_.find(pieces[i] + ' ' + pieces[i + 1]);
      if (found != ranks_.end() && (best == ranks_.end() || found->second < best->second))
        best = found;
    }
    if (best == ranks_.end()) return pieces;
    std::vector<std::string> joined;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      const bool joins = i + 1 < pieces.size() && pieces[i] + ' ' + pieces[i + 1] == best->first;
      joined.push_back(joins ? pieces[i] + pieces[i + 1] : pieces[i]);
      if (joins) ++i;
    }
    pieces = std::move(joined);
  }
}

std::vector<std::int64_t> ClipTokenizer::encode(std::string_view utf8) const {
  std::vector<std::int64_t> numbers;
  for (const std::string& word : words_of(utf8)) {
    for (const std::string& piece : pieces_of(word)) numbers.push_back(numbers_.at(piece));
  }
  return numbers;
}

std::vector<std::int64_t> ClipTokenizer::tokens(std::string_view utf8, std::size_t places,
                                                std::int64_t padding) const {
  std::vector<std::int64_t> numbers = encode(utf8);
  numbers.resize(std::min(numbers.size(), places - 2));
  numbers.insert(numbers.begin(), begin_);
  numbers.push_back(end_);
  numbers.resize(places, padding);
  return numbers;
}

}  // namespace roomwise::network
