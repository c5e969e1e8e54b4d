#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/home/home.h"
#include "roomwise/network/vision/detection.h"
#include "roomwise/network/vision/open_vocabulary.h"
#include "roomwise/pipeline/run_context.h"

// Words that no label has, looked for in the pictures of a home by networks that compare the two.
namespace roomwise::pipeline {

// A place in a key-frame's picture.
struct WordPlace {
  home::KeyframeId keyframe = 0;
  network::PixelBox box;

  friend bool operator==(const WordPlace&, const WordPlace&) = default;
};

// What the pictures of a home show, and what hardly any home has, as networks see it.
struct WordPlaces {
  std::string made_from;  // which key-frames and networks, as derived data tells it
  std::vector<WordPlace> places;
  std::vector<network::Embedding> embeddings;  // by places
  std::vector<network::Embedding> absent;      // by absent_things()
};

// In how many key-frames words are looked for at most, evenly spread.
constexpr std::size_t kWordPictures = 200;

// Takes what was seen so far, to be kept by keep_word_places(), or not.
using KeepWordPlaces = std::function<void(const WordPlaces& so_far)>;
// Ten places of each picture: all of it, and nine windows of half its width and height. By what is
// kept in the home as derived data, as long as key-frames and networks are the same; the other
// pictures are looked at, and `keep` is called now and then, at the end, and where it is
// interrupted. Fails where the home has no pictures or is locked.
[[nodiscard]] Expected<WordPlaces> word_places(const home::Home& home,
                                               const network::OpenVocabulary& networks,
                                               RunContext& run, const KeepWordPlaces& keep = {});
// For a moment the only one that writes. Nothing is kept of a protected home, since words could be
// asked of it without its passphrase, nor of one whose key-frames are others by now.
[[nodiscard]] Expected<void> keep_word_places(home::Home& home,
                                              const network::OpenVocabulary& networks,
                                              const WordPlaces& so_far);

// Where a word is likeliest, and whether it is there.
struct FoundWord {
  WordPlace place;
  // How much better the place fits than the median one, beside what other words do.
  double above_usual = 0;
  // The share of words of absent things that fit some place as much above the usual, itself counted
  // among them: how often a word of the kind would be found by mistake.
  double false_alarms = 1;
  bool is_found = false;
};
// It is found where at most this share of absent words would be.
constexpr double kWordFalseAlarms = 0.02;

// places: at least one. word: what the networks say of it, by which the places were seen. Absent
// words: of things that hardly any home has (absent_things()), without the word itself.
[[nodiscard]] FoundWord find_word(const WordPlaces& places, const network::Embedding& word);

// Names of things that hardly any home has, in English.
[[nodiscard]] std::span<const std::string_view> absent_things();

}  // namespace roomwise::pipeline
