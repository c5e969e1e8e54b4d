#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "roomwise/home/home.h"
#include "roomwise/network/vision/augmentation.h"
#include "roomwise/network/vision/classifier.h"
#include "roomwise/pipeline/run_context.h"

namespace roomwise::pipeline {

// Pictures to learn from, by their number.
struct PictureSource {
  std::size_t count = 0;
  // The picture's file; called by one thread at a time.
  std::function<Expected<Bytes>(std::size_t)> read;
  // What errors call it.
  std::function<std::string(std::size_t)> name;
  // Whose picture it is; absent for photos.
  std::function<home::KeyframeId(std::size_t)> keyframe = nullptr;
  // Asked about a picture that cannot be read, which the error tells, by one thread at a time:
  // success is to go on without it. Empty: the first ends the work.
  std::function<Expected<void>(std::size_t, const Error&)> leave_out = nullptr;
};

// Which variants of each picture are wanted: `first` to `last`, where 0 is the picture itself.
struct WantedVariants {
  int first = 0;
  int last = 0;
  network::AugmentationOptions options = {};
};
constexpr int kMaxVariants = 16;
// Features of more bytes than this are not kept in the home; they are then computed each time.
constexpr std::size_t kMaxKeptFeatureBytes = std::size_t{1} << 30U;

// Of each picture the features of each wanted variant, in order; of one that was left out, none.
// What the home keeps from the last time, made by the same weights that take pictures in the same
// way, is not computed again; afterwards it keeps what was wanted this time, and what else it had
// of these pictures, and nothing else. A picture's variants depend on its bytes and on the options
// alone. Features that were computed when the user interrupts are kept, too.
[[nodiscard]] Expected<std::vector<std::vector<std::vector<float>>>> picture_features(
    home::Home& home, const PictureSource& pictures, const network::Classifier& network,
    const WantedVariants& wanted, RunContext& run);

}  // namespace roomwise::pipeline
