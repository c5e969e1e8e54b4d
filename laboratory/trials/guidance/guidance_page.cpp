#include "laboratory/trials/guidance/guidance_page.h"

#include <limits>

#include "laboratory/simulation/home/home_geometry.h"
#include "roomwise/evaluation/drawing/svg.h"
#include "roomwise/evaluation/report/report_page.h"

namespace roomwise::trials {
namespace {

using Eigen::Vector2d;
using evaluation::SvgDrawing;
using simulation::Footprint;

constexpr double kPixelsPerMetre = 60;
constexpr double kMargin_m = 0.3;

class HomeDrawing {
 public:
  HomeDrawing(const WalkedHome& home, const std::string& title)
      : lowest_(home.floor.origin_m() - Vector2d::Constant(kMargin_m)),
        size_m_(Vector2d(home.floor.columns(), home.floor.rows()) * home.floor.cell_m() +
                Vector2d::Constant(2 * kMargin_m)),
        svg_(size_m_.x() * kPixelsPerMetre, size_m_.y() * kPixelsPerMetre, title) {
    for (const simulation::Rectangle& floor : simulation::floors_of(home.model)) {
      outline(simulation::as_footprint(floor, 0, 0), "fill=\"#f4f1ea\" stroke=\"#888\"");
    }
    for (const Footprint& thing : simulation::obstacles_of(home.model, simulation::kBodyFromHeight,
                                                           simulation::kBodyToHeight)) {
      outline(thing, "fill=\"#d5cfc2\" stroke=\"#a59d8c\"");
    }
    for (const simulation::Room& room : home.model.rooms) {
      svg_.text(at(simulation::center(room.interior)), room.name,
                "fill=\"#777\" font-size=\"13\" text-anchor=\"middle\"");
    }
  }

  void draw(const GuidedWalk& walk) {
    if (walk.goal.outline) {
      const guide::Outline& goal = *walk.goal.outline;
      outline({goal.middle_plan, goal.size_m.cwiseMax(0.1) / 2, goal.yaw_rad, 0, 0},
              "fill=\"#bfe3c0\" stroke=\"#2c7a2f\"");
    }
    std::vector<Vector2d> path;
    for (const Vector2d& place : walk.path) path.push_back(at(place));
    svg_.polyline(path, "fill=\"none\" stroke=\"#1f5fbf\" stroke-width=\"2\"");
    svg_.circle(at(walk.goal.start), 6, "fill=\"#1f5fbf\"");
    std::vector<Vector2d> used;
    for (std::size_t i = 0; i < walk.heard.size(); ++i) {
      Vector2d place = at(walk.heard[i].place);
      // Of several that were heard at one place the numbers stand below each other.
      for (const Vector2d& other : used) {
        if ((place - other).norm() < 11) place.y() = other.y() + 12;
      }
      used.push_back(place);
      svg_.text(place + Vector2d(8, 4), fmt::format("{}", i + 1),
                "fill=\"#a02020\" font-size=\"11\"");
    }
  }
  [[nodiscard]] std::string element() const { return svg_.element(); }

 private:
  // y up.
  [[nodiscard]] Vector2d at(const Vector2d& point) const {
    const Vector2d offset = point - lowest_;
    return kPixelsPerMetre * Vector2d(offset.x(), size_m_.y() - offset.y());
  }
  void outline(const Footprint& footprint, std::string_view attributes) {
    std::vector<Vector2d> corners;
    for (const Vector2d& corner : footprint.corners()) corners.push_back(at(corner));
    corners.push_back(corners.front());
    svg_.polyline(corners, attributes);
  }

  Vector2d lowest_, size_m_;
  SvgDrawing svg_;
};

std::string outcome_of(const GuidedWalk& walk) {
  if (walk.arrived()) return "arrived";
  if (!walk.is_offered) return "not known to the home";
  if (walk.is_told_not_reachable()) return "not reachable, and told so";
  if (walk.says_there) return "was told so, and is not there";
  return walk.has_ended ? "not led there, and told so" : "gave up";
}

// What was heard and touched, in the order of time.
std::vector<std::vector<std::string>> rows_of(const GuidedWalk& walk) {
  std::vector<std::vector<std::string>> rows;
  auto contact = walk.contacts.begin();
  const auto add_contacts_until = [&](double end_s) {
    for (; contact != walk.contacts.end() && contact->at_s < end_s; ++contact) {
      rows.push_back({"contact", fmt::format("Touched: {}", contact->thing),
                      contact->is_by_prompt ? fmt::format("by prompt {}", *contact->prompt + 1)
                                            : "the walker's own",
                      fmt::format("{:.1f}", contact->at_s)});
    }
  };
  for (std::size_t i = 0; i < walk.heard.size(); ++i) {
    const HeardPrompt& heard = walk.heard[i];
    add_contacts_until(heard.at_s);
    rows.push_back({fmt::format("{}", i + 1), heard.text,
                    heard.is_wrong  ? "wrong"
                    : heard.is_late ? "late"
                                    : "",
                    fmt::format("{:.1f}", heard.at_s)});
  }
  add_contacts_until(std::numeric_limits<double>::infinity());
  return rows;
}

}  // namespace

std::string guidance_page(std::span<const GuidedWalk> walks, const HomeOfWalk& home_of,
                          const std::string& title, const std::string& note) {
  std::string body;
  for (std::size_t i = 0; i < walks.size(); ++i) {
    const GuidedWalk& walk = walks[i];
    const std::string name =
        fmt::format("Walk {}: to {}, {}", i + 1, walk.goal.goal.noun.name, outcome_of(walk));
    HomeDrawing drawing(home_of(i), name);
    drawing.draw(walk);
    body += fmt::format(
        "<h2>{}</h2>\n<p>{:.1f} m walked, {:.1f} m the shortest way; {:.0f} s; {} "
        "contacts, {} of them by prompts.</p>\n",
        evaluation::escape_markup(name), walk.walked_m, walk.goal.shortest_m, walk.seconds,
        walk.contacts.size(), walk.contacts_by_prompt());
    body += evaluation::scrolling(name, drawing.element(), "map");
    body += evaluation::scrolling(
        "what was heard on walk " + std::to_string(i + 1),
        evaluation::report_table(fmt::format("What was heard on walk {}", i + 1),
                                 {"", "prompt", "fault", "s"}, rows_of(walk), 3));
  }
  return evaluation::report_page(title, {note}, body);
}

}  // namespace roomwise::trials
