#include "roomwise/guide/grammar/folded_words.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

namespace roomwise::guide {
namespace {

constexpr char32_t kNone = 0;  // no character: bytes that are no UTF-8

// Takes one character off the text.
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
    return kNone;
  }
  constexpr std::array<unsigned, 5> kFirstBits{0, 0x7F, 0x1F, 0x0F, 0x07};
  char32_t character = first & kFirstBits.at(length);
  for (std::size_t i = 1; i < length; ++i) character = character << 6U | (byte(i) & 0x3FU);
  text.remove_prefix(length);
  return character;
}

// The letters under the accents of U+0100 to U+017F, by how many of each follow each other.
char letter_of_extended_latin(char32_t character) {
  constexpr std::array<std::pair<char, int>, 22> kRuns{
      {{'a', 6},  {'c', 8},  {'d', 4}, {'e', 10}, {'g', 8}, {'h', 4}, {'i', 12}, {'j', 2},
       {'k', 3},  {'l', 10}, {'n', 9}, {'o', 6},  {'o', 2}, {'r', 6}, {'s', 8},  {'t', 6},
       {'u', 12}, {'w', 2},  {'y', 3}, {'z', 6},  {'s', 1}, {' ', 0}}};
  int place = static_cast<int>(character) - 0x100;
  for (const auto& [letter, count] : kRuns) {
    if (place < count) return letter;
    place -= count;
  }
  return ' ';
}

// Of U+00C0 to U+00FF; "" for the two signs among them.
std::string_view letters_of_latin_1(char32_t character) {
  constexpr std::string_view kLetters = "aaaaaa?ceeeeiiiidnooooo ouuuuyt?";
  if (character == 0xDF) return "ss";
  if (character == 0xFF) return "y";
  const std::size_t place = (character - 0xC0) % 0x20;
  if (place == 6) return "ae";
  return kLetters[place] == ' ' ? std::string_view() : kLetters.substr(place, 1);
}

bool is_mark_over_a_letter(char32_t character) {
  return character >= 0x300 && character <= 0x36F;
}

// Punctuation and spaces beyond Latin.
bool parts_words(char32_t character) {
  return (character >= 0x80 && character < 0xC0) || (character >= 0x2000 && character <= 0x2BFF) ||
         (character >= 0x3000 && character <= 0x303F) || character == 0xFEFF || character == 0xFFFD;
}

void add_utf8(char32_t character, std::string& text) {
  const auto add = [&](unsigned byte) { text += static_cast<char>(byte); };
  const auto rest = [&](unsigned shift) {
    return 0x80U | (static_cast<unsigned>(character) >> shift & 0x3FU);
  };
  const auto bits = static_cast<unsigned>(character);
  if (character < 0x80) return add(bits);
  if (character < 0x800) {
    add(0xC0U | bits >> 6U);
  } else if (character < 0x10000) {
    add(0xE0U | bits >> 12U);
    add(rest(6));
  } else {
    add(0xF0U | bits >> 18U);
    add(rest(12));
    add(rest(6));
  }
  add(rest(0));
}

// Adds what a character is compared by; false where it parts words.
bool add_folded(char32_t character, std::string& word) {
  if (character < 0x80) {
    const auto letter = static_cast<char>(character);
    const bool is_capital = letter >= 'A' && letter <= 'Z';
    const bool counts =
        is_capital || (letter >= 'a' && letter <= 'z') || (letter >= '0' && letter <= '9');
    if (counts) word += static_cast<char>(is_capital ? letter + ('a' - 'A') : letter);
    return counts;
  }
  if (is_mark_over_a_letter(character)) return true;
  if (parts_words(character)) return false;
  if (character < 0x100) {
    const std::string_view letters = letters_of_latin_1(character);
    word += letters;
    return !letters.empty();
  }
  if (character == 0x152 || character == 0x153) {
    word += "oe";
  } else if (character < 0x180) {
    word += letter_of_extended_latin(character);
  } else {
    add_utf8(character, word);
  }
  return true;
}

}  // namespace

std::vector<SpelledWord> spelled_words(std::string_view utf8) {
  std::vector<SpelledWord> words(1);
  while (!utf8.empty()) {
    const char32_t character = take_character(utf8);
    const bool goes_on = add_folded(character, words.back().folded);
    if (goes_on) add_utf8(character, words.back().spelling);
    if (goes_on) continue;
    if (words.back().folded.empty()) {
      words.back().spelling.clear();  // a mark without a letter
    } else {
      words.emplace_back();
    }
  }
  if (words.back().folded.empty()) words.pop_back();
  return words;
}

std::vector<std::string> folded_words(std::string_view utf8) {
  std::vector<std::string> words;
  for (SpelledWord& word : spelled_words(utf8)) words.push_back(std::move(word.folded));
  return words;
}

std::string joined(const std::vector<std::string>& words) {
  std::string result;
  for (const std::string& word : words) result += word;
  return result;
}

int slips_between(std::string_view a, std::string_view b) {
  // Rows of the table: two before, before, this one.
  std::array<std::vector<int>, 3> rows;
  for (auto& row : rows) row.resize(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) rows[1][j] = static_cast<int>(j);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    auto& [before_last, last, row] = rows;
    row[0] = static_cast<int>(i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const int wrong = last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      row[j] = std::min({wrong, last[j] + 1, row[j - 1] + 1});
      const bool is_exchanged = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (is_exchanged) row[j] = std::min(row[j], before_last[j - 2] + 1);
    }
    std::ranges::rotate(rows, rows.begin() + 1);
  }
  return rows[1][b.size()];
}

int forgiven_slips(std::string_view word) {
  constexpr std::size_t kLettersASlip = 4;
  return static_cast<int>(word.size() / kLettersASlip);
}

}  // namespace roomwise::guide
