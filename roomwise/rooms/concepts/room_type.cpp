#include "roomwise/rooms/concepts/room_type.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace roomwise::rooms {
namespace {

// The probability that the map of a room shows a class: where its type has it, where it
// does not, and in a room of a type that nobody described. A guess, and worth so many rooms.
constexpr double kHas = 0.6;
constexpr double kHasNot = 0.05;
constexpr double kOther = 0.15;
constexpr double kPriorPseudoCount = 2;
// Of a type that nothing speaks for: that things are missing is no reason to believe in one that
// has few.
constexpr double kImpossibleLogPenalty = 1e6;

double probability_of(const RoomContents& contents, const std::string& object) {
  const auto found = contents.find(object);
  return found != contents.end() ? found->second : 0;
}

// P(a room of the type has one of the class).
double class_probability(const std::string& type, const std::set<std::string>& classes,
                         const std::string& object, std::span<const TypedContents> examples) {
  const double guess = type == kOtherType ? kOther : classes.contains(object) ? kHas : kHasNot;
  double having = kPriorPseudoCount * guess;
  double rooms = kPriorPseudoCount;
  for (const TypedContents& example : examples) {
    if (example.type != type) continue;
    having += probability_of(example.contents, object);
    rooms += 1;
  }
  return having / rooms;
}

}  // namespace

std::vector<TypePosterior> classify_room_type(const RoomContents& contents,
                                              const Concepts& concepts,
                                              std::span<const TypedContents> examples) {
  std::map<std::string, std::set<std::string>> classes_of_type = concepts.objects_of_room_type;
  for (const TypedContents& example : examples) classes_of_type[example.type];
  classes_of_type[kOtherType];
  std::set<std::string> classes;
  for (const auto& [type, of_type] : classes_of_type)
    classes.insert(of_type.begin(), of_type.end());
  for (const TypedContents& example : examples) {
    for (const auto& [object, probability] : example.contents) classes.insert(object);
  }

  std::vector<TypePosterior> guesses;
  std::vector<double> logs;
  for (const auto& [type, of_type] : classes_of_type) {
    TypePosterior& guess = guesses.emplace_back();
    guess.type = type;
    double& log = logs.emplace_back(0);
    std::vector<std::pair<double, std::string>> reasons;
    for (const std::string& object : classes) {
      const double there = probability_of(contents, object);
      const double expected = class_probability(type, of_type, object, examples);
      const double likelihood = there * expected + (1 - there) * (1 - expected);
      log += std::log(likelihood);
      const double elsewhere = there * kOther + (1 - there) * (1 - kOther);
      if (there >= 0.5 && likelihood > elsewhere)
        reasons.emplace_back(likelihood / elsewhere, object);
    }
    std::ranges::stable_sort(reasons, std::ranges::greater{},
                             &std::pair<double, std::string>::first);
    for (const auto& [ratio, object] : reasons) guess.because.push_back(object);
    if (reasons.empty() && type != kOtherType) log = -kImpossibleLogPenalty;
  }
  const double most = *std::ranges::max_element(logs);
  double sum = 0;
  for (std::size_t i = 0; i < guesses.size(); ++i) {
    sum += guesses[i].probability = std::exp(logs[i] - most);
  }
  for (TypePosterior& guess : guesses) guess.probability /= sum;
  std::ranges::stable_sort(guesses, std::ranges::greater{}, &TypePosterior::probability);
  return guesses;
}

}  // namespace roomwise::rooms
