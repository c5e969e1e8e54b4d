#include "roomwise/live/device/people.h"

#include <gmock/gmock.h>

#include "roomwise/base/testing/testing.h"

namespace roomwise::live {
namespace {

using ::testing::IsEmpty;
using ::testing::SizeIs;
using Side = guide::SeenPerson::Side;

// Finds what it is told to.
class ToldFinder final : public objects::DetectionFinder {
 public:
  explicit ToldFinder(std::vector<network::Detection> found,
                      std::vector<std::string> labels = {"chair", "person"})
      : labels_(std::move(labels)), found_(std::move(found)) {}
  [[nodiscard]] const std::string& name() const override { return name_; }
  [[nodiscard]] const std::string& fingerprint() const override { return name_; }
  [[nodiscard]] const std::vector<std::string>& labels() const override { return labels_; }
  [[nodiscard]] Expected<std::vector<network::Detection>> find(
      const image::ColorImage&) const override {
    return found_;
  }

 private:
  std::string name_ = "told";
  std::vector<std::string> labels_;
  std::vector<network::Detection> found_;
};

constexpr std::size_t kChair = 0, kPerson = 1;

FrameImages picture(std::uint16_t depth_mm = 0) {
  FrameImages images{image::ColorImage(90, 60), std::nullopt};
  if (depth_mm > 0) {
    images.depth.emplace(90, 60);
    std::ranges::fill(images.depth->pixels(), depth_mm);
  }
  return images;
}
geometry::PinholeCamera narrow() {
  geometry::PinholeCamera camera;
  camera.width = 90;
  camera.height = 60;
  camera.fx = camera.fy = 90;
  camera.cx = 44.5;
  camera.cy = 29.5;
  camera.depth_units_per_metre = 1000;
  return camera;
}

std::vector<guide::SeenPerson> people(const FrameImages& images,
                                      const std::optional<geometry::PinholeCamera>& camera,
                                      std::vector<network::Detection> found) {
  objects::DetectionFinders finders;
  finders.push_back(std::make_unique<ToldFinder>(std::vector<network::Detection>{},
                                                 std::vector<std::string>{"sofa"}));
  finders.push_back(std::make_unique<ToldFinder>(std::move(found)));
  return people_in(images, camera, finders).value();
}

TEST(PeopleTest, AreToldBySideAndDistance) {
  const auto seen = people(picture(2000), narrow(), {{kPerson, 0.8F, {0, 0, 20, 60}}});
  ASSERT_THAT(seen, SizeIs(1));
  EXPECT_EQ(seen[0].side, Side::kLeft);
  EXPECT_NEAR(seen[0].distance_m.value(), 2.1, 0.1);
  EXPECT_TRUE(seen[0].is_sure);
  EXPECT_EQ(people(picture(), narrow(), {{kPerson, 0.8F, {35, 0, 60, 60}}})[0].side, Side::kAhead);
}

TEST(PeopleTest, OfACameraThatNobodyCalibratedSidesAreThirds) {
  const auto seen = people(picture(), std::nullopt,
                           {{kPerson, 0.8F, {70, 0, 90, 60}}, {kPerson, 0.3F, {40, 0, 50, 60}}});
  ASSERT_THAT(seen, SizeIs(2));
  EXPECT_EQ(seen[0].side, Side::kRight);
  EXPECT_EQ(seen[0].distance_m, std::nullopt);
  EXPECT_EQ(seen[1].side, Side::kAhead);
  EXPECT_FALSE(seen[1].is_sure) << "less likely than not";
}

TEST(PeopleTest, ThingsAreNobody) {
  EXPECT_THAT(people(picture(), narrow(), {{kChair, 0.9F, {0, 0, 20, 60}}}), IsEmpty());
}

TEST(PeopleTest, WithoutADetectorThatKnowsThemNobodyIsSaidToBeAbsent) {
  EXPECT_ERROR(people_in(picture(), narrow(), {}), "no detector that knows people");
}

TEST(PeopleTest, APictureIsDarkWhereNothingIsBright) {
  image::ColorImage color(20, 20);
  EXPECT_TRUE(is_dark(color));
  for (int i = 0; i < 40; ++i) color.at(i % 20, i / 20) = {200, 200, 200};
  EXPECT_FALSE(is_dark(color)) << "a lamp";
}

}  // namespace
}  // namespace roomwise::live
