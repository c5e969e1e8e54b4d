#pragma once

#include <map>
#include <string>
#include <vector>

#include "laboratory/trials/own_things/trial_things.h"
#include "roomwise/evaluation/statistics/proportion.h"
#include "roomwise/network/vision/classifier.h"
#include "roomwise/objects/own_things/own_thing_finder.h"

// Things that are taught, found again: the model is fitted and measured with each recording left
// out in its turn, beside the naive way and the detector of the nearest label.
namespace roomwise::trials {

struct OwnThingsOptions {
  std::size_t views = 6;         // by which a thing is known, at most
  double max_false_an_hour = 1;  // of walking, for each thing; one picture a second is looked at
  double weight_penalty = 1;     // ridge, of standardised likenesses
};

// How one thing compares with one picture.
struct ComparedPlace {
  objects::MatchFeatures likeness{};
  double overlap = 0;  // with the truth, intersection over union; 0 where it is not there
};
struct ComparedPicture {
  std::vector<ComparedPlace> places;
  double label_score = 0;    // of the detector's boxes of the thing's label, the best
  double label_overlap = 0;  // of that box
};
// A half of a walk that does not show the thing.
struct ComparedWalk {
  std::size_t walk = 0;  // index into TrialSet::walks
  bool is_second_half = false;
  std::vector<ComparedPicture> pictures;
};
struct ComparedThing {
  std::string name, recording;
  TrialGroup group = TrialGroup::kRecorded;
  std::size_t shown = 0, refused = 0;  // pictures; of these, those that show nothing to learn from
  std::string label;                   // of the detector, empty: it named none of what was shown
  std::vector<ComparedPicture> home, tests;
  std::vector<ComparedWalk> absent;

  [[nodiscard]] bool was_taught() const { return refused < shown; }
};

// Time: most of it the network's, see OwnThingSearch.
[[nodiscard]] Expected<std::vector<ComparedThing>> compare_own_things(
    const TrialSet& set, const network::Classifier& network,
    const objects::DetectionFinders& detectors, const OwnThingsOptions& options, ThreadPool& pool,
    Progress& progress);

// A line of JSON each, to fit again without the networks, and back.
[[nodiscard]] std::string to_json_line(const ComparedThing& thing);
[[nodiscard]] Expected<std::vector<ComparedThing>> read_compared_things(
    const std::filesystem::path& file);

// On the things of the other recordings, and first halves of walks; `left_out` empty: on all.
[[nodiscard]] objects::OwnThingModel fit_own_things(std::span<const ComparedThing> things,
                                                    const std::string& left_out,
                                                    const OwnThingsOptions& options);

// What a way of finding did.
struct FindingResult {
  evaluation::Proportion found;  // pictures of the thing: found, and there
  std::uint64_t elsewhere = 0;   // found in a picture of it, but not there
  std::uint64_t alarms = 0;      // in pictures without it; those a few seconds apart are one
  double walked_h = 0;           // without it
};
struct OwnThingsResult {
  // By group and way: "fitted", "naive", "label".
  std::map<std::pair<TrialGroup, std::string>, FindingResult> by_group;
  std::map<std::string, FindingResult> by_thing;  // fitted
  evaluation::Proportion reachable;               // tests with any place that overlaps
};
[[nodiscard]] OwnThingsResult measure_own_things(std::span<const ComparedThing> things,
                                                 const OwnThingsOptions& options);

}  // namespace roomwise::trials
