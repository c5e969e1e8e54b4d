#pragma once

#include <fmt/ranges.h>

#include <string>
#include <vector>

#include "command.h"
#include "roomwise/image/personal_data.h"

namespace roomwise::app {

// "where it was recorded (GPS), the device's name": what a recording says besides and is nobody's
// business. Empty where there is none.
inline std::string left_out_text(const image::PersonalData& facts) {
  std::vector<std::string> words;
  if (facts.place) words.emplace_back("where it was recorded (GPS)");
  if (facts.device) words.emplace_back("the device's name");
  if (facts.owner) words.emplace_back("whose it is");
  return fmt::format("{}", fmt::join(words, ", "));
}

// The same for machines.
inline Json left_out_json(const image::PersonalData& facts) {
  Json words = Json::array();
  if (facts.place) words.push_back("place");
  if (facts.device) words.push_back("device");
  if (facts.owner) words.push_back("owner");
  return words;
}

}  // namespace roomwise::app
