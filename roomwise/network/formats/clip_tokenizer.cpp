#include "roomwise/network/formats/clip_tokenizer.h"

#include <unicode/locid.h>
#include <unicode/regex.h>
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

// A text's words, as OpenAI's CLIP writes them down: contractions, letters, single digits, and what
// else stands together.
constexpr const char16_t* kWords =
    uR"('s|'t|'re|'ve|'m|'ll|'d|\p{L}+|\p{N}|[^\p{White_Space}\p{L}\p{N}]+)";

bool is_visible(std::size_t byte) {
  return (byte >= '!' && byte <= '~') || (byte >= 0xA1 && byte != 0xAD);
}

// The bytes as characters that can be seen, as the list of pairs writes them: those of Latin 1 that
// can, and for the others, in their order, those from U+0100 on.
const std::array<std::string, 256>& visible_bytes() {
  static const std::array<std::string, 256> letters = [] {
    std::array<std::string, 256> made;
    UChar32 next = 0x100;
    for (UChar32 byte = 0; byte < 256; ++byte) {
      const UChar32 letter = is_visible(static_cast<std::size_t>(byte)) ? byte : next++;
      icu::UnicodeString(letter).toUTF8String(made.at(static_cast<std::size_t>(byte)));
    }
    return made;
  }();
  return letters;
}

// In small letters.
Expected<std::vector<std::string>> words_of(std::string_view utf8) {
  icu::UnicodeString text = icu::UnicodeString::fromUTF8(utf8);
  text.toLower(icu::Locale::getRoot());
  UErrorCode error = U_ZERO_ERROR;
  icu::RegexMatcher matcher(kWords, text, 0, error);
  std::vector<std::string> words;
  while (matcher.find(error) != 0) matcher.group(error).toUTF8String(words.emplace_back());
  if (U_FAILURE(error) != 0)
    return fail("a text cannot be parted into words: {}", u_errorName(error));
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

Expected<std::vector<std::int64_t>> ClipTokenizer::encode(std::string_view utf8) const {
  if (utf8.size() > kMaxBytes)
    return fail("a text of {} bytes is too long; it may have {}", utf8.size(), kMaxBytes);
  ROOMWISE_TRY(const std::vector<std::string> words, words_of(utf8));
  std::vector<std::int64_t> numbers;
  for (const std::string& word : words) {
    for (const std::string& piece : pieces_of(word)) numbers.push_back(numbers_.at(piece));
  }
  return numbers;
}

Expected<std::vector<std::int64_t>> ClipTokenizer::tokens(std::string_view utf8, std::size_t places,
                                                          std::int64_t padding) const {
  ROOMWISE_TRY(std::vector<std::int64_t> numbers, encode(utf8));
  numbers.resize(std::min(numbers.size(), places - 2));
  numbers.insert(numbers.begin(), begin_);
  numbers.push_back(end_);
  numbers.resize(places, padding);
  return numbers;
}

}  // namespace roomwise::network
