#include "roomwise/pipeline/objects/changed_networks.h"

#include <gmock/gmock.h>

#include "roomwise/base/testing/testing.h"
#include "roomwise/pipeline/rooms/room_recognizer.h"
#include "roomwise/pipeline/testing/synthetic_walk.h"

namespace roomwise::pipeline {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class NamedFinder final : public objects::DetectionFinder {
 public:
  explicit NamedFinder(std::string fingerprint) : fingerprint_(std::move(fingerprint)) {}
  [[nodiscard]] const std::string& name() const override { return name_; }
  [[nodiscard]] const std::string& fingerprint() const override { return fingerprint_; }
  [[nodiscard]] const std::vector<std::string>& labels() const override { return labels_; }
  [[nodiscard]] Expected<std::vector<network::Detection>> find(
      const image::ColorImage&) const override {
    return std::vector<network::Detection>{};
  }

 private:
  std::string name_ = "detector";
  std::string fingerprint_;
  std::vector<std::string> labels_{"bed"};
};

class ChangedNetworksTest : public ::testing::Test {
 protected:
  ChangedNetworksTest() { networks_.push_back(std::make_unique<testing::ColorNetwork>()); }
  [[nodiscard]] std::vector<ChangedNetwork> changed() const {
    return changed_networks(home_, networks_, finders_).value();
  }
  void store(const std::string& name, const std::string& fingerprint) {
    ASSERT_OK(home_.add_network({name, fingerprint, {}, 12}));
  }

  ::roomwise::testing::ScratchFolder folder_;
  home::Home home_ = home::Home::create(folder_ / "a.home").value();
  Networks networks_;
  objects::DetectionFinders finders_;
};

TEST_F(ChangedNetworksTest, TheSameWeightsAndUnknownNetworksAreNoChange) {
  EXPECT_THAT(changed(), IsEmpty());
  store("another network", "ffff");
  EXPECT_THAT(changed(), IsEmpty());
  store(networks_[0]->name(), networks_[0]->fingerprint());
  EXPECT_THAT(changed(), IsEmpty());
}

TEST_F(ChangedNetworksTest, AFileOfTheSameNameWithOtherWeightsIsTold) {
  store(networks_[0]->name(), "aaaa");
  const ChangedNetwork expected{networks_[0]->name(), "aaaa", networks_[0]->fingerprint()};
  ASSERT_THAT(changed(), ElementsAre(expected));
  EXPECT_THAT(in_words(expected, "a.home"),
              HasSubstr("a.home: the network color network is not the one"));
  // Once it has looked at the home it is known.
  store(networks_[0]->name(), networks_[0]->fingerprint());
  EXPECT_THAT(changed(), IsEmpty());
}

TEST_F(ChangedNetworksTest, FindersAreComparedToo) {
  ASSERT_OK(home_.add_region_finder({"detector", "1111", {"bed"}}));
  finders_.push_back(std::make_unique<NamedFinder>("1111"));
  EXPECT_THAT(changed(), IsEmpty());
  finders_.front() = std::make_unique<NamedFinder>("2222");
  EXPECT_THAT(changed(), ElementsAre(ChangedNetwork{"detector", "1111", "2222"}));
}

}  // namespace
}  // namespace roomwise::pipeline
