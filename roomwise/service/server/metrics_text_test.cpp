#include "roomwise/service/server/metrics_text.h"

#include <gtest/gtest.h>

namespace roomwise::service {
namespace {

TEST(LatencyHistogramTest, CountsUpToEachBoundWithTheBoundItself) {
  static constexpr std::array<double, 2> kBounds{1, 5};
  LatencyHistogram histogram(kBounds);
  for (const double seconds : {0.0, 1.0, 1.5, 5.0, 60.0}) histogram.add(seconds);
  EXPECT_EQ(histogram.at_most(0), 2u);
  EXPECT_EQ(histogram.at_most(1), 4u);
  EXPECT_EQ(histogram.count(), 5u);
  EXPECT_DOUBLE_EQ(histogram.sum_s(), 67.5);
}

TEST(MetricsTextTest, IsWhatPrometheusReads) {
  static constexpr std::array<double, 2> kBounds{0.5, 1};
  LatencyHistogram histogram(kBounds);
  histogram.add(0.25);
  histogram.add(2);
  MetricsText text;
  text.single("devices", "gauge", "Devices that are connected.", std::uint64_t{3});
  text.family("jobs_total", "counter", "Jobs, by what came of them.");
  text.sample({{"job", "a\"b\\c\nd"}, {"state", "done"}}, std::uint64_t{1});
  text.family("answer_seconds", "histogram", "From a question to its answer.");
  text.histogram({{"question", "repeat"}}, histogram);
  EXPECT_EQ(text.text(),
            "# HELP roomwise_devices Devices that are connected.\n"
            "# TYPE roomwise_devices gauge\n"
            "roomwise_devices 3\n"
            "# HELP roomwise_jobs_total Jobs, by what came of them.\n"
            "# TYPE roomwise_jobs_total counter\n"
            "roomwise_jobs_total{job=\"a\\\"b\\\\c\\nd\",state=\"done\"} 1\n"
            "# HELP roomwise_answer_seconds From a question to its answer.\n"
            "# TYPE roomwise_answer_seconds histogram\n"
            "roomwise_answer_seconds_bucket{question=\"repeat\",le=\"0.5\"} 1\n"
            "roomwise_answer_seconds_bucket{question=\"repeat\",le=\"1\"} 1\n"
            "roomwise_answer_seconds_bucket{question=\"repeat\",le=\"+Inf\"} 2\n"
            "roomwise_answer_seconds_sum{question=\"repeat\"} 2.25\n"
            "roomwise_answer_seconds_count{question=\"repeat\"} 2\n");
}

TEST(MetricsTextTest, SamplesOfSeveralHomesStandInOneFamily) {
  MetricsText text;
  for (const char* home : {"a", "b"}) {
    text.label_all("home", home);
    text.single("frames", "counter", "Frames.", std::uint64_t{1});
    text.family("jobs", "counter", "Jobs.");
    text.sample({{"job", "map"}}, std::uint64_t{2});
  }
  text.label_all("", "");
  text.single("homes", "gauge", "Homes.", std::uint64_t{2});
  EXPECT_EQ(text.text(),
            "# HELP roomwise_frames Frames.\n# TYPE roomwise_frames counter\n"
            "roomwise_frames{home=\"a\"} 1\nroomwise_frames{home=\"b\"} 1\n"
            "# HELP roomwise_jobs Jobs.\n# TYPE roomwise_jobs counter\n"
            "roomwise_jobs{home=\"a\",job=\"map\"} 2\nroomwise_jobs{home=\"b\",job=\"map\"} 2\n"
            "# HELP roomwise_homes Homes.\n# TYPE roomwise_homes gauge\nroomwise_homes 2\n");
}

}  // namespace
}  // namespace roomwise::service
