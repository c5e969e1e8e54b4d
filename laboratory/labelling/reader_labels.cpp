#include "laboratory/labelling/reader_labels.h"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "roomwise/base/file.h"

namespace roomwise::labelling {
namespace {

using Json = nlohmann::ordered_json;

Expected<CutBorders> cut_from(const Json& json) {
  CutBorders cut;
  for (const Json& border : json) {
    const auto name = border.get<std::string>();
    if (name == "left")
      cut.left = true;
    else if (name == "top")
      cut.top = true;
    else if (name == "right")
      cut.right = true;
    else if (name == "bottom")
      cut.bottom = true;
    else
      return fail("'{}' is no border of a picture; give left, top, right or bottom", name);
  }
  return cut;
}

Expected<LabelledView> view_from(const Json& json) {
  LabelledView view;
  json.at("frame").get_to(view.frame);
  const auto box = json.at("box").get<std::array<float, 4>>();
  view.box = {box[0], box[1], box[2], box[3]};
  // Written so that NaN fails, too.
  if (!(box[0] < box[2] && box[1] < box[3] && std::isfinite(box[2] - box[0] + box[3] - box[1]))) {
    return fail("its box in frame {} is empty; give left < right and top < bottom", view.frame);
  }
  ROOMWISE_TRY(view.cut, cut_from(json.value("cut", Json::array())));
  view.is_occluded = json.value("occluded", false);
  return view;
}

Expected<LabelledThing> thing_from(const Json& json) {
  LabelledThing thing;
  json.at("id").get_to(thing.id);
  json.at("name").get_to(thing.name);
  thing.is_name_sure = json.value("sure", true);
  thing.sides = json.value("side", std::vector<std::string>{});
  thing.note = json.value("note", "");
  thing.is_transient = json.value("transient", false);
  for (const Json& view : json.at("views")) {
    auto read = view_from(view);
    if (!read) return fail("thing {} ({}): {}", thing.id, thing.name, read.error().message);
    thing.views.push_back(*read);
  }
  return thing;
}

Expected<ReaderLabels> labels_from(const Json& json) {
  ReaderLabels labels;
  json.at("recording").get_to(labels.recording);
  json.at("reader").get_to(labels.reader);
  std::set<std::int64_t> ids;
  for (const Json& thing : json.at("things")) {
    ROOMWISE_TRY(labels.things.emplace_back(), thing_from(thing));
    const LabelledThing& last = labels.things.back();
    if (!ids.insert(last.id).second) return fail("two things have the id {}", last.id);
  }
  return labels;
}

Json to_json(const CutBorders& cut) {
  Json json = Json::array();
  if (cut.left) json.push_back("left");
  if (cut.top) json.push_back("top");
  if (cut.right) json.push_back("right");
  if (cut.bottom) json.push_back("bottom");
  return json;
}

Json to_json(const LabelledThing& thing) {
  Json views = Json::array();
  for (const LabelledView& view : thing.views) {
    const network::PixelBox& box = view.box;
    views.push_back({{"frame", view.frame},
                     {"box", {box.left, box.top, box.right, box.bottom}},
                     {"cut", to_json(view.cut)},
                     {"occluded", view.is_occluded}});
  }
  return {{"id", thing.id},
          {"name", thing.name},
          {"sure", thing.is_name_sure},
          {"side", thing.sides},
          {"views", views},
          {"note", thing.note},
          {"transient", thing.is_transient}};
}

}  // namespace

Json to_json(const ReaderLabels& labels) {
  Json things = Json::array();
  for (const LabelledThing& thing : labels.things) things.push_back(to_json(thing));
  return {{"recording", labels.recording}, {"reader", labels.reader}, {"things", things}};
}

Expected<ReaderLabels> read_reader_labels(const std::filesystem::path& path) {
  ROOMWISE_TRY(const std::string text, read_text_file(path));
  try {
    auto labels = labels_from(Json::parse(text));
    if (!labels) return fail("{}: {}", path.string(), labels.error().message);
    return labels;
  } catch (const Json::exception& error) {
    return fail("{}: is no file of a reader's labels: {}", path.string(), error.what());
  }
}

}  // namespace roomwise::labelling
