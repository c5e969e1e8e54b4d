#include "roomwise/pipeline/closer_looks.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <map>
#include <utility>
#include <vector>

#include "roomwise/pipeline/keyframe_images.h"
#include "roomwise/pipeline/stored_looks.h"

namespace roomwise::pipeline {
namespace {

// A view of a proposal, by its indices.
struct ViewPlace {
  std::size_t proposal = 0, view = 0;
};
// What a picture shows of a proposal.
struct SeenView {
  objects::WordScores said;
  objects::RegionSurface surface;
};

// The proposals of one piece of the map, and which key-frames show them best.
class PieceProposals {
 public:
  explicit PieceProposals(const std::vector<objects::LookedKeyframe>& keyframes)
      : keyframes_(&keyframes) {
    for (auto& proposal : objects::find_proposals(keyframes, objects::find_level(keyframes))) {
      objects::LookedProposal looked{std::move(proposal), {}, {}};
      looked.views = objects::best_views(looked.proposal, keyframes);
      looked.said.resize(looked.views.size());
      surfaces_.emplace_back(looked.views.size());
      for (std::size_t view = 0; view < looked.views.size(); ++view) {
        const objects::LookedKeyframe& keyframe = keyframes[looked.views[view].keyframe];
        views_of_keyframe_[keyframe.keyframe_id].push_back({looked_.size(), view});
      }
      looked_.push_back(std::move(looked));
    }
  }

  [[nodiscard]] const std::map<home::KeyframeId, std::vector<ViewPlace>>& views_of_keyframe()
      const {
    return views_of_keyframe_;
  }

  // What a key-frame's images show, in the order of its views.
  [[nodiscard]] Expected<std::vector<SeenView>> look(home::KeyframeId keyframe,
                                                     const DecodedImages& images,
                                                     const objects::ProposalNamer& namer) const {
    std::vector<SeenView> seen;
    for (const ViewPlace& place : views_of_keyframe_.at(keyframe)) {
      const objects::LookedProposal& looked = looked_[place.proposal];
      const objects::ProposalView& view = looked.views[place.view];
      const objects::LookedKeyframe& from = (*keyframes_)[view.keyframe];
      const geometry::OrientedBox& box = looked.proposal.box_world;
      SeenView& one = seen.emplace_back();
      ROOMWISE_TRY(one.said, namer.look(images.color, view.box));
      one.surface = objects::surface_within(
          images.depth, *from.camera, view.box,
          {from.world_from_camera.inverse() * box.world_from_box, box.size_m});
    }
    return seen;
  }
  void keep(home::KeyframeId keyframe, std::vector<SeenView> seen) {
    const std::vector<ViewPlace>& places = views_of_keyframe_.at(keyframe);
    for (std::size_t i = 0; i < places.size(); ++i) {
      looked_[places[i].proposal].said[places[i].view] = std::move(seen[i].said);
      surfaces_[places[i].proposal][places[i].view] = std::move(seen[i].surface);
    }
  }

  // Of each key-frame that shows a proposal with a name.
  [[nodiscard]] std::map<home::KeyframeId, std::vector<objects::Region>> regions() const {
    static const std::map<std::string, std::string> labels = objects::labels_of_proposals();
    std::map<home::KeyframeId, std::vector<objects::Region>> regions;
    for (const objects::ProposalName& named : objects::name_proposals(looked_)) {
      const objects::LookedProposal& looked = looked_[named.proposal];
      for (std::size_t view = 0; view < looked.views.size(); ++view) {
        const home::KeyframeId id = (*keyframes_)[looked.views[view].keyframe].keyframe_id;
        regions[id].push_back({labels.at(named.word), static_cast<float>(named.score),
                               looked.views[view].box, surfaces_[named.proposal][view],
                               objects::RegionSource::kProposal});
      }
    }
    for (auto& [id, of_keyframe] : regions) {
      std::ranges::stable_sort(of_keyframe, std::greater{}, &objects::Region::score);
    }
    return regions;
  }

 private:
  const std::vector<objects::LookedKeyframe>* keyframes_;
  std::vector<objects::LookedProposal> looked_;
  std::vector<std::vector<objects::RegionSurface>> surfaces_;  // by proposal and view
  std::map<home::KeyframeId, std::vector<ViewPlace>> views_of_keyframe_;
};

// Fails as for_each_keyframe() does.
Expected<void> look_at_proposals(PieceProposals& proposals, const home::Home& home,
                                 const std::vector<home::Keyframe>& keyframes,
                                 const objects::ProposalNamer& namer, RunContext& run) {
  std::vector<home::Keyframe> shown;
  std::ranges::copy_if(keyframes, std::back_inserter(shown), [&](const home::Keyframe& one) {
    return proposals.views_of_keyframe().contains(one.id);
  });
  if (shown.empty()) return {};
  using Seen = Expected<std::vector<SeenView>>;
  return for_each_keyframe(
      home, shown, "looking closer", run,
      [&](const home::Keyframe& keyframe, const DecodedImages& images) -> Seen {
        const auto timing = run.clock.measure("closer looks");
        return proposals.look(keyframe.id, images, namer);
      },
      [&](const home::Keyframe& keyframe, Seen seen) -> Expected<void> {
        if (!seen) return Unexpected(std::move(seen).error());
        proposals.keep(keyframe.id, *std::move(seen));
        return {};
      });
}

// All closer looks are one finder, whatever networks take part: each time they are made they take
// the place of the last ones, so that nothing of other networks or other poses stays.
home::RegionFinderRecord finder_record() {
  home::RegionFinderRecord record{.name = "closer looks", .fingerprint = {}, .labels = {}};
  for (const auto& [word, label] : objects::labels_of_proposals()) record.labels.push_back(label);
  record.fingerprint =
      fmt::format("{}1: {}", objects::kProposalMethod, fmt::join(record.labels, ", "));
  return record;
}

}  // namespace

Expected<bool> look_closer(home::Home& home, const objects::ProposalNamer& namer, RunContext& run) {
  ROOMWISE_TRY(const StoredLooks looks, StoredLooks::read(home));
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  std::map<home::KeyframeId, objects::KeyframeLook> closer;
  for (const auto& [piece, looked] : looks.pieces()) {
    if (run.progress.interrupted()) return false;
    PieceProposals proposals = [&] {
      const auto timing = run.clock.measure("what stands apart");
      return PieceProposals(looked);
    }();
    const Expected<void> seen_all = look_at_proposals(proposals, home, keyframes, namer, run);
    if (run.progress.interrupted()) return false;
    ROOMWISE_CHECK_OK(seen_all);
    auto regions = proposals.regions();
    for (const objects::LookedKeyframe& keyframe : looked) {
      closer[keyframe.keyframe_id] = {*keyframe.coarse_depth,
                                      std::move(regions[keyframe.keyframe_id])};
    }
  }
  ROOMWISE_CHECK_OK(home.atomically([&]() -> Expected<void> {
    ROOMWISE_TRY(const home::FinderId finder, home.add_region_finder(finder_record()));
    for (const auto& [id, look] : closer) {
      ROOMWISE_CHECK_OK(home.put_look(id, finder, look));
    }
    return {};
  }));
  return true;
}

}  // namespace roomwise::pipeline
