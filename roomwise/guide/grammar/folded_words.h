#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace roomwise::guide {

// The words of a text as they are compared: in small letters, without accents ("Küche" -> "kuche",
// "ß" -> "ss"), parted at all that is neither a letter nor a digit. Any bytes: what is no UTF-8
// parts words.
[[nodiscard]] std::vector<std::string> folded_words(std::string_view utf8);
// The same words, each beside the way it was written ("kuche", "Küche"), to be spoken back.
struct SpelledWord {
  std::string folded;
  std::string spelling;
};
[[nodiscard]] std::vector<SpelledWord> spelled_words(std::string_view utf8);
// The same without the spaces, so that "livingroom" is "living room".
[[nodiscard]] std::string joined(const std::vector<std::string>& words);

// How many slips of a finger lead from one to the other: a letter missing, too many, wrong, or two
// exchanged (optimal string alignment distance). Time and space: the product of their lengths.
[[nodiscard]] int slips_between(std::string_view a, std::string_view b);
// How many are forgiven in a word: one for every four letters, none in shorter ones.
[[nodiscard]] int forgiven_slips(std::string_view word);

}  // namespace roomwise::guide
