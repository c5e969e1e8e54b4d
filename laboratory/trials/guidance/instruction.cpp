#include "laboratory/trials/guidance/instruction.h"

#include <cctype>
#include <cmath>
#include <numbers>
#include <string_view>

#include "roomwise/guide/way/legs.h"

namespace roomwise::trials {
namespace {

using Kind = Instruction::Kind;
using guide::kDegree_rad;

constexpr double kLittle_rad = 20 * kDegree_rad;
constexpr double kSmallStep_m = 0.3;
constexpr double kThrough_m = 1;  // who goes through a door stands behind it

std::vector<double> numbers_in(std::string_view text) {
  std::vector<double> numbers;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (std::isdigit(static_cast<unsigned char>(text[i])) == 0) continue;
    std::size_t end = i;
    while (end < text.size() && (std::isdigit(static_cast<unsigned char>(text[end])) != 0 ||
                                 (text[end] == '.' && end + 1 < text.size() &&
                                  std::isdigit(static_cast<unsigned char>(text[end + 1])) != 0))) {
      ++end;
    }
    numbers.push_back(std::stod(std::string(text.substr(i, end - i))));
    i = end;
  }
  return numbers;
}

double metres_of(double number, const guide::Wording& wording) {
  return wording.style.distances == guide::DistanceUnit::kSteps ? number * wording.style.step_m
                                                                : number;
}

double turn_to_hour_rad(double hour) {
  return std::remainder(-30 * kDegree_rad * hour, 2 * std::numbers::pi);
}

// The turn that a message names, apart from an hour.
double turn_of(std::string_view message, double hour) {
  if (message.find("around") != std::string_view::npos) return std::numbers::pi;
  if (message.find("hour") != std::string_view::npos) return turn_to_hour_rad(hour);
  const double side = message.find("left") != std::string_view::npos ? 1 : -1;
  return side * std::numbers::pi / 2;
}

}  // namespace

Instruction understand(const guide::Prompt& prompt, const guide::Wording& wording) {
  const std::string_view message = prompt.message_id;
  const std::vector<double> numbers = numbers_in(prompt.text);
  const auto number = [&](std::size_t i) { return i < numbers.size() ? numbers[i] : 0; };
  const auto is = [&](std::string_view start) { return message.starts_with(start); };
  if (is("guide.turn_")) return {Kind::kTurn, turn_of(message, number(0)), 0};
  if (message == "guide.little_left" || message == "guide.try_left") {
    return {Kind::kLittle, kLittle_rad, 0};
  }
  if (message == "guide.little_right" || message == "guide.try_right") {
    return {Kind::kLittle, -kLittle_rad, 0};
  }
  if (is("guide.walk") || is("guide.more") || message == "guide.through") {
    return {Kind::kWalk, 0, metres_of(number(0), wording)};
  }
  if (is("stairs.up_") || is("stairs.down_") || message == "stairs.up" ||
      message == "stairs.down") {
    return {Kind::kStairs};
  }
  if (is("stairs.soon_")) return {Kind::kWalk, 0, metres_of(number(0), wording)};
  if (is("stairs.")) return {Kind::kStop};  // is told to have arrived on the other storey
  if (message == "guide.small_step") return {Kind::kWalk, 0, kSmallStep_m};
  if (message == "guide.into") {  // of a room whose name may have a number
    return {Kind::kWalk, 0, metres_of(numbers.empty() ? 0 : numbers.back(), wording)};
  }
  if (message == "guide.soon_through" || message == "guide.soon_into") {
    return {Kind::kWalk, 0, metres_of(number(0), wording) + kThrough_m};
  }
  if (message == "guide.soon_goal" || message == "guide.soon_end") {
    return {Kind::kWalk, 0, metres_of(number(0), wording)};
  }
  if (is("guide.soon_")) {
    return {Kind::kSoon, turn_of(message, number(1)), metres_of(number(0), wording)};
  }
  if (message == "guide.lost" || message == "route.no_place") return {Kind::kLookAround};
  if (is("guide.stop") || is("guide.off") || is("guide.there") ||
      message == "guide.should_be_there" || message == "guide.near_end" ||
      message == "guide.no_way_around" || message == "guide.found" ||
      message == "guide.lost_wait") {
    return {Kind::kStop};
  }
  return {};
}

std::vector<Instruction> understand_leg(const guide::Prompt& prompt,
                                        const guide::Wording& wording) {
  static const std::vector<std::pair<const char*, double>> turns{
      {"route.left", 90},        {"route.right", -90},        {"route.around", 180},
      {"route.slight_left", 45}, {"route.slight_right", -45}, {"route.straight", 0}};
  const std::vector<double> numbers = numbers_in(prompt.text);
  if (!prompt.message_id.starts_with("route.step") || numbers.empty()) return {};
  std::vector<Instruction> leg;
  for (const auto& [message, degrees] : turns) {
    const std::string start = wording.phrases().text(message) + ",";
    if (prompt.text.starts_with(start) && degrees != 0) {
      leg.push_back({Kind::kTurn, degrees * kDegree_rad, 0});
    }
  }
  leg.push_back({Kind::kWalk, 0, metres_of(numbers.front(), wording)});
  return leg;
}

}  // namespace roomwise::trials
