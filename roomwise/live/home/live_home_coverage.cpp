#include "roomwise/live/home/live_home.h"

// What the walks of a home that is open have not shown yet.
namespace roomwise::live {
namespace {

// Shows nothing, and stops when told to.
class StopsWhenTold final : public Progress {
 public:
  explicit StopsWhenTold(const std::atomic<bool>& stops) : stops_(stops) {}
  void begin(std::string_view, std::optional<std::uint64_t>) override {}
  void advance(std::uint64_t, std::string_view) override {}
  void end() override {}
  [[nodiscard]] bool interrupted() const override { return stops_; }

 private:
  const std::atomic<bool>& stops_;
};

}  // namespace

Expected<std::shared_ptr<const pipeline::RoomCoverage>> LiveHome::coverage() {
  // Who waited here would take the place of a request that needs none of this.
  const std::unique_lock lock(coverage_mutex_, std::try_to_lock);
  if (!lock) return nullptr;
  const auto now = view();
  if (covered_ == now && coverage_) return coverage_;
  const bool is_mapping = jobs_->running() && jobs_->state()->kind == "map";
  if (is_mapping || (!now->map && !now->walks.empty())) return nullptr;
  StopsWhenTold progress(coverage_stops_);
  pipeline::OwnRunContext run(options_.threads, progress);
  // By a reader of its own, so that pictures can be looked at meanwhile.
  ROOMWISE_TRY(const home::Home reader, home::Home::open_read_only(file_, options_.open));
  pipeline::CoverageOptions options;
  options.without = now->walks_taken_away();
  auto found =
      watched("what is missing", pipeline::find_room_coverage(reader, options, run, tones_));
  ROOMWISE_RETURN_IF_ERROR(found);
  coverage_ = std::make_shared<const pipeline::RoomCoverage>(*std::move(found));
  covered_ = now;
  return coverage_;
}

}  // namespace roomwise::live
