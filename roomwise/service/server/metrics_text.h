#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace roomwise::service {

// How often something took how long: counts between fixed bounds. Not thread-safe.
class LatencyHistogram {
 public:
  // Upper bounds in seconds, rising. They must outlive it.
  explicit LatencyHistogram(std::span<const double> bounds_s)
      : bounds_s_(bounds_s), counts_(bounds_s.size() + 1, 0) {}

  void add(double seconds);

  [[nodiscard]] std::span<const double> bounds_s() const { return bounds_s_; }
  // How many lasted at most the bound of that index; one past the last bound: all.
  [[nodiscard]] std::uint64_t at_most(std::size_t index) const;
  [[nodiscard]] std::uint64_t count() const { return at_most(bounds_s_.size()); }
  [[nodiscard]] double sum_s() const { return sum_s_; }

 private:
  std::span<const double> bounds_s_;
  std::vector<std::uint64_t> counts_;  // between the bounds, and beyond the last
  double sum_s_ = 0;
};

// Of what a person waits for, and of work in the background.
inline constexpr std::array<double, 11> kWaitingBounds_s{0.005, 0.01, 0.025, 0.05, 0.1, 0.25,
                                                         0.5,   1,    2.5,   5,    10};
inline constexpr std::array<double, 8> kWorkBounds_s{1, 5, 15, 60, 300, 900, 3600, 14400};

// Figures in Prometheus' text format (version 0.0.4). A family is begun, then come its samples.
class MetricsText {
 public:
  using Labels = std::vector<std::pair<std::string_view, std::string_view>>;

  // `name` without the prefix "roomwise_"; `type`: counter, gauge or histogram; `help`: for people,
  // one line.
  void family(std::string_view name, std::string_view type, std::string_view help);
  void sample(const Labels& labels, double value);
  void sample(const Labels& labels, std::uint64_t value);
  void histogram(const Labels& labels, const LatencyHistogram& histogram);
  // A family of one sample without labels.
  template <typename Number>
  void single(std::string_view name, std::string_view type, std::string_view help, Number value) {
    family(name, type, help);
    sample({}, value);
  }

  // Puts this label before those of each sample to come; no name: none any more. A family that is
  // begun again goes on, so that those of several homes stand together.
  void label_all(std::string_view name, std::string_view value);

  [[nodiscard]] std::string text() const;

 private:
  void line(std::string_view suffix, const Labels& labels, std::string_view value);

  struct Family {
    std::string name;
    std::string text;
  };

  std::vector<Family> families_;  // in the order in which they were begun first
  std::size_t current_ = 0;
  std::string common_;  // home="flat-7"
};

}  // namespace roomwise::service
