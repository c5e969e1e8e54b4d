// Does one kind of work on two pictures so many times, by the instructions that ROOMWISE_SIMD
// names: for counting what each path costs where no clock tells (count_instructions.c).
//   kernel_work surf|match-surf|match-orb TIMES PICTURE PICTURE
#include <cstdio>
#include <string_view>

#include "arguments.h"
#include "roomwise/features/matcher.h"
#include "roomwise/features/opencv_extractors.h"
#include "roomwise/features/surf.h"
#include "roomwise/image/codec.h"
#include "roomwise/image/resample.h"

namespace roomwise::bench {
namespace {

constexpr const char* kUsage = "kernel_work surf|match-surf|match-orb TIMES PICTURE PICTURE";
constexpr int kKeypoints = 1000;

// A sum over all that was found, so that nothing is left out as unused.
Expected<double> do_work(std::string_view kind, int times, const image::GrayImage& a,
                         const image::GrayImage& b) {
  double sum = 0;
  if (kind == "surf") {
    const features::SurfExtractor surf({.max_keypoints = kKeypoints});
    for (int i = 0; i < times; ++i) sum += static_cast<double>(surf.extract(a).size());
    return sum;
  }
  if (kind != "match-surf" && kind != "match-orb") return fail("'{}' is no work; {}", kind, kUsage);
  const auto extractor = features::make_extractor(
      kind == "match-orb" ? features::FeatureKind::kOrb : features::FeatureKind::kSurf, kKeypoints);
  const features::Features of_a = extractor->extract(a), of_b = extractor->extract(b);
  for (int i = 0; i < times; ++i) {
    for (const features::Match& match : features::match_features(of_a, of_b, {}))
      sum += static_cast<double>(match.distance);
  }
  return sum;
}

Expected<void> work(int argc, char** argv) {
  if (argc != 5) return fail("usage: {}", kUsage);
  ROOMWISE_TRY(const int times, parse_count(argv[2], kUsage));
  ROOMWISE_TRY(const image::ColorImage a, image::read_color(argv[3]));
  ROOMWISE_TRY(const image::ColorImage b, image::read_color(argv[4]));
  ROOMWISE_TRY(const double sum, do_work(argv[1], times, image::to_gray(a), image::to_gray(b)));
  std::printf("%s %d times: %.9g\n", argv[1], times, sum);
  return {};
}

}  // namespace
}  // namespace roomwise::bench

int main(int argc, char** argv) {
  const auto done = roomwise::bench::work(argc, argv);
  if (!done) std::fprintf(stderr, "kernel_work: %s\n", done.error().message.c_str());
  return done ? 0 : 1;
}
