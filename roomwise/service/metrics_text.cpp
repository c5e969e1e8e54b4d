#include "roomwise/service/metrics_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <numeric>

namespace roomwise::service {
namespace {

// In a label's value a backslash, a quotation mark and a line's end are written by two characters.
std::string escaped(std::string_view value) {
  std::string text;
  for (const char c : value) {
    if (c == '\\' || c == '"') text += '\\';
    if (c == '\n') {
      text += "\\n";
    } else {
      text += c;
    }
  }
  return text;
}

}  // namespace

void LatencyHistogram::add(double seconds) {
  const auto bound = std::ranges::lower_bound(bounds_s_, seconds);
  ++counts_[static_cast<std::size_t>(bound - bounds_s_.begin())];
  sum_s_ += seconds;
}

std::uint64_t LatencyHistogram::at_most(std::size_t index) const {
  return std::accumulate(counts_.begin(), counts_.begin() + static_cast<std::ptrdiff_t>(index) + 1,
                         std::uint64_t{0});
}

void MetricsText::family(std::string_view name, std::string_view type, std::string_view help) {
  name_ = fmt::format("roomwise_{}", name);
  text_ += fmt::format("# HELP {0} {1}\n# TYPE {0} {2}\n", name_, help, type);
}

void MetricsText::sample(const Labels& labels, double value) {
  line("", labels, fmt::format("{}", value));
}

void MetricsText::sample(const Labels& labels, std::uint64_t value) {
  line("", labels, fmt::format("{}", value));
}

void MetricsText::histogram(const Labels& labels, const LatencyHistogram& histogram) {
  const auto bounds_s = histogram.bounds_s();
  for (std::size_t i = 0; i <= bounds_s.size(); ++i) {
    const std::string bound = i < bounds_s.size() ? fmt::format("{}", bounds_s[i]) : "+Inf";
    Labels with_bound = labels;
    with_bound.emplace_back("le", bound);
    line("_bucket", with_bound, fmt::format("{}", histogram.at_most(i)));
  }
  line("_sum", labels, fmt::format("{}", histogram.sum_s()));
  line("_count", labels, fmt::format("{}", histogram.count()));
}

void MetricsText::line(std::string_view suffix, const Labels& labels, std::string_view value) {
  text_ += name_;
  text_ += suffix;
  const char* before = "{";
  for (const auto& [name, text] : labels) {
    text_ += fmt::format("{}{}=\"{}\"", before, name, escaped(text));
    before = ",";
  }
  if (!labels.empty()) text_ += '}';
  text_ += fmt::format(" {}\n", value);
}

}  // namespace roomwise::service
