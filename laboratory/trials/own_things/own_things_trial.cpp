#include "laboratory/trials/own_things/own_things_trial.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "laboratory/trials/logistic_regression.h"
#include "roomwise/base/file.h"
#include "roomwise/base/median.h"
#include "roomwise/image/codec.h"

namespace roomwise::trials {
namespace {

constexpr double kThere = 0.25;      // overlap from which on it is found where it is
constexpr double kLearnedAs = 0.4;   // from which on a place counts as the thing when fitting
constexpr double kLearnedNot = 0.1;  // below which it counts as another
constexpr std::size_t kOneAlarm_s = 5;
constexpr double kNever = 1e12;

// Pictures that are compared with several things.
struct Job {
  const Bytes* picture = nullptr;
  struct Ask {
    std::size_t thing = 0;
    network::PixelBox truth;  // of no area: it is not there
    ComparedPicture* result = nullptr;
  };
  std::vector<Ask> asks;
};

struct TaughtThing {
  objects::PreparedThing prepared;
  std::size_t refused = 0;
  std::string label;
};

// What the detectors call what is shown: the label with most score over boxes that hold the middle.
Expected<std::string> label_of_shown(std::span<const image::ColorImage> pictures,
                                     const objects::DetectionFinders& detectors) {
  std::map<std::string, double> scores;
  for (const image::ColorImage& picture : pictures) {
    const auto middle_x = static_cast<float>(picture.width()) / 2;
    const auto middle_y = static_cast<float>(picture.height()) / 2;
    for (const auto& detector : detectors) {
      ROOMWISE_TRY(const auto found, detector->find(picture));
      for (const network::Detection& one : found) {
        const bool holds_middle = one.box.left < middle_x && one.box.right > middle_x &&
                                  one.box.top < middle_y && one.box.bottom > middle_y;
        if (holds_middle) scores[detector->labels()[one.label]] += static_cast<double>(one.score);
      }
    }
  }
  if (scores.empty()) return std::string();
  return std::ranges::max_element(scores, {}, [](const auto& one) { return one.second; })->first;
}

Expected<TaughtThing> teach(const TrialThing& thing, const objects::OwnThingFinder& finder,
                            const objects::DetectionFinders& detectors,
                            const OwnThingsOptions& options) {
  TaughtThing taught;
  std::vector<objects::ShownThing> shown;
  std::vector<image::ColorImage> pictures;
  for (const Bytes& bytes : thing.shown) {
    ROOMWISE_TRY(image::ColorImage picture, image::decode_color(bytes));
    auto found = objects::find_shown(picture);
    pictures.push_back(std::move(picture));
    if (found) {
      shown.push_back(*std::move(found));
    } else {
      ++taught.refused;
    }
  }
  ROOMWISE_TRY(taught.label, label_of_shown(pictures, detectors));
  if (shown.empty()) return taught;
  ROOMWISE_TRY(const auto chosen, finder.choose_views(shown, options.views));
  std::vector<objects::TaughtView> views;
  for (const std::size_t i : chosen) views.push_back(objects::taught_view(shown[i]));
  ROOMWISE_TRY(taught.prepared, finder.prepare(views));
  return taught;
}

// The best box of a label.
void note_label(const objects::SearchedPicture& picture, const std::string& label,
                const std::vector<std::string>& labels, const network::PixelBox& truth, float back,
                ComparedPicture& result) {
  for (const network::Detection& one : picture.detections()) {
    if (one.label >= labels.size() || labels[one.label] != label) continue;
    result.label_score = static_cast<double>(one.score);
    const network::PixelBox box{one.box.left * back, one.box.top * back, one.box.right * back,
                                one.box.bottom * back};
    result.label_overlap = static_cast<double>(network::intersection_over_union(box, truth));
    return;
  }
}

// Rows to fit on: of each thing what it is and what it is not weigh the same.
struct FitRows {
  std::vector<objects::MatchFeatures> likeness;
  std::vector<double> is_thing, weight;

  void add(const std::vector<objects::MatchFeatures>& some, bool is, double weight_of_all) {
    for (const objects::MatchFeatures& one : some) {
      likeness.push_back(one);
      is_thing.push_back(is ? 1 : 0);
      weight.push_back(weight_of_all / static_cast<double>(some.size()));
    }
  }
};

FitRows rows_of(std::span<const ComparedThing> things, const std::string& left_out) {
  FitRows rows;
  for (const ComparedThing& thing : things) {
    if (thing.recording == left_out || !thing.was_taught()) continue;
    std::vector<objects::MatchFeatures> is, is_not;
    for (const ComparedPicture& picture : thing.tests) {
      for (const ComparedPlace& place : picture.places) {
        if (place.overlap >= kLearnedAs) is.push_back(place.likeness);
        if (place.overlap < kLearnedNot) is_not.push_back(place.likeness);
      }
    }
    for (const ComparedWalk& walk : thing.absent) {
      if (walk.is_second_half) continue;
      for (const ComparedPicture& picture : walk.pictures) {
        for (const ComparedPlace& place : picture.places) is_not.push_back(place.likeness);
      }
    }
    if (is.empty() || is_not.empty()) continue;
    constexpr double kRowsOfAThing = 20;  // as many as it has that are independent, about
    rows.add(is, true, kRowsOfAThing);
    rows.add(is_not, false, kRowsOfAThing);
  }
  return rows;
}

// What a way of finding says of a picture: how sure it is, and whether it is right.
struct Said {
  double score = 0;
  double overlap = 0;
};
using Way = std::function<Said(const ComparedPicture&)>;

template <typename Score>
Way best_place(Score score) {
  return [score](const ComparedPicture& picture) {
    Said best{-1e9, 0};
    for (const ComparedPlace& place : picture.places) {
      const double one = score(place.likeness);
      if (one > best.score) best = {one, place.overlap};
    }
    return best;
  };
}

std::vector<double> scores_of(std::span<const ComparedPicture> pictures, const Way& way) {
  std::vector<double> scores;
  for (const ComparedPicture& picture : pictures) scores.push_back(way(picture).score);
  return scores;
}

void count(const ComparedThing& thing, const Way& way, double threshold, FindingResult& result) {
  for (const ComparedPicture& picture : thing.tests) {
    const Said said = way(picture);
    const bool is_found = said.score >= threshold;
    result.found.add(is_found && said.overlap >= kThere);
    if (is_found && said.overlap < kThere) ++result.elsewhere;
  }
  for (const auto& [walk, is_second_half, pictures] : thing.absent) {
    if (!is_second_half) continue;  // what looks like nothing was fitted on first halves
    std::optional<std::size_t> last;
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      if (way(pictures[i]).score < threshold) continue;
      if (!last || i - *last > kOneAlarm_s) ++result.alarms;
      last = i;
    }
    result.walked_h += static_cast<double>(pictures.size()) / 3600;
  }
}

// One threshold for all things of other recordings, with as many alarms as are allowed, at most.
double naive_threshold(std::span<const ComparedThing> things, const std::string& left_out,
                       const Way& way, double max_false) {
  std::vector<double> scores;
  for (const ComparedThing& thing : things) {
    if (thing.recording == left_out || !thing.was_taught()) continue;
    for (const ComparedWalk& walk : thing.absent) {
      if (walk.is_second_half) continue;
      std::ranges::copy(scores_of(walk.pictures, way), std::back_inserter(scores));
    }
  }
  if (scores.empty()) return kNever;
  std::ranges::sort(scores, std::ranges::greater{});
  return scores[static_cast<std::size_t>(max_false * static_cast<double>(scores.size()))];
}

Way by_model(const objects::OwnThingModel& model) {
  return best_place(
      [model](const objects::MatchFeatures& likeness) { return model.log_odds(likeness); });
}

// What is usual in the thing's home, by a way of scoring.
double usual_score(const ComparedThing& thing, const Way& way) {
  std::vector<double> scores = scores_of(thing.home, way);
  return scores.empty() ? 0 : median_of(scores);
}

// The margin above it with as many false alarms as are allowed, at most.
double fitted_margin(std::span<const ComparedThing> things, const std::string& left_out,
                     const Way& way, double max_false) {
  std::vector<double> above;
  for (const ComparedThing& thing : things) {
    if (thing.recording == left_out || !thing.was_taught()) continue;
    const double usual = usual_score(thing, way);
    for (const ComparedWalk& walk : thing.absent) {
      if (walk.is_second_half && !left_out.empty()) continue;
      for (const double score : scores_of(walk.pictures, way)) above.push_back(score - usual);
    }
  }
  if (above.empty()) return 0;
  std::ranges::sort(above, std::ranges::greater{});
  return above[static_cast<std::size_t>(max_false * static_cast<double>(above.size()))];
}

}  // namespace

Expected<std::vector<ComparedThing>> compare_own_things(const TrialSet& set,
                                                        const network::Classifier& network,
                                                        const objects::DetectionFinders& detectors,
                                                        const OwnThingsOptions& options,
                                                        ThreadPool& pool, Progress& progress) {
  // What each home's places have in common.
  std::map<std::vector<std::size_t>, std::unique_ptr<objects::OwnThingFinder>> finders;
  const auto& model = objects::OwnThingModel::built_in();
  const objects::OwnThingFinder plain(network, detectors, {}, model);
  std::vector<const objects::OwnThingFinder*> finder_of;
  for (const TrialThing& thing : set.things) {
    auto& finder = finders[thing.home];
    if (finder == nullptr) {
      std::vector<const Bytes*> pictures;
      for (const std::size_t walk : thing.home) {
        for (const Bytes& picture : set.walks[walk].pictures) pictures.push_back(&picture);
      }
      std::vector<std::vector<std::vector<float>>> seen(pictures.size());
      pool.parallel_for(pictures.size(), [&](std::size_t i) {
        const auto picture = image::decode_color(*pictures[i]);
        if (!picture) return;
        if (auto features = plain.place_features(*picture)) seen[i] = *std::move(features);
      });
      std::vector<std::vector<float>> all;
      for (auto& some : seen) std::ranges::move(some, std::back_inserter(all));
      finder = std::make_unique<objects::OwnThingFinder>(network, detectors,
                                                         objects::background_of(all), model);
    }
    finder_of.push_back(finder.get());
  }
  std::vector<TaughtThing> taught(set.things.size());
  std::vector<ComparedThing> results(set.things.size());
  for (std::size_t i = 0; i < set.things.size(); ++i) {
    const TrialThing& thing = set.things[i];
    ROOMWISE_TRY(taught[i], teach(thing, *finder_of[i], detectors, options));
    results[i] = {thing.name,
                  thing.recording,
                  thing.group,
                  thing.shown.size(),
                  taught[i].refused,
                  taught[i].label,
                  {},
                  {},
                  {}};
    results[i].tests.resize(thing.tests.size());
    for (const std::size_t walk : thing.absent) {
      results[i].absent.push_back({walk, set.walks[walk].is_second_half,
                                   std::vector<ComparedPicture>(set.walks[walk].pictures.size())});
    }
    std::size_t of_home = 0;
    for (const std::size_t walk : thing.home) of_home += set.walks[walk].pictures.size();
    results[i].home.resize(of_home);
  }
  std::vector<Job> jobs;
  for (std::size_t walk = 0; walk < set.walks.size(); ++walk) {
    for (std::size_t p = 0; p < set.walks[walk].pictures.size(); ++p) {
      Job job{&set.walks[walk].pictures[p], {}};
      for (std::size_t i = 0; i < set.things.size(); ++i) {
        std::size_t before = 0;
        for (const std::size_t home : set.things[i].home) {
          if (home == walk) job.asks.push_back({i, {}, &results[i].home[before + p]});
          before += set.walks[home].pictures.size();
        }
        for (auto& [absent, is_second_half, pictures] : results[i].absent) {
          if (absent == walk) job.asks.push_back({i, {}, &pictures[p]});
        }
      }
      jobs.push_back(std::move(job));
    }
  }
  for (std::size_t i = 0; i < set.things.size(); ++i) {
    for (std::size_t t = 0; t < set.things[i].tests.size(); ++t) {
      const TrialPicture& test = set.things[i].tests[t];
      jobs.push_back({&test.picture, {{i, test.box, &results[i].tests[t]}}});
    }
  }
  const std::vector<std::string> labels =
      detectors.empty() ? std::vector<std::string>{} : detectors.front()->labels();
  progress.begin("comparing pictures", jobs.size());
  std::vector<Expected<void>> outcomes(jobs.size());
  std::atomic<std::uint64_t> done{0};
  pool.parallel_for(jobs.size(), [&](std::size_t j) {
    outcomes[j] = [&]() -> Expected<void> {
      if (progress.interrupted()) return fail_with(ErrorCode::kInterrupted, "interrupted");
      ROOMWISE_TRY(const image::ColorImage picture, image::decode_color(*jobs[j].picture));
      ROOMWISE_TRY(objects::SearchedPicture searched, plain.begin(picture));
      for (const Job::Ask& ask : jobs[j].asks) {
        const std::span<const objects::PreparedThing> thing(&taught[ask.thing].prepared, 1);
        ROOMWISE_TRY(const auto places, finder_of[ask.thing]->compare(searched, thing));
        for (const objects::OwnThingCandidate& one : places) {
          ask.result->places.push_back(
              {one.likeness,
               static_cast<double>(network::intersection_over_union(one.box, ask.truth))});
        }
        const float back = std::max(1.F, static_cast<float>(picture.width()) / 640);
        note_label(searched, taught[ask.thing].label, labels, ask.truth, back, *ask.result);
      }
      return {};
    }();
    ++done;
    if (j % 8 == 0) progress.advance(done, "");
  });
  progress.end();
  for (const Expected<void>& outcome : outcomes) ROOMWISE_RETURN_IF_ERROR(outcome);
  return results;
}

objects::OwnThingModel fit_own_things(std::span<const ComparedThing> things,
                                      const std::string& left_out,
                                      const OwnThingsOptions& options) {
  const FitRows rows = rows_of(things, left_out);
  const auto count = static_cast<Eigen::Index>(rows.likeness.size());
  constexpr auto kColumns = static_cast<Eigen::Index>(objects::kMatchFeatures);
  Eigen::MatrixXd values(count, kColumns + 1);
  Eigen::VectorXd is_thing(count), weight(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto row = static_cast<std::size_t>(i);
    for (Eigen::Index c = 0; c < kColumns; ++c) {
      values(i, c) = rows.likeness[row][static_cast<std::size_t>(c)];
    }
    values(i, kColumns) = 1;
    is_thing[i] = rows.is_thing[row];
    weight[i] = rows.weight[row];
  }
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(kColumns + 1);
  Eigen::VectorXd spread = Eigen::VectorXd::Ones(kColumns + 1);
  for (Eigen::Index c = 0; c < kColumns && count > 0; ++c) {
    mean[c] = values.col(c).mean();
    const double variance = (values.col(c).array() - mean[c]).square().mean();
    spread[c] = variance > 0 ? std::sqrt(variance) : 1;
    values.col(c) = (values.col(c).array() - mean[c]) / spread[c];
  }
  Eigen::VectorXd penalty = Eigen::VectorXd::Constant(kColumns + 1, options.weight_penalty);
  penalty[kColumns] = 1e-6;
  objects::OwnThingModel model;
  if (count == 0) return model;
  const Eigen::VectorXd weights = logistic_regression(values, is_thing, weight, penalty);
  model.bias = weights[kColumns];
  for (Eigen::Index c = 0; c < kColumns; ++c) {
    model.weights[static_cast<std::size_t>(c)] = weights[c] / spread[c];
    model.bias -= weights[c] * mean[c] / spread[c];
  }
  const Way fitted = by_model(model);
  model.margin = fitted_margin(things, left_out, fitted, options.max_false_an_hour / 3600);
  return model;
}

OwnThingsResult measure_own_things(std::span<const ComparedThing> things,
                                   const OwnThingsOptions& options) {
  OwnThingsResult result;
  const double max_false = options.max_false_an_hour / 3600;
  const Way naive = best_place([](const objects::MatchFeatures& likeness) { return likeness[0]; });
  const Way label = [](const ComparedPicture& picture) {
    return Said{picture.label_score, picture.label_overlap};
  };
  std::set<std::string> recordings;
  for (const ComparedThing& thing : things) recordings.insert(thing.recording);
  for (const std::string& recording : recordings) {
    const objects::OwnThingModel model = fit_own_things(things, recording, options);
    const Way fitted = best_place(
        [model](const objects::MatchFeatures& likeness) { return model.log_odds(likeness); });
    const double of_naive = naive_threshold(things, recording, naive, max_false);
    for (const ComparedThing& thing : things) {
      if (thing.recording != recording) continue;
      for (const ComparedPicture& picture : thing.tests) {
        result.reachable.add(std::ranges::any_of(
            picture.places, [](const ComparedPlace& place) { return place.overlap >= kThere; }));
      }
      // Of what was refused whenever it was shown nothing is known, and nothing found.
      const double of_fitted =
          thing.was_taught() ? usual_score(thing, fitted) + model.margin : kNever;
      count(thing, fitted, of_fitted, result.by_group[{thing.group, "fitted"}]);
      count(thing, fitted, of_fitted, result.by_thing[thing.recording + ": " + thing.name]);
      count(thing, naive, thing.was_taught() ? of_naive : kNever,
            result.by_group[{thing.group, "naive"}]);
      constexpr double kUsualScore = 0.5;
      count(thing, label, kUsualScore, result.by_group[{thing.group, "label"}]);
    }
  }
  return result;
}

std::string to_json_line(const ComparedThing& thing) {
  const auto pictures = [](std::span<const ComparedPicture> some) {
    nlohmann::json list = nlohmann::json::array();
    for (const ComparedPicture& picture : some) {
      nlohmann::json places = nlohmann::json::array();
      for (const ComparedPlace& place : picture.places) {
        nlohmann::json numbers = place.likeness;
        numbers.push_back(place.overlap);
        places.push_back(std::move(numbers));
      }
      list.push_back({{"places", std::move(places)},
                      {"label_score", picture.label_score},
                      {"label_overlap", picture.label_overlap}});
    }
    return list;
  };
  nlohmann::json json{{"name", thing.name},
                      {"recording", thing.recording},
                      {"group", static_cast<int>(thing.group)},
                      {"shown", thing.shown},
                      {"refused", thing.refused},
                      {"label", thing.label},
                      {"home", pictures(thing.home)},
                      {"tests", pictures(thing.tests)},
                      {"absent", nlohmann::json::array()}};
  for (const auto& [walk, is_second_half, some] : thing.absent) {
    json["absent"].push_back({walk, is_second_half, pictures(some)});
  }
  return json.dump() + "\n";
}

Expected<std::vector<ComparedThing>> read_compared_things(const std::filesystem::path& file) {
  ROOMWISE_TRY(const std::string text, read_text_file(file));
  std::vector<ComparedThing> things;
  std::istringstream lines(text);
  const auto pictures = [](const nlohmann::json& list) {
    std::vector<ComparedPicture> some;
    for (const auto& one : list) {
      ComparedPicture& picture = some.emplace_back();
      one.at("label_score").get_to(picture.label_score);
      one.at("label_overlap").get_to(picture.label_overlap);
      for (const auto& numbers : one.at("places")) {
        ComparedPlace& place = picture.places.emplace_back();
        for (std::size_t i = 0; i < objects::kMatchFeatures; ++i)
          numbers.at(i).get_to(place.likeness[i]);
        numbers.at(objects::kMatchFeatures).get_to(place.overlap);
      }
    }
    return some;
  };
  std::size_t number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    try {
      const auto json = nlohmann::json::parse(line);
      ComparedThing& thing = things.emplace_back();
      json.at("name").get_to(thing.name);
      json.at("recording").get_to(thing.recording);
      thing.group = static_cast<TrialGroup>(json.at("group").get<int>());
      json.at("shown").get_to(thing.shown);
      json.at("refused").get_to(thing.refused);
      json.at("label").get_to(thing.label);
      thing.home = pictures(json.at("home"));
      thing.tests = pictures(json.at("tests"));
      for (const auto& walk : json.at("absent")) {
        thing.absent.push_back(
            {walk.at(0).get<std::size_t>(), walk.at(1).get<bool>(), pictures(walk.at(2))});
      }
    } catch (const nlohmann::json::exception& error) {
      return fail("{}:{}: {}", file.string(), number, error.what());
    }
  }
  return things;
}

}  // namespace roomwise::trials
