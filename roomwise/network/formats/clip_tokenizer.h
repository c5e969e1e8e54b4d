#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "roomwise/base/expected.h"

namespace roomwise::network {

// Texts as the numbers that text networks of CLIP's kind take: byte-pair encoding (Sennrich 2016)
// of lower-case words, as OpenAI's CLIP does it. What is not done of it: characters that were
// encoded wrongly are not mended, HTML's are not decoded, and the marks of begin and end mean
// nothing within a text.
class ClipTokenizer {
 public:
  // merges: the published list of pairs (bpe_simple_vocab_16e6.txt, plain or packed by gzip, or
  // merges.txt), a first line with its version and a pair a line, the most frequent first; of a
  // longer list the first 48,894 count. vocabulary: vocab.json, each piece and its number; absent:
  // as OpenAI numbers them. Fails where a file is missing or holds something else.
  [[nodiscard]] static Expected<ClipTokenizer> read(
      const std::filesystem::path& merges,
      const std::optional<std::filesystem::path>& vocabulary = std::nullopt);

  // Far more than the 77 places of CLIP take; the time that a word takes grows with its square.
  static constexpr std::size_t kMaxBytes = 1024;

  // The numbers of a text's pieces. Fails where the text is longer than kMaxBytes.
  [[nodiscard]] Expected<std::vector<std::int64_t>> encode(std::string_view utf8) const;
  // Begin, the text's pieces as far as there is room, end, and `padding` up to `places` (at least
  // 2) numbers. Fails as encode() does.
  [[nodiscard]] Expected<std::vector<std::int64_t>> tokens(std::string_view utf8,
                                                           std::size_t places,
                                                           std::int64_t padding = 0) const;

  [[nodiscard]] std::size_t size() const { return numbers_.size(); }
  [[nodiscard]] std::int64_t begin() const { return begin_; }
  [[nodiscard]] std::int64_t end() const { return end_; }

 private:
  // The pieces of a word, whose bytes are written as the list of pairs writes them.
  [[nodiscard]] std::vector<std::string> pieces_of(std::string_view word) const;

  std::unordered_map<std::string, std::size_t> ranks_;     // by "first second"
  std::unordered_map<std::string, std::int64_t> numbers_;  // by piece
  std::int64_t begin_ = 0, end_ = 0;
};

}  // namespace roomwise::network
