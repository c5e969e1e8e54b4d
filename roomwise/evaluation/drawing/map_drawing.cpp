#include "roomwise/evaluation/drawing/map_drawing.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>
#include <vector>

#include "roomwise/evaluation/drawing/data_address.h"
#include "roomwise/evaluation/drawing/label_space.h"

namespace roomwise::evaluation {
namespace {

using Eigen::Vector2d;

constexpr int kMapJpegQuality = 85;
constexpr double kLegendRow_px = 40;  // px

// How the walk through a room is drawn.
struct RoomStyle {
  std::string name;
  std::string line;  // attributes of its lines
  std::string dot;   // and of its key-frames
};

// The named rooms by name, as every drawing of the home has them. Eight colours and seven patterns
// of dashes: rooms of one colour differ in their dashes, and only the 57th room looks like the
// first.
class RoomStyles {
 public:
  explicit RoomStyles(std::span<const MapKeyFrame> key_frames) {
    constexpr std::array<const char*, 7> kDashes = {"none",      "16 7",         "4 6", "22 6 4 6",
                                                    "10 4 10 9", "22 6 4 6 4 6", "8 8"};
    std::set<std::string> names;
    for (const MapKeyFrame& key_frame : key_frames) names.insert(key_frame.room);
    names.erase("");
    for (const std::string& name : names) {
      const std::size_t place = styles_.size();
      styles_.push_back({name,
                         fmt::format("class=\"path room-{}\" stroke-dasharray=\"{}\"",
                                     place % kColors, kDashes[place % kDashes.size()]),
                         fmt::format("class=\"key-frame dot-{}\"", place % kColors)});
    }
  }

  [[nodiscard]] const RoomStyle& of(const std::string& room) const {
    const RoomStyle* const style = find(room);
    return style != nullptr ? *style : unnamed_;
  }
  [[nodiscard]] const std::vector<RoomStyle>& named() const { return styles_; }
  [[nodiscard]] const RoomStyle& unnamed() const { return unnamed_; }

 private:
  [[nodiscard]] const RoomStyle* find(const std::string& room) const {
    const auto style = std::ranges::find(styles_, room, &RoomStyle::name);
    return style != styles_.end() ? &*style : nullptr;
  }
  std::vector<RoomStyle> styles_;
  RoomStyle unnamed_ = {"no room named", "class=\"path room-none\" stroke-dasharray=\"2 5\"",
                        "class=\"key-frame dot-none\""};
};

void draw_walk(SvgDrawing& drawing, const TopView& view, std::span<const MapKeyFrame> key_frames,
               const RoomStyles& styles) {
  std::vector<Vector2d> walk;
  for (const MapKeyFrame& key_frame : key_frames) walk.push_back(view.to_px(key_frame.place_world));
  drawing.polyline(walk, "class=\"casing\"");
  // A stretch within one room, drawn on to the first key-frame of the next.
  for (std::size_t begin = 0; begin < walk.size();) {
    std::size_t end = begin + 1;
    while (end < walk.size() && key_frames[end].room == key_frames[begin].room) ++end;
    const std::size_t last = std::min(end, walk.size() - 1);
    drawing.polyline(std::span(walk).subspan(begin, last - begin + 1),
                     styles.of(key_frames[begin].room).line);
    begin = end;
  }
  constexpr double kDotRadius = 5;
  for (std::size_t i = 0; i < walk.size(); ++i) {
    drawing.circle(walk[i], kDotRadius, styles.of(key_frames[i].room).dot);
  }
}

// Walk by walk: between two nobody went.
void draw_walks(SvgDrawing& drawing, const TopView& view, std::span<const MapKeyFrame> key_frames,
                const RoomStyles& styles) {
  while (!key_frames.empty()) {
    const auto next = std::ranges::find_if(key_frames.subspan(1), &MapKeyFrame::begins_walk);
    const auto count = static_cast<std::size_t>(next - key_frames.begin());
    draw_walk(drawing, view, key_frames.first(count), styles);
    key_frames = key_frames.subspan(count);
  }
}

// The key-frame of the room that is nearest to all others of it.
Vector2d centre_of_room(const TopView& view, std::span<const MapKeyFrame> key_frames,
                        const std::string& room) {
  std::vector<Vector2d> places;
  for (const MapKeyFrame& key_frame : key_frames) {
    if (key_frame.room == room) places.push_back(view.to_px(key_frame.place_world));
  }
  const auto distance_to_all = [&](const Vector2d& place) {
    double sum = 0;
    for (const Vector2d& other : places) sum += (place - other).norm();
    return sum;
  };
  return *std::ranges::min_element(places, {}, distance_to_all);
}

void draw_room_names(SvgDrawing& drawing, const TopView& view,
                     std::span<const MapKeyFrame> key_frames, const RoomStyles& styles,
                     LabelSpace& space) {
  constexpr double kFont = 28;
  for (const RoomStyle& style : styles.named()) {
    const Vector2d centre = centre_of_room(view, key_frames, style.name);
    // Moved down row by row where the name of another room stands.
    const double half_width = LabelSpace::width_of(style.name, kFont) / 2;
    LabelSpace::Box box = LabelSpace::of_text(centre - Vector2d(half_width, 0), style.name, kFont);
    double down = 0;
    constexpr int kMaxRows = 4;
    for (int row = 0; row < kMaxRows && !space.is_free(box); ++row) {
      down += kFont;
      box.low.y() += kFont;
      box.high.y() += kFont;
    }
    space.take(box);
    drawing.text(centre + Vector2d(0, down), style.name, "class=\"on-map room-name middle\"");
  }
}

// Its marker; what lies beyond the picture has it at the rim, whole.
Vector2d marker_of(const MapObject& object, const TopView& view, double radius) {
  const Eigen::Array2d last(view.picture.width() - radius, view.picture.height() - radius);
  return view.to_px(object.place_world).array().min(last).max(radius);
}

void draw_objects(SvgDrawing& drawing, const TopView& view, std::span<const MapObject> objects,
                  LabelSpace& space) {
  constexpr double kRadius = 15;
  constexpr double kFont = 20;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const Vector2d centre = marker_of(objects[i], view, kRadius);
    drawing.circle(centre, kRadius, "class=\"object\"");
    drawing.text(centre + Vector2d(0, 6), std::to_string(i + 1), "class=\"object-number middle\"");
    space.take({centre.array() - kRadius, centre.array() + kRadius});
  }
  // A name stands where there is room for it; the number always says which object it is.
  for (const MapObject& object : objects) {
    const Vector2d centre = marker_of(object, view, kRadius);
    const double width = LabelSpace::width_of(object.name, kFont);
    const std::array<Vector2d, 4> starts = {centre + Vector2d(kRadius + 6, 7),
                                            centre + Vector2d(-kRadius - 6 - width, 7),
                                            centre + Vector2d(-width / 2, kRadius + kFont),
                                            centre + Vector2d(-width / 2, -kRadius - 8)};
    for (const Vector2d& start : starts) {
      const LabelSpace::Box box = LabelSpace::of_text(start, object.name, kFont);
      if (!space.is_free(box)) continue;
      space.take(box);
      drawing.text(start, object.name, "class=\"on-map\"");
      break;
    }
  }
}

// One entry of the legend, and where it begins.
struct LegendEntry {
  const RoomStyle* style;
  Vector2d place = Vector2d::Zero();
};

// Entries side by side, in as many rows as the width asks for; below the ruler, which stands first.
std::vector<LegendEntry> lay_out_legend(const RoomStyles& styles,
                                        std::span<const MapKeyFrame> key_frames, double width,
                                        const Vector2d& start) {
  std::vector<LegendEntry> entries;
  for (const RoomStyle& style : styles.named()) entries.push_back({&style});
  const bool some_unnamed =
      std::ranges::any_of(key_frames, [](const MapKeyFrame& k) { return k.room.empty(); });
  if (some_unnamed) entries.push_back({&styles.unnamed()});
  Vector2d place = start;
  for (LegendEntry& entry : entries) {
    const double entry_width = 110 + LabelSpace::width_of(entry.style->name, 20);
    if (place.x() + entry_width > width && place.x() > 24) place = {24, place.y() + kLegendRow_px};
    entry.place = place;
    place.x() += entry_width;
  }
  return entries;
}

void draw_ruler(SvgDrawing& drawing, const Vector2d& start, double metre_px) {
  const Vector2d end = start + Vector2d(metre_px, 0);
  drawing.line(start, end, "class=\"ruler\"");
  for (const Vector2d& tip : {start, end}) {
    drawing.line(tip - Vector2d(0, 7), tip + Vector2d(0, 7), "class=\"ruler\"");
  }
  drawing.text(end + Vector2d(12, 7), "1 m", "class=\"on-map\"");
}

}  // namespace

SvgDrawing draw_map(const TopView& view, std::span<const MapKeyFrame> key_frames,
                    std::span<const MapObject> objects) {
  const Vector2d picture_size(view.picture.width(), view.picture.height());
  const RoomStyles styles(key_frames);
  const Vector2d ruler_start(24, picture_size.y() + kLegendRow_px / 2 + 6);
  const auto legend = lay_out_legend(styles, key_frames, picture_size.x(),
                                     ruler_start + Vector2d(view.pixels_per_metre + 90, 0));
  const double bottom =
      (legend.empty() ? ruler_start.y() : legend.back().place.y()) + kLegendRow_px - 10;

  SvgDrawing drawing(picture_size.x(), bottom,
                     fmt::format("Map from above: {} key-frames, {} named rooms, objects: {}",
                                 key_frames.size(), styles.named().size(), objects.size()));
  drawing.rectangle({0, 0}, drawing.size(), "class=\"map-paper\"");
  drawing.picture({0, 0}, picture_size, jpeg_address(view.picture, kMapJpegQuality));
  draw_walks(drawing, view, key_frames, styles);
  LabelSpace space(picture_size);
  draw_room_names(drawing, view, key_frames, styles, space);
  draw_objects(drawing, view, objects, space);
  draw_ruler(drawing, ruler_start, view.pixels_per_metre);
  for (const LegendEntry& entry : legend) {
    const Vector2d sample(70, 0);
    drawing.line(entry.place, entry.place + sample, entry.style->line);
    drawing.circle(entry.place + sample / 2, 6, entry.style->dot);
    drawing.text(entry.place + sample + Vector2d(10, 7), entry.style->name, "class=\"on-map\"");
  }
  return drawing;
}

}  // namespace roomwise::evaluation
