#include "roomwise/mapping/bundle/feature_tracks.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace roomwise::mapping {
namespace {

bool share_a_keyframe(const FeatureTrack& a, const FeatureTrack& b) {
  auto in_b = b.begin();
  for (const FeatureId& feature : a) {
    while (in_b != b.end() && in_b->keyframe < feature.keyframe) ++in_b;
    if (in_b == b.end()) return false;
    if (in_b->keyframe == feature.keyframe) return true;
  }
  return false;
}

// Which track each feature is in: union-find, with the tracks at the roots.
class Tracks {
 public:
  explicit Tracks(std::span<const std::size_t> sizes) {
    std::size_t features = 0;
    for (const std::size_t size : sizes) {
      first_.push_back(static_cast<std::uint32_t>(features));
      features += size;
    }
    parent_.resize(features);
    for (std::uint32_t i = 0; i < features; ++i) parent_[i] = i;
    tracks_.resize(features);
  }

  void join(const FeatureMatch& match) {
    std::uint32_t a = root_of(match.a);
    std::uint32_t b = root_of(match.b);
    if (a == b) return;
    if (tracks_[a].empty()) tracks_[a] = {match.a};
    if (tracks_[b].empty()) tracks_[b] = {match.b};
    if (share_a_keyframe(tracks_[a], tracks_[b])) return;
    if (tracks_[a].size() < tracks_[b].size()) std::swap(a, b);
    FeatureTrack joined;
    std::ranges::merge(tracks_[a], tracks_[b], std::back_inserter(joined));
    tracks_[a] = std::move(joined);
    FeatureTrack().swap(tracks_[b]);
    parent_[b] = a;
  }

  std::vector<FeatureTrack> take() {
    std::erase_if(tracks_, [](const FeatureTrack& track) { return track.size() < 2; });
    std::ranges::sort(tracks_);
    return std::move(tracks_);
  }

 private:
  std::uint32_t root_of(const FeatureId& feature) {
    std::uint32_t at = first_[feature.keyframe] + feature.index;
    while (parent_[at] != at) at = parent_[at] = parent_[parent_[at]];
    return at;
  }

  std::vector<std::uint32_t> first_;  // by key-frame: its first feature's number
  std::vector<std::uint32_t> parent_;
  std::vector<FeatureTrack> tracks_;  // by feature; empty where it is alone or no root
};

}  // namespace

std::vector<FeatureTrack> join_tracks(std::span<const std::size_t> sizes,
                                      std::vector<FeatureMatch> matches) {
  std::ranges::stable_sort(matches, {}, &FeatureMatch::distance);
  Tracks tracks(sizes);
  for (const FeatureMatch& match : matches) tracks.join(match);
  return tracks.take();
}

}  // namespace roomwise::mapping
