#include "laboratory/labelling/recording_truth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "roomwise/base/file.h"

namespace roomwise::labelling {
namespace {

using Json = nlohmann::ordered_json;
using Eigen::Vector3d;

constexpr double kMinReach_m = 0.15;

double rounded(double value) {
  constexpr double kUnits = 1e4;  // tenths of a millimetre, so that files stay readable
  return std::round(value * kUnits) / kUnits;
}

Json as_json(const TrueThing& thing) {
  const Vector3d& center = thing.box_world.center();
  const Vector3d& size = thing.box_world.size_m;
  const Eigen::Quaterniond& rotation = thing.box_world.world_from_box.rotation;
  return {{"name", thing.name},
          {"also_called", thing.also_called},
          {"center", {rounded(center.x()), rounded(center.y()), rounded(center.z())}},
          {"size", {rounded(size.x()), rounded(size.y()), rounded(size.z())}},
          {"rotation_xyzw",
           {rounded(rotation.x()), rounded(rotation.y()), rounded(rotation.z()),
            rounded(rotation.w())}},
          {"sigma_m", rounded(thing.sigma_m)},
          {"readers", thing.readers},
          {"sides", thing.sides},
          {"views", thing.views},
          {"note", thing.note},
          {"expected", thing.is_expected}};
}

Expected<TrueThing> true_thing_from(const Json& json) {
  TrueThing thing;
  json.at("name").get_to(thing.name);
  json.at("also_called").get_to(thing.also_called);
  const auto center = json.at("center").get<std::array<double, 3>>();
  const auto size = json.at("size").get<std::array<double, 3>>();
  const auto turn = json.at("rotation_xyzw").get<std::array<double, 4>>();
  const Eigen::Quaterniond rotation(turn[3], turn[0], turn[1], turn[2]);
  if (!(std::abs(rotation.norm() - 1) < 0.01)) return fail("{}: no rotation", thing.name);
  if (!(std::ranges::min(size) > 0)) return fail("{}: a size that is not positive", thing.name);
  thing.box_world = {{rotation.normalized(), Vector3d(center[0], center[1], center[2])},
                     {size[0], size[1], size[2]}};
  json.at("sigma_m").get_to(thing.sigma_m);
  json.at("readers").get_to(thing.readers);
  json.at("sides").get_to(thing.sides);
  json.at("views").get_to(thing.views);
  json.at("note").get_to(thing.note);
  json.at("expected").get_to(thing.is_expected);
  return thing;
}

TrueThing of_one(const LabelledThing& label, const LiftedThing& lifted, const std::string& reader) {
  return {.name = label.name,
          .also_called = {},
          .box_world = lifted.box_world,
          .sigma_m = lifted.sigma_m,
          .readers = {reader},
          .sides = {label.sides.begin(), label.sides.end()},
          .views = label.views.size(),
          .note = label.note};
}

// The mark of a second reader is taken into that of the first.
void join(TrueThing& thing, const TrueThing& other) {
  const double of_first = 1 / (thing.sigma_m * thing.sigma_m);
  const double of_second = 1 / (other.sigma_m * other.sigma_m);
  Vector3d& middle = thing.box_world.world_from_box.translation;
  middle = (of_first * middle + of_second * other.box_world.center()) / (of_first + of_second);
  thing.sigma_m = 1 / std::sqrt(of_first + of_second);
  if (other.name != thing.name) thing.also_called.insert(other.name);
  thing.readers.insert(other.readers.begin(), other.readers.end());
  thing.sides.insert(other.sides.begin(), other.sides.end());
  thing.views += other.views;
}

struct Pair {
  double distance_m = 0;
  std::size_t first = 0, second = 0;
};

// Pairs of marks that may be one thing, the nearest first.
template <typename MayBeOne>
std::vector<Pair> near_pairs(std::span<const TrueThing> first, std::span<const TrueThing> second,
                             double of_size, const MayBeOne& may_be_one) {
  std::vector<Pair> pairs;
  for (std::size_t a = 0; a < first.size(); ++a) {
    for (std::size_t b = 0; b < second.size(); ++b) {
      if (!may_be_one(first[a], second[b])) continue;
      const double size_m =
          0.5 * (first[a].box_world.size_m.maxCoeff() + second[b].box_world.size_m.maxCoeff());
      const double distance_m = (first[a].box_world.center() - second[b].box_world.center()).norm();
      if (distance_m <= std::max(kMinReach_m, of_size * size_m))
        pairs.push_back({distance_m, a, b});
    }
  }
  std::ranges::sort(pairs, {}, [](const Pair& pair) {
    return std::tuple(pair.distance_m, pair.first, pair.second);
  });
  return pairs;
}

// With whether each name is sure.
struct Marks {
  std::vector<TrueThing> things;
  std::vector<bool> is_sure;
};
Marks marks_of(const LiftedLabels& labels) {
  Marks marks;
  for (const auto& [label, lifted] : labels.things) {
    if (label.is_transient) continue;
    marks.things.push_back(of_one(label, lifted, labels.reader));
    marks.is_sure.push_back(label.is_name_sure);
  }
  return marks;
}

}  // namespace

Expected<RecordingTruth> merge_readers(std::span<const LiftedLabels> readers,
                                       ReaderAgreement& agreement) {
  if (readers.size() > 1 && readers[0].reader == readers[1].reader) {
    return fail("both files are of the reader {}; give files of two readers", readers[0].reader);
  }
  RecordingTruth truth;
  agreement = {};
  agreement.only_one.resize(readers.size());
  Marks first, second;
  if (!readers.empty()) first = marks_of(readers[0]);
  if (readers.size() > 1) second = marks_of(readers[1]);
  for (const LiftedLabels& labels : readers.first(std::min<std::size_t>(readers.size(), 2))) {
    truth.recording = labels.recording;
    truth.readers.push_back(labels.reader);
  }
  std::vector<bool> first_used(first.things.size()), second_used(second.things.size());
  const auto join_pairs = [&](const std::vector<Pair>& pairs, std::size_t& count, bool same_name) {
    for (const Pair& pair : pairs) {
      if (first_used[pair.first] || second_used[pair.second]) continue;
      first_used[pair.first] = second_used[pair.second] = true;
      ++count;
      agreement.between_m.push_back(pair.distance_m);
      TrueThing& thing = first.things[pair.first];
      join(thing, second.things[pair.second]);
      thing.is_expected = same_name && first.is_sure[pair.first] && second.is_sure[pair.second];
    }
  };
  join_pairs(near_pairs(first.things, second.things, 1,
                        [](const TrueThing& a, const TrueThing& b) { return a.name == b.name; }),
             agreement.both, true);
  join_pairs(near_pairs(first.things, second.things, 0.5,
                        [](const TrueThing&, const TrueThing&) { return true; }),
             agreement.other_name, false);
  std::ranges::sort(agreement.between_m);
  for (std::size_t i = 0; i < first.things.size(); ++i) {
    if (!first_used[i]) ++agreement.only_one[0];
    truth.things.push_back(std::move(first.things[i]));
  }
  for (std::size_t i = 0; i < second.things.size(); ++i) {
    if (second_used[i]) continue;
    ++agreement.only_one[1];
    truth.things.push_back(std::move(second.things[i]));
  }
  return truth;
}

Expected<void> write_recording_truth(const std::filesystem::path& path,
                                     const RecordingTruth& truth) {
  std::string text = Json{{"recording", truth.recording},
                          {"readers", truth.readers},
                          {"how",
                           "boxes drawn by hand in the pictures, lifted by roomwise-lab "
                           "lift-labels; metres, in the world of the recording's poses"}}
                         .dump();
  text.pop_back();  // the closing brace
  text += ",\n \"objects\": [";
  for (std::size_t i = 0; i < truth.things.size(); ++i) {
    text += i == 0 ? "\n" : ",\n";
    text += as_json(truth.things[i]).dump();
  }
  return write_file(path, text + "\n]}\n");
}

Expected<RecordingTruth> read_recording_truth(const std::filesystem::path& path) {
  ROOMWISE_TRY(const std::string text, read_text_file(path));
  try {
    const Json json = Json::parse(text);
    RecordingTruth truth;
    json.at("recording").get_to(truth.recording);
    json.at("readers").get_to(truth.readers);
    for (const Json& thing : json.at("objects")) {
      auto read = true_thing_from(thing);
      if (!read) return fail("{}: {}", path.string(), read.error().message);
      truth.things.push_back(*std::move(read));
    }
    return truth;
  } catch (const Json::exception& error) {
    return fail("{}: is no truth of a recording: {}; make it by roomwise-lab lift-labels",
                path.string(), error.what());
  }
}

}  // namespace roomwise::labelling
