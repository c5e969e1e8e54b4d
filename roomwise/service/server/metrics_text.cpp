#include "roomwise/service/server/metrics_text.h"

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
  const std::string full = fmt::format("roomwise_{}", name);
  const auto found = std::ranges::find(families_, full, &Family::name);
  current_ = static_cast<std::size_t>(found - families_.begin());
  if (found != families_.end()) return;
  families_.push_back({full, fmt::format("# HELP {0} {1}\n# TYPE {0} {2}\n", full, help, type)});
}

void MetricsText::label_all(std::string_view name, std::string_view value) {
  common_ = name.empty() ? "" : fmt::format("{}=\"{}\"", name, escaped(value));
}

std::string MetricsText::text() const {
  std::string all;
  for (const Family& family : families_) all += family.text;
  return all;
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
  std::string all = common_;
  for (const auto& [name, text] : labels) {
    all += fmt::format("{}{}=\"{}\"", all.empty() ? "" : ",", name, escaped(text));
  }
  Family& family = families_.at(current_);
  family.text += fmt::format("{}{}{}{}{} {}\n", family.name, suffix, all.empty() ? "" : "{", all,
                             all.empty() ? "" : "}", value);
}

}  // namespace roomwise::service
