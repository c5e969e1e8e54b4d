#include "roomwise/pipeline/rooms/room_baselines.h"

#include <algorithm>
#include <cmath>

#include "roomwise/base/spread.h"
#include "roomwise/base/stopwatch.h"
#include "roomwise/evaluation/statistics/quantile.h"
#include "roomwise/features/feature_extractor.h"
#include "roomwise/image/resample.h"
#include "roomwise/motion/motion_estimator.h"
#include "roomwise/pipeline/rooms/room_learning.h"
#include "roomwise/pipeline/stored/keyframe_images.h"
#include "roomwise/pipeline/stored/stored_rooms.h"

namespace roomwise::pipeline {
namespace {

constexpr int kHues = 16;
constexpr int kShades = 4;  // of saturation, and of value
constexpr int kMaxFeatures = 500;

// A key-frame that a room was learned from, and what each baseline compares.
struct Reference {
  home::Keyframe keyframe;
  std::string room;
  Eigen::VectorXf features;
  std::vector<float> histogram;
  std::optional<motion::MeasuredFeatures> points;  // of those that vote
};

// What a baseline says of a picture: each room's score, from which the best is named.
using Scores = std::map<std::string, double>;

Judgement top1_accuracy_of(std::size_t picture, const Scores& scores, std::string_view what) {
  Judgement judgement{picture, "", false, "not sure", 0, fmt::format("no {}", what)};
  for (const auto& [room, score] : scores) {
    if (judgement.best.empty() || score > judgement.score) {
      judgement.best = room;
      judgement.score = score;
    }
  }
  if (judgement.score > 0) {
    judgement.named = true;
    judgement.answer = judgement.best;
    judgement.why = fmt::format("{} {:.2f}", what, judgement.score);
  }
  return judgement;
}

// Which references vote: of each room some, spread evenly.
std::vector<bool> voters(const std::vector<Reference>& references, std::size_t most) {
  std::map<std::string, std::vector<std::size_t>> of_room;
  for (std::size_t i = 0; i < references.size(); ++i) of_room[references[i].room].push_back(i);
  std::vector<bool> votes(references.size(), false);
  for (const auto& [room, members] : of_room) {
    for (const std::size_t i : spread_evenly(members.size(), most)) votes[members[i]] = true;
  }
  return votes;
}

Expected<std::vector<Reference>> references_of(const home::Home& home,
                                               const RoomRecognizer& recognizer) {
  ROOMWISE_TRY(const auto learned, learned_keyframes(home));
  if (learned.empty()) {
    return fail(
        "{}: it is not known which key-frames its rooms were learned from; baselines need rooms "
        "that were learned from a recording, by rooms learn of this version",
        home.file());
  }
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  ROOMWISE_TRY(const auto networks, home.networks());
  std::map<home::KeyframeId, network::Prediction> predictions;
  for (const auto& [id, network] : networks) {
    if (network.fingerprint != recognizer.features().fingerprint()) continue;
    ROOMWISE_TRY(predictions, home.predictions(id));
  }
  ROOMWISE_TRY(const KeyframeRooms rooms, rooms_of_keyframes(home));
  std::vector<Reference> references;
  for (const home::Keyframe& keyframe : keyframes) {
    if (std::ranges::count(learned, keyframe.id) == 0) continue;
    const auto room = rooms.find(keyframe.id);
    const auto prediction = predictions.find(keyframe.id);
    if (room == rooms.end() || prediction == predictions.end()) continue;
    references.push_back(
        {keyframe, room->second, rooms::unit_length(prediction->second.features), {}, {}});
  }
  if (references.empty()) return fail("{}: the learned key-frames are gone", home.file());
  return references;
}

// Finds what the baselines compare in the references' images.
Expected<void> measure(const home::Home& home, std::vector<Reference>& references,
                       const BaselineOptions& options, RunContext& run) {
  const std::vector<bool> votes = voters(references, options.max_voted_keyframes);
  ROOMWISE_TRY(const auto cameras, recording_cameras(home));
  const auto sift = features::make_extractor(features::FeatureKind::kSift, kMaxFeatures);
  std::vector<home::Keyframe> keyframes;
  std::map<home::KeyframeId, std::size_t> place;
  for (std::size_t i = 0; i < references.size(); ++i) {
    keyframes.push_back(references[i].keyframe);
    place[references[i].keyframe.id] = i;
  }
  struct Measured {
    std::vector<float> histogram;
    std::optional<motion::MeasuredFeatures> points;
  };
  const auto make = [&](const home::Keyframe& keyframe, const DecodedImages& images) {
    Measured measured{color_histogram(images.color), {}};
    if (options.max_voted_pictures > 0 && votes[place.at(keyframe.id)]) {
      measured.points = motion::measure_features(sift->extract(image::to_gray(images.color)),
                                                 images.depth, cameras.at(keyframe.recording));
    }
    return measured;
  };
  const auto take = [&](const home::Keyframe& keyframe, Measured measured) -> Expected<void> {
    Reference& reference = references[place.at(keyframe.id)];
    reference.histogram = std::move(measured.histogram);
    reference.points = std::move(measured.points);
    return {};
  };
  return for_each_keyframe(home, keyframes, "measuring key-frames", run, make, take);
}

RuleResult by_colors(const std::vector<std::vector<float>>& histograms,
                     const std::vector<Reference>& references, const std::vector<double>& made_ms) {
  RuleResult result{"baseline_colors", "baseline: most alike colours (HSV)", {}, 0, {}};
  std::vector<double> ms;
  for (std::size_t i = 0; i < histograms.size(); ++i) {
    const Stopwatch watch;
    Scores scores;
    for (const Reference& reference : references) {
      double intersection = 0;
      for (std::size_t cell = 0; cell < histograms[i].size(); ++cell) {
        intersection += std::min(histograms[i][cell], reference.histogram[cell]);
      }
      scores[reference.room] = std::max(scores[reference.room], intersection);
    }
    result.judgements.push_back(top1_accuracy_of(i, scores, "colours in common"));
    ms.push_back(made_ms[i] + watch.ms());
  }
  result.median_ms = evaluation::quantile(ms, 0.5);
  return result;
}

RuleResult by_nearest(std::span<const std::vector<float>> features,
                      const std::vector<Reference>& references) {
  RuleResult result{
      "baseline_nearest", "baseline: nearest features (time without the network)", {}, 0, {}};
  std::vector<double> ms;
  for (std::size_t i = 0; i < features.size(); ++i) {
    const Stopwatch watch;
    const Eigen::VectorXf picture = rooms::unit_length(features[i]);
    Scores scores;
    for (const Reference& reference : references) {
      const double cosine = picture.dot(reference.features);
      scores[reference.room] = std::max(scores[reference.room], cosine);
    }
    result.judgements.push_back(top1_accuracy_of(i, scores, "cosine"));
    ms.push_back(watch.ms());
  }
  result.median_ms = evaluation::quantile(ms, 0.5);
  return result;
}

// The features of a picture without depth.
motion::MeasuredFeatures without_depth(features::Features features,
                                       const geometry::PinholeCamera& camera) {
  return motion::measure_features(std::move(features),
                                  image::DepthImage(camera.width, camera.height, 0), camera);
}

// Inliers of a picture's pose, added up by room.
Scores vote(const motion::MeasuredFeatures& points, const std::vector<Reference>& references,
            const geometry::PinholeCamera& camera, std::uint64_t picture) {
  Scores scores;
  for (const Reference& reference : references) {
    if (!reference.points) continue;
    const motion::MotionOutcome outcome = motion::estimate_motion(
        *reference.points, points, camera, {}, RandomStream(picture, {reference.keyframe.id}));
    if (outcome.found()) scores[reference.room] += outcome.inliers;
  }
  return scores;
}

Expected<RuleResult> by_vote(const std::vector<LabelledPicture>& pictures,
                             const std::vector<Reference>& references,
                             const geometry::PinholeCamera& camera, std::size_t most,
                             RunContext& run) {
  RuleResult result{"baseline_vote", "baseline: vote of SIFT features", {}, 0, {}};
  const auto chosen = spread_evenly(pictures.size(), most);
  const auto sift = features::make_extractor(features::FeatureKind::kSift, kMaxFeatures);
  std::vector<Expected<Judgement>> judged(chosen.size(), fail("not judged yet"));
  std::vector<double> ms(chosen.size());
  run.pool.parallel_for(chosen.size(), [&](std::size_t i) {
    judged[i] = [&]() -> Expected<Judgement> {
      ROOMWISE_TRY(const image::ColorImage color, pictures[chosen[i]].read());
      if (color.width() != camera.width || color.height() != camera.height) {
        return fail("{} is {}x{}, the map's camera takes {}x{}; leave the vote out",
                    pictures[chosen[i]].name, color.width(), color.height(), camera.width,
                    camera.height);
      }
      const Stopwatch watch;
      const auto points = without_depth(sift->extract(image::to_gray(color)), camera);
      Judgement judgement =
          top1_accuracy_of(chosen[i], vote(points, references, camera, chosen[i]), "inliers");
      ms[i] = watch.ms();
      return judgement;
    }();
  });
  for (auto& one : judged) {
    ROOMWISE_TRY(result.judgements.emplace_back(), std::move(one));
  }
  result.median_ms = evaluation::quantile(ms, 0.5);
  return result;
}

}  // namespace

std::vector<float> color_histogram(const image::ColorImage& picture) {
  std::vector<float> histogram(kHues * kShades * kShades, 0);
  const float each = 1.0F / static_cast<float>(std::max<std::size_t>(picture.pixels().size(), 1));
  for (const Rgb8& pixel : picture.pixels()) {
    const int high = std::max({pixel.r, pixel.g, pixel.b});
    const int low = std::min({pixel.r, pixel.g, pixel.b});
    const int range = high - low;
    double hue = 0;  // 0 to 6
    if (range > 0) {
      if (high == pixel.r) {
        hue = double(pixel.g - pixel.b) / range + (pixel.g < pixel.b ? 6 : 0);
      } else if (high == pixel.g) {
        hue = double(pixel.b - pixel.r) / range + 2;
      } else {
        hue = double(pixel.r - pixel.g) / range + 4;
      }
    }
    const int saturation = high == 0 ? 0 : 255 * range / high;
    const int hue_cell = std::min(kHues - 1, static_cast<int>(hue / 6 * kHues));
    const int cell =
        (hue_cell * kShades + saturation * kShades / 256) * kShades + high * kShades / 256;
    histogram[static_cast<std::size_t>(cell)] += each;
  }
  return histogram;
}

Expected<std::vector<RuleResult>> baseline_rules(const home::Home& home,
                                                 const std::vector<LabelledPicture>& pictures,
                                                 std::span<const std::vector<float>> features,
                                                 const RoomRecognizer& recognizer,
                                                 const BaselineOptions& options, RunContext& run) {
  ROOMWISE_TRY(std::vector<Reference> references, references_of(home, recognizer));
  ROOMWISE_RETURN_IF_ERROR(measure(home, references, options, run));
  std::vector<std::vector<float>> histograms;
  std::vector<double> ms;
  for (const LabelledPicture& picture : pictures) {
    ROOMWISE_TRY(const image::ColorImage color, picture.read());
    const Stopwatch watch;
    histograms.push_back(color_histogram(color));
    ms.push_back(watch.ms());
  }
  std::vector<RuleResult> results;
  results.push_back(by_colors(histograms, references, ms));
  results.push_back(by_nearest(features, references));
  if (options.max_voted_pictures > 0) {
    ROOMWISE_TRY(const auto cameras, recording_cameras(home));
    const auto& camera = cameras.at(references.front().keyframe.recording);
    ROOMWISE_TRY(results.emplace_back(),
                 by_vote(pictures, references, camera, options.max_voted_pictures, run));
  }
  return results;
}

}  // namespace roomwise::pipeline
