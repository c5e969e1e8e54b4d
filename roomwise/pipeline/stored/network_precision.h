#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "roomwise/home/home.h"
#include "roomwise/network/formats/network_file.h"
#include "roomwise/network/vision/classifier_quantization.h"

namespace roomwise::pipeline {

// How networks that serve features only, which tell rooms apart, look at a home's pictures. All
// others look in floats.
enum class NetworkPrecision {
  // In 8 bits where a check on the home's own pictures found that near enough to floats, and as its
  // rooms were learned, where they were; else in floats.
  kAuto,
  kFloat,
  kEightBits,
};
// "auto", "float", "eight-bits".
[[nodiscard]] Expected<NetworkPrecision> parse_network_precision(std::string_view name);

// What a check on a home's own pictures (network::quantize_classifier) found of a network. The home
// keeps it among its settings, since what is learned with other ranges would have to be learned
// anew.
struct PrecisionCheck {
  std::optional<network::EightBitFile> eight_bits;  // absent: it stays in floats
  std::string why;                                  // for people: how near 8 bits came
};

// That of this network, with the card of now; nothing where there was none.
[[nodiscard]] Expected<std::optional<PrecisionCheck>> stored_precision_check(
    const home::Home& home, const network::NetworkFile& file);

// How networks run in 8 bits at this home, by all checks that allowed it.
[[nodiscard]] Expected<std::vector<network::EightBitFile>> stored_ways_of_eight_bits(
    const home::Home& home);

// Whether the network is to be checked before it looks at pictures of the home for the first time:
// not where a check is stored, nor, with kAuto, where it has looked at the home in floats already.
[[nodiscard]] Expected<bool> needs_precision_check(const home::Home& home,
                                                   const network::NetworkFile& file,
                                                   NetworkPrecision precision);

// Checks the network on at most 80 of these pictures of the home, evenly spread, and stores what
// came of it. Too few are no error, but a reason for floats, and not stored. Fails where a picture
// cannot be read. `runs_done`: network::checked_quantization.
[[nodiscard]] Expected<PrecisionCheck> check_precision(home::Home& home,
                                                       const std::filesystem::path& weights,
                                                       std::size_t pictures,
                                                       const network::PictureAt& picture,
                                                       std::size_t threads,
                                                       const network::RunsDone& runs_done = {});

// The network as it is to look at the home's pictures. Fails where it is to do so in 8 bits and no
// check allows that.
[[nodiscard]] Expected<network::NetworkFile> in_precision(const home::Home& home,
                                                          network::NetworkFile file,
                                                          NetworkPrecision precision);

// A home that was made when cards did not count knows a network with a card of one's own by its
// weights alone: it is known so there on. Not where Roomwise brings a card of this file along, by
// which it may have looked.
[[nodiscard]] Expected<network::NetworkFile> known_as_before(const home::Home& home,
                                                             network::NetworkFile file,
                                                             const std::filesystem::path& weights);

}  // namespace roomwise::pipeline
