#include "laboratory/simulation/furniture/furniture_properties.h"

#include <charconv>
#include <map>
#include <optional>
#include <string_view>

namespace roomwise::simulation {
namespace {

constexpr double kMetresPerCentimetre = 0.01;

void append_utf8(std::string& text, unsigned code) {
  if (code < 0x80) {
    text += static_cast<char>(code);
  } else if (code < 0x800) {
    text += static_cast<char>(0xC0 | (code >> 6));
    text += static_cast<char>(0x80 | (code & 0x3F));
  } else {
    text += static_cast<char>(0xE0 | (code >> 12));
    text += static_cast<char>(0x80 | ((code >> 6) & 0x3F));
    text += static_cast<char>(0x80 | (code & 0x3F));
  }
}

std::string utf8_of(std::string_view value) {
  std::string text;
  for (std::size_t i = 0; i < value.size(); ++i) {
    unsigned code = static_cast<unsigned char>(value[i]);
    if (value.substr(i).starts_with("\\u") && i + 6 <= value.size()) {
      std::from_chars(value.data() + i + 2, value.data() + i + 6, code, 16);
      i += 5;
    }
    append_utf8(text, code);
  }
  return text;
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n";
  const auto first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

// The values of one model, by the name of the property.
using Values = std::map<std::string, std::string, std::less<>>;

// The properties "name#3=Bed" by their number, and those without a number under 0.
std::map<int, Values> by_number(std::string_view text) {
  std::map<int, Values> models;
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    const std::string_view line = trimmed(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    const auto equals = line.find('=');
    if (line.starts_with('#') || equals == std::string_view::npos) continue;
    const std::string_view key = trimmed(line.substr(0, equals));
    const auto hash = std::min(key.find('#'), key.size());
    int number = 0;
    if (hash < key.size()) std::from_chars(key.data() + hash + 1, key.data() + key.size(), number);
    models[number].emplace(key.substr(0, hash), utf8_of(trimmed(line.substr(equals + 1))));
  }
  return models;
}

// The numbers of a property that are divided by blanks; absent where the text holds anything else.
std::optional<std::vector<double>> numbers_in(std::string_view text) {
  std::vector<double> numbers;
  for (text = trimmed(text); !text.empty(); text = trimmed(text)) {
    double number = 0;
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (code != std::errc{}) return std::nullopt;
    numbers.push_back(number);
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  }
  return numbers;
}

// Looks values up and remembers the first that is missing or wrong.
class Reader {
 public:
  Reader(const Values& values, int number) : values_(values), number_(number) {}

  std::string text(std::string_view key) {
    const auto found = values_.find(key);
    if (found != values_.end()) return found->second;
    note(key, "is missing");
    return {};
  }
  double metres(std::string_view key) {
    const auto numbers = numbers_in(text(key));
    if (numbers && numbers->size() == 1) return kMetresPerCentimetre * numbers->front();
    note(key, "is not a number");
    return 0;
  }
  double metres_or(std::string_view key, double otherwise) {
    return values_.contains(key) ? metres(key) : otherwise;
  }
  Eigen::Matrix3d rotation(std::string_view key) {
    if (!values_.contains(key)) return Eigen::Matrix3d::Identity();
    const auto numbers = numbers_in(text(key));
    if (numbers && numbers->size() == 9) {
      return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(numbers->data());
    }
    note(key, "is not nine numbers");
    return Eigen::Matrix3d::Identity();
  }
  void note(std::string_view key, std::string_view what) {
    if (error_.empty()) error_ = fmt::format("property {}#{} {}", key, number_, what);
  }
  [[nodiscard]] const std::string& error() const { return error_; }

 private:
  const Values& values_;
  int number_;
  std::string error_;
};

Expected<FurnitureProperties> properties_of(const Values& values, int number) {
  Reader reader(values, number);
  FurnitureProperties model;
  model.model_path = reader.text("model");
  if (model.model_path.starts_with('/')) model.model_path.erase(0, 1);
  model.id = model.model_path.substr(0, model.model_path.rfind('/'));
  model.name = reader.text("name");
  model.creator = reader.text("creator");
  model.size_m = {reader.metres("width"), reader.metres("depth"), reader.metres("height")};
  model.elevation_m = reader.metres_or("elevation", 0);
  // Absent: things stand on its highest point; -1: nothing is to stand on it.
  model.top_m = std::max(reader.metres_or("dropOnTopElevation", model.size_m.z()), 0.0);
  model.rotation = reader.rotation("modelRotation");
  if (model.size_m.minCoeff() <= 0) reader.note("width, depth or height", "is not positive");
  if (!reader.error().empty()) return fail("{}", reader.error());
  return model;
}

}  // namespace

Expected<std::vector<FurnitureProperties>> parse_furniture_properties(std::string_view text) {
  const std::map<int, Values> by_model = by_number(text);
  std::string license = "unknown license";
  std::vector<FurnitureProperties> models;
  for (const auto& [number, values] : by_model) {
    if (number == 0) {
      if (const auto found = values.find("license"); found != values.end()) license = found->second;
      continue;
    }
    ROOMWISE_TRY(auto model, properties_of(values, number));
    model.license = license;
    models.push_back(std::move(model));
  }
  return models;
}

}  // namespace roomwise::simulation
