#include "roomwise/pipeline/rooms/picture_features.h"

#include <algorithm>
#include <atomic>
#include <map>
#include <mutex>
#include <string_view>

#include "roomwise/base/file.h"
#include "roomwise/base/in_context.h"
#include "roomwise/image/codec.h"

namespace roomwise::pipeline {
namespace {

using Features = std::vector<float>;

// Of one picture, by variant.
struct Picture {
  std::string digest;
  std::optional<home::KeyframeId> keyframe;
  std::map<int, Features> features;
  bool is_left_out = false;
};

// A number that the picture's bytes alone determine: the first 64 bits of their digest.
std::uint64_t number_of(const std::string& digest) {
  return std::stoull(digest.substr(0, 16), nullptr, 16);
}

// By which the home knows features that were made in one way from those made in another: how
// pictures were varied, and how the network then takes them. Its weights have a key of their own.
std::string way_of_making(const network::AugmentationOptions& options,
                          const network::Classifier& network) {
  const std::string preprocessing = network.preprocessing();
  return preprocessing.empty() ? options.key() : options.key() + "\n" + preprocessing;
}

class FeatureMaker {
 public:
  FeatureMaker(const home::Home& home, const PictureSource& pictures,
               const network::Classifier& network, const WantedVariants& wanted, RunContext& run)
      : home_file_(home.file()),
        pictures_(pictures),
        network_(network),
        wanted_(wanted),
        way_(way_of_making(wanted.options, network)),
        run_(run),
        made_(pictures.count) {}

  Expected<void> read_kept(const home::Home& home) {
    ROOMWISE_TRY(auto kept, home.picture_features(network_.fingerprint(), way_));
    for (home::PictureFeatures& of_picture : kept) {
      if (of_picture.features.size() != network_.feature_size()) {
        return fail("{}: is damaged: features of a picture have {} values instead of {}",
                    home_file_, of_picture.features.size(), network_.feature_size());
      }
      Picture& picture = kept_[of_picture.picture_digest];
      picture.digest = of_picture.picture_digest;
      picture.keyframe = of_picture.keyframe;
      picture.features[of_picture.variant] = std::move(of_picture.features);
      ++kept_count_;
    }
    return {};
  }

  // Every picture, on all threads; stops at the first that fails, or where the user interrupts.
  Expected<void> make_all() {
    run_.progress.begin("looking at pictures", pictures_.count);
    Expected<void> done;
    const std::size_t block = 4 * run_.pool.size();
    for (std::size_t first = 0; first < pictures_.count && done; first += block) {
      if (run_.progress.interrupted()) {
        done = fail_with(ErrorCode::kInterrupted, "interrupted after {} of {} pictures", first,
                         pictures_.count);
        break;
      }
      const std::size_t in_block = std::min(block, pictures_.count - first);
      std::vector<Expected<void>> results(in_block);
      run_.pool.parallel_for(in_block, [&](std::size_t i) { results[i] = make(first + i); });
      for (Expected<void>& result : results) {
        if (done && !result) done = std::move(result);
      }
      run_.progress.advance(first + in_block, "");
    }
    run_.progress.end();
    return done;
  }

  // Lets the home keep what was made and what it had of the same pictures; of all pictures that it
  // had, where not every one was reached and it is not known which are gone. A picture that was
  // given twice counts once.
  Expected<void> keep(home::Home& home, bool all_reached) const {
    std::map<std::string_view, const Picture*> pictures;
    for (const Picture& picture : made_) {
      if (!picture.digest.empty()) pictures.emplace(picture.digest, &picture);
    }
    if (!all_reached) {
      for (const auto& [digest, picture] : kept_) pictures.emplace(digest, &picture);
    }
    std::size_t count = 0;
    for (const auto& [digest, picture] : pictures) count += picture->features.size();
    if (!made_something_new_ && count == kept_count_) return {};
    std::vector<home::PictureFeatures> all;
    if (count * network_.feature_size() * sizeof(float) <= kMaxKeptFeatureBytes) {
      for (const auto& [digest, picture] : pictures) {
        for (const auto& [variant, features] : picture->features) {
          all.push_back({picture->digest, variant, picture->keyframe, features});
        }
      }
    }
    return home.replace_picture_features(network_.fingerprint(), way_, all);
  }

  [[nodiscard]] std::vector<std::vector<Features>> wanted_features() const {
    std::vector<std::vector<Features>> features;
    for (const Picture& picture : made_) {
      auto& of_picture = features.emplace_back();
      if (picture.is_left_out) continue;
      for (int variant = wanted_.first; variant <= wanted_.last; ++variant) {
        of_picture.push_back(picture.features.at(variant));
      }
    }
    return features;
  }

 private:
  Expected<void> make(std::size_t i) {
    const Expected<Bytes> bytes = [&] {
      const std::scoped_lock lock(reading_);
      return pictures_.read(i);
    }();
    if (!bytes) return go_on_without(i, bytes.error());
    return add(i, *bytes);
  }

  Expected<void> go_on_without(std::size_t i, const Error& why) {
    const std::scoped_lock lock(reading_);
    if (!pictures_.leave_out) return Unexpected(why);
    made_[i].is_left_out = true;
    return pictures_.leave_out(i, why);
  }

  Expected<void> add(std::size_t i, const Bytes& bytes) {
    Picture& picture = made_[i];
    picture.digest = sha256_hex(bytes);
    if (pictures_.keyframe) picture.keyframe = pictures_.keyframe(i);
    if (const auto kept = kept_.find(picture.digest); kept != kept_.end()) {
      picture.features = kept->second.features;
    }
    std::optional<image::ColorImage> color;
    for (int variant = wanted_.first; variant <= wanted_.last; ++variant) {
      if (picture.features.contains(variant)) continue;
      if (!color) {
        const auto timing = run_.clock.measure("decode");
        auto decoded = in_context(pictures_.name(i), image::decode_color(bytes));
        if (!decoded) return go_on_without(i, decoded.error());
        color = *std::move(decoded);
      }
      ROOMWISE_TRY(auto features,
                   in_context(pictures_.name(i), look(*color, number_of(picture.digest), variant)));
      picture.features[variant] = std::move(features);
      made_something_new_ = true;
    }
    return {};
  }

  [[nodiscard]] Expected<Features> look(const image::ColorImage& color, std::uint64_t picture,
                                        int variant) const {
    image::ColorImage varied;
    if (variant != 0) {
      const auto timing = run_.clock.measure("augment");
      RandomStream random(picture, {static_cast<std::uint64_t>(variant)});
      varied = network::augment(color, wanted_.options, random);
    }
    const auto timing = run_.clock.measure("network " + network_.name());
    ROOMWISE_TRY(network::Prediction prediction, network_.predict(variant == 0 ? color : varied));
    return std::move(prediction.features);
  }

  const std::string& home_file_;
  const PictureSource& pictures_;
  const network::Classifier& network_;
  const WantedVariants& wanted_;
  const std::string way_;
  RunContext& run_;
  std::map<std::string, Picture> kept_;  // by digest
  std::size_t kept_count_ = 0;           // of features
  std::vector<Picture> made_;
  std::mutex reading_;
  std::atomic<bool> made_something_new_ = false;
};

}  // namespace

Expected<std::vector<std::vector<std::vector<float>>>> picture_features(
    home::Home& home, const PictureSource& pictures, const network::Classifier& network,
    const WantedVariants& wanted, RunContext& run) {
  ROOMWISE_RETURN_IF_ERROR(wanted.options.validate());
  if (wanted.first < 0 || wanted.last > kMaxVariants) {
    return fail("{} variants of each picture are wanted; expected 0 to {}", wanted.last,
                kMaxVariants);
  }
  FeatureMaker maker(home, pictures, network, wanted, run);
  ROOMWISE_RETURN_IF_ERROR(maker.read_kept(home));
  const Expected<void> made = maker.make_all();
  ROOMWISE_RETURN_IF_ERROR(maker.keep(home, made.has_value()));
  if (!made) return Unexpected(made.error());
  return maker.wanted_features();
}

}  // namespace roomwise::pipeline
