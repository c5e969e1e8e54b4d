#include "roomwise/pipeline/objects/find_word.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <set>

#include "roomwise/base/in_context.h"
#include "roomwise/base/median.h"
#include "roomwise/base/spread.h"
#include "roomwise/image/resample.h"
#include "roomwise/pipeline/stored/keyframe_images.h"
#include "roomwise/pipeline/stored/made_from.h"

namespace roomwise::pipeline {
namespace {

constexpr const char* kWordPlacesData = "word_places";
constexpr std::size_t kNumbersOfAPlace = 5;  // key-frame, left, top, right, bottom

std::string made_from(std::span<const home::Keyframe> keyframes,
                      const network::OpenVocabulary& networks) {
  MadeFrom from;
  from.add("word places 2");
  from.add(networks.fingerprint());
  for (const home::Keyframe& keyframe : keyframes) {
    from.add(keyframe.id);
    from.add(static_cast<std::uint64_t>(keyframe.recording));
    from.add(keyframe.frame_index);
  }
  return from.digest();
}

// All one after the other.
nlohmann::json binary_of(std::span<const network::Embedding> embeddings) {
  std::vector<std::uint8_t> bytes;
  for (const network::Embedding& embedding : embeddings) {
    const auto* begin = reinterpret_cast<const std::uint8_t*>(embedding.data());
    bytes.insert(bytes.end(), begin, begin + embedding.size() * sizeof(float));
  }
  return nlohmann::json::binary(std::move(bytes));
}

// So many of so many numbers; none where the bytes are not as many.
std::vector<network::Embedding> embeddings_from(const nlohmann::json& binary, std::size_t count,
                                                std::size_t numbers) {
  const auto& bytes = binary.get_binary();
  const std::size_t each = numbers * sizeof(float);
  std::vector<network::Embedding> embeddings;
  if (bytes.size() != count * each) return embeddings;
  for (std::size_t i = 0; i < count; ++i) {
    std::memcpy(embeddings.emplace_back(numbers).data(), bytes.data() + i * each, each);
  }
  return embeddings;
}

Bytes to_bytes(const WordPlaces& kept) {
  nlohmann::json json{{"places", nlohmann::json::array()},
                      {"embeddings", binary_of(kept.embeddings)},
                      {"absent", binary_of(kept.absent)}};
  for (const auto& [keyframe, box] : kept.places)
    json["places"].push_back({keyframe, box.left, box.top, box.right, box.bottom});
  return nlohmann::json::to_cbor(json);
}

bool are_finite(std::span<const network::Embedding> embeddings) {
  return std::ranges::all_of(embeddings, [](const network::Embedding& one) {
    return std::ranges::all_of(one, [](float number) { return std::isfinite(number); });
  });
}

// Nothing where the bytes are damaged: then they are made anew.
std::optional<WordPlaces> from_bytes(const Bytes& bytes, std::span<const home::Keyframe> keyframes,
                                     std::size_t numbers) {
  std::set<home::KeyframeId> known;
  for (const home::Keyframe& keyframe : keyframes) known.insert(keyframe.id);
  WordPlaces kept;
  try {
    const auto json = nlohmann::json::from_cbor(bytes);
    for (const auto& one : json.at("places")) {
      if (one.size() != kNumbersOfAPlace) return std::nullopt;
      kept.places.push_back({one.at(0).get<home::KeyframeId>(),
                             {one.at(1).get<float>(), one.at(2).get<float>(),
                              one.at(3).get<float>(), one.at(4).get<float>()}});
      if (!known.contains(kept.places.back().keyframe)) return std::nullopt;
    }
    kept.embeddings = embeddings_from(json.at("embeddings"), kept.places.size(), numbers);
    kept.absent = embeddings_from(json.at("absent"), absent_things().size(), numbers);
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
  if (kept.embeddings.size() != kept.places.size() || kept.absent.empty()) return std::nullopt;
  if (!are_finite(kept.embeddings) || !are_finite(kept.absent)) return std::nullopt;
  return kept;
}

// How many key-frames, from the first, were looked at; they come in order.
std::size_t pictures_looked_at(const WordPlaces& places,
                               std::span<const home::Keyframe> keyframes) {
  if (places.places.empty()) return 0;
  const auto last =
      std::ranges::find(keyframes, places.places.back().keyframe, &home::Keyframe::id);
  return static_cast<std::size_t>(last - keyframes.begin()) + 1;
}

// All of a picture, and nine windows of half its sides.
std::vector<network::PixelBox> places_of(const image::ColorImage& picture) {
  const auto width = static_cast<float>(picture.width());
  const auto height = static_cast<float>(picture.height());
  std::vector<network::PixelBox> places{{0, 0, width, height}};
  for (const float top : {0.F, 0.25F, 0.5F}) {
    for (const float left : {0.F, 0.25F, 0.5F})
      places.push_back({left * width, top * height, (left + 0.5F) * width, (top + 0.5F) * height});
  }
  return places;
}

Expected<WordPlaces> embed_places(const home::Keyframe& keyframe, const image::ColorImage& picture,
                                  const network::OpenVocabulary& networks) {
  WordPlaces made;
  for (const network::PixelBox& box : places_of(picture)) {
    const int left = static_cast<int>(box.left), top = static_cast<int>(box.top);
    const int width = std::max(1, static_cast<int>(box.right) - left);
    const int height = std::max(1, static_cast<int>(box.bottom) - top);
    ROOMWISE_TRY(network::Embedding embedding,
                 networks.embed(image::crop(picture, left, top, width, height)));
    made.places.push_back({keyframe.id, box});
    made.embeddings.push_back(std::move(embedding));
  }
  return made;
}

// Goes on where `all` ends.
Expected<void> embed_rest(const home::Home& home, std::span<const home::Keyframe> keyframes,
                          const network::OpenVocabulary& networks, RunContext& run,
                          const KeepWordPlaces& keep, WordPlaces& all) {
  if (all.absent.empty()) {
    const std::span<const std::string_view> absent = absent_things();
    std::vector<network::Embedding> embeddings;
    ROOMWISE_RETURN_IF_ERROR(in_blocks(
        absent.size(), "reading words of absent things", run,
        [&](std::size_t i) -> Expected<std::string_view> { return absent[i]; },
        [&](std::size_t, const std::string_view& thing) { return networks.embed(thing); },
        [&](std::size_t, network::Embedding embedding) -> Expected<void> {
          embeddings.push_back(std::move(embedding));
          return {};
        }));
    all.absent = std::move(embeddings);
  }
  constexpr std::size_t kKeepAfter = 10;  // pictures: some half a minute of looking at them
  std::size_t since_kept = 0;
  return for_each_keyframe(
      home, keyframes.subspan(pictures_looked_at(all, keyframes)),
      "looking at the pictures for words", run,
      [&](const home::Keyframe& keyframe, const DecodedImages& images) {
        return embed_places(keyframe, images.color, networks);
      },
      [&](const home::Keyframe& keyframe, Expected<WordPlaces> made) -> Expected<void> {
        ROOMWISE_TRY(const WordPlaces seen,
                     in_context(fmt::format("key-frame {}", keyframe.id), std::move(made)));
        std::ranges::copy(seen.places, std::back_inserter(all.places));
        std::ranges::copy(seen.embeddings, std::back_inserter(all.embeddings));
        if (keep && ++since_kept % kKeepAfter == 0) keep(all);
        return {};
      });
}

// What all the words have in common.
network::Embedding mean_of(std::span<const network::Embedding> words) {
  network::Embedding mean(words.front().size(), 0);
  for (const network::Embedding& word : words) {
    for (std::size_t i = 0; i < mean.size(); ++i)
      mean[i] += word[i] / static_cast<float>(words.size());
  }
  return mean;
}

// How much better than the median place the likeliest one fits a word, and which it is.
std::pair<double, std::size_t> best_above_usual(network::Embedding word,
                                                const network::Embedding& common,
                                                const WordPlaces& places) {
  for (std::size_t i = 0; i < word.size(); ++i) word[i] -= common[i];
  std::vector<double> fits;
  for (const network::Embedding& place : places.embeddings)
    fits.push_back(network::similarity(word, place));
  const auto best = std::ranges::max_element(fits);
  const auto index = static_cast<std::size_t>(best - fits.begin());
  const double most = *best;
  return {most - median_of(fits), index};
}

}  // namespace

Expected<WordPlaces> word_places(const home::Home& home, const network::OpenVocabulary& networks,
                                 RunContext& run, const KeepWordPlaces& keep) {
  ROOMWISE_TRY(const auto all, home.keyframes());
  if (all.empty()) return fail("{}: has no pictures of a walk to look for words in", home.file());
  if (home.is_locked()) return Unexpected(home.locked_error());
  const std::vector<home::Keyframe> keyframes = spread_evenly(all, kWordPictures);
  WordPlaces places;
  const std::string from = made_from(keyframes, networks);
  ROOMWISE_TRY(const auto kept, home.derived_data(kWordPlacesData));
  if (kept && kept->made_from == from) {
    if (auto known = from_bytes(kept->data, keyframes, networks.size())) places = *std::move(known);
  }
  places.made_from = from;
  const std::size_t known = places.places.size();
  const auto looked = embed_rest(home, keyframes, networks, run, keep, places);
  const bool is_new = places.places.size() > known;
  if (keep && is_new) keep(places);
  if (!looked) return Unexpected(looked.error());
  return places;
}

Expected<void> keep_word_places(home::Home& home, const network::OpenVocabulary& networks,
                                const WordPlaces& so_far) {
  if (home.is_protected()) return {};
  ROOMWISE_TRY(const auto all, home.keyframes());
  if (so_far.made_from != made_from(spread_evenly(all, kWordPictures), networks)) return {};
  return home.put_derived_data({kWordPlacesData, so_far.made_from, to_bytes(so_far)});
}

FoundWord find_word(const WordPlaces& places, const network::Embedding& asked) {
  std::vector<network::Embedding> absent = places.absent;
  std::erase(absent, asked);
  absent.push_back(asked);  // among them, so that it is treated as they are
  const network::Embedding common = mean_of(absent);
  absent.pop_back();
  const auto [above, best] = best_above_usual(asked, common, places);
  std::size_t as_far = 1;  // itself, were it absent
  for (const network::Embedding& other : absent) {
    if (best_above_usual(other, common, places).first >= above) ++as_far;
  }
  const double share = static_cast<double>(as_far) / static_cast<double>(absent.size() + 1);
  return FoundWord{places.places[best], above, share, share <= kWordFalseAlarms};
}

}  // namespace roomwise::pipeline
