#include <algorithm>
#include <map>
#include <set>

#include "laboratory/simulation/home/home_generator.h"
#include "laboratory/simulation/home/scenario.h"
#include "laboratory/simulation/sensor/sensor.h"
#include "laboratory/simulation/walk/home_views.h"
#include "laboratory/simulation/walk/piece_views.h"
#include "laboratory/trials/own_things/trial_things.h"
#include "roomwise/image/codec.h"

namespace roomwise::trials {
namespace {

using simulation::HomeModel;
using simulation::Scenario;

constexpr std::uint64_t kRenderedStream = 0x0B3;
constexpr int kPictureQuality = 92;
constexpr float kSmallest_px = 24;
constexpr double kMinSeen = 0.6;  // of the thing, else it is no test

geometry::PinholeCamera phone_camera() {
  geometry::PinholeCamera camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 525;
  camera.cx = 319.5;
  camera.cy = 239.5;
  return camera;
}

// A home in some light, to take pictures of.
class LitHome {
 public:
  static Expected<LitHome> create(const HomeModel& by_day, Scenario scenario,
                                  const simulation::FurnitureCatalogue& catalogue,
                                  const RenderedThingsOptions& options, ThreadPool& pool) {
    LitHome lit(pool);
    lit.home_ = std::make_unique<HomeModel>(
        simulation::apply_scenario(by_day, scenario, by_day.seed, catalogue.models()));
    simulation::RenderOptions render;
    render.samples_per_pixel = 2;
    render.bake_effort = options.bake_effort;
    SilentProgress silent;
    ROOMWISE_TRY(lit.renderer_,
                 simulation::Renderer::create(*lit.home_, catalogue, render, pool, silent));
    return lit;
  }

  [[nodiscard]] const HomeModel& home() const { return *home_; }
  [[nodiscard]] const simulation::Renderer& renderer() const { return *renderer_; }

  struct Taken {
    image::ColorImage color;
    simulation::RenderedFrame seen;
  };
  Expected<Taken> take(const geometry::RigidTransform& world_from_camera, std::size_t room,
                       std::uint64_t index) const {
    const geometry::PinholeCamera camera = phone_camera();
    Taken taken{{}, renderer_->render(camera, world_from_camera, *pool_)};
    simulation::SensorOptions sensor_options;
    sensor_options.seed = home_->seed;
    ROOMWISE_TRY(const auto sensor, simulation::Sensor::create(camera, sensor_options));
    simulation::ExposureControl exposure(sensor_options);
    taken.color = sensor
                      .capture(taken.seen, simulation::moving_pose(world_from_camera, room, 0.5),
                               index, exposure.next(taken.seen, 0, index), *pool_)
                      .color;
    return taken;
  }

 private:
  explicit LitHome(ThreadPool& pool) : pool_(&pool) {}
  ThreadPool* pool_;
  std::unique_ptr<HomeModel> home_;
  std::unique_ptr<simulation::Renderer> renderer_;
};

network::PixelBox box_in(const simulation::RenderedFrame& frame, std::size_t object) {
  network::PixelBox box{1e9F, 1e9F, -1, -1};
  for (int y = 0; y < frame.object.height(); ++y) {
    for (int x = 0; x < frame.object.width(); ++x) {
      if (frame.object.at(x, y) != object + 1) continue;
      box.left = std::min(box.left, static_cast<float>(x));
      box.top = std::min(box.top, static_cast<float>(y));
      box.right = std::max(box.right, static_cast<float>(x + 1));
      box.bottom = std::max(box.bottom, static_cast<float>(y + 1));
    }
  }
  return box;
}

bool is_large_enough(const network::PixelBox& box) {
  return box.right - box.left >= kSmallest_px && box.bottom - box.top >= kSmallest_px;
}

// Objects worth teaching, the likeliest first, one of a model.
std::vector<std::size_t> things_of(const HomeModel& home) {
  std::vector<std::size_t> order(home.objects.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::stable_sort(order, {}, [&](std::size_t i) {
    const simulation::PlacedObject& object = home.objects[i];
    return object.is_small ? 0 : object.is_movable ? 1 : 2;
  });
  std::map<std::string, int> of_model;
  for (const auto& object : home.objects) ++of_model[object.model];
  std::erase_if(order, [&](std::size_t i) { return of_model[home.objects[i].model] > 1; });
  return order;
}

// Takes pictures of one thing.
class ThingPhotographer {
 public:
  ThingPhotographer(std::size_t object, const simulation::TriangleMesh& mesh, std::uint64_t seed,
                    const LitHome& by_day)
      : object_(object),
        piece_(by_day.home().objects[object]),
        points_(simulation::points_on(piece_, mesh)),
        places_(simulation::places_before(by_day.home(), object,
                                          simulation::FreeSpace::of(by_day.home()), 0.6, 3.0)),
        random_(seed, {kRenderedStream, by_day.home().seed, object}) {}

  // A picture that shows it well enough, of a few tries.
  Expected<std::optional<TrialPicture>> take(const LitHome& lit, double nearest_m,
                                             double farthest_m, bool is_shown) {
    constexpr int kTries = 6;
    for (int i = 0; i < kTries && !places_.empty(); ++i) {
      const simulation::StandingPlace& place = places_[random_.index(places_.size())];
      if (place.distance_m < nearest_m || place.distance_m > farthest_m) continue;
      const Eigen::Vector3d eye(place.place.x(), place.place.y(), random_.between(1.2, 1.6));
      Eigen::Vector3d aim = piece_.world_from_object * Eigen::Vector3d(0, 0, piece_.size_m.z() / 2);
      if (!is_shown) {
        for (int axis = 0; axis < 3; ++axis) aim[axis] += random_.between(-0.4, 0.4);
      }
      const auto world_from_camera = simulation::looking_at(eye, aim);
      const geometry::PinholeCamera coarse = simulation::coarse(phone_camera());
      ThreadPool alone(1);
      const auto rough = lit.renderer().render(coarse, world_from_camera, alone);
      if (simulation::share_seen(points_, object_, rough, coarse, world_from_camera) < kMinSeen) {
        continue;
      }
      ROOMWISE_TRY(const LitHome::Taken taken,
                   lit.take(world_from_camera, piece_.room, random_.index(1000)));
      const network::PixelBox box = box_in(taken.seen, object_);
      if (!is_large_enough(box)) continue;
      const image::ColorImage picture =
          is_shown ? shown_before_camera(taken.color, box, random_) : taken.color;
      return TrialPicture{image::encode_jpeg(picture, kPictureQuality), box};
    }
    return std::nullopt;
  }

 private:
  std::size_t object_;
  const simulation::PlacedObject& piece_;
  std::vector<Eigen::Vector3d> points_;
  std::vector<simulation::StandingPlace> places_;
  RandomStream random_;
};

Expected<std::optional<TrialThing>> rendered_thing(std::size_t object, const std::string& home,
                                                   const std::vector<LitHome>& lit,
                                                   const simulation::FurnitureCatalogue& catalogue,
                                                   const RenderedThingsOptions& options) {
  const simulation::PlacedObject& piece = lit.front().home().objects[object];
  ROOMWISE_TRY(const simulation::TriangleMesh mesh, catalogue.load(piece.model));
  ThingPhotographer photographer(object, mesh, options.seed, lit.front());
  TrialThing thing{piece.name, TrialGroup::kRendered, home, {}, {}, {}, {}};
  for (std::size_t i = 0; i < options.shown; ++i) {
    ROOMWISE_TRY(auto shown, photographer.take(lit.front(), 0.6, 1.6, true));
    if (shown) thing.shown.push_back(std::move(shown->picture));
  }
  for (std::size_t i = 0; i < options.tests && thing.shown.size() >= 3; ++i) {
    const LitHome& dark = lit[1 + i % (lit.size() - 1)];
    ROOMWISE_TRY(auto test, photographer.take(dark, 1.0, 3.0, false));
    if (test) thing.tests.push_back(*std::move(test));
  }
  if (thing.shown.size() < 3 || thing.tests.size() < 2) return std::nullopt;
  return thing;
}

Expected<TrialWalk> rendered_walk(const std::string& name, const LitHome& by_day,
                                  const simulation::FurnitureCatalogue& catalogue,
                                  ThreadPool& pool) {
  simulation::HomeViewOptions views;
  views.of_kind = 0;
  views.of_room = 10;
  const simulation::MeshLoader load = [&](const std::string& model) {
    return catalogue.load(model);
  };
  ROOMWISE_TRY(const auto chosen,
               simulation::choose_home_views(by_day.home(), load, by_day.renderer(), views, pool));
  TrialWalk walk{name, name, false, false, {}};
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    ROOMWISE_TRY(const LitHome::Taken taken,
                 by_day.take(chosen[i].world_from_camera, chosen[i].room, i));
    walk.pictures.push_back(image::encode_jpeg(taken.color, kPictureQuality));
  }
  return walk;
}

}  // namespace

Expected<void> add_rendered_things(const RenderedThingsOptions& options,
                                   const simulation::FurnitureCatalogue& catalogue,
                                   ThreadPool& pool, Progress& progress, TrialSet& set) {
  progress.begin("rendering things", options.homes.size() * options.things);
  for (std::size_t h = 0; h < options.homes.size(); ++h) {
    ROOMWISE_TRY(const HomeModel by_day,
                 simulation::generate_home({options.homes[h], {}}, catalogue));
    std::vector<LitHome> lit;
    for (const Scenario scenario : {Scenario::kDay, Scenario::kEvening, Scenario::kNight}) {
      ROOMWISE_TRY(LitHome one, LitHome::create(by_day, scenario, catalogue, options, pool));
      lit.push_back(std::move(one));
    }
    const std::string name = fmt::format("home {}", options.homes[h]);
    ROOMWISE_TRY(TrialWalk walk, rendered_walk(name, lit.front(), catalogue, pool));
    set.walks.push_back(std::move(walk));
    std::size_t things = 0;
    for (const std::size_t object : things_of(lit.front().home())) {
      if (things == options.things) break;
      if (progress.interrupted()) return fail_with(ErrorCode::kInterrupted, "interrupted");
      ROOMWISE_TRY(auto thing, rendered_thing(object, name, lit, catalogue, options));
      if (!thing) continue;
      thing->home = {set.walks.size() - 1};
      for (std::size_t w = 0; w < set.walks.size(); ++w) {
        if (set.walks[w].is_real) thing->absent.push_back(w);
      }
      set.things.push_back(*std::move(thing));
      progress.advance(h * options.things + ++things, "");
    }
  }
  progress.end();
  return {};
}

}  // namespace roomwise::trials
