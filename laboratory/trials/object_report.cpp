#include "laboratory/trials/object_report.h"

#include <algorithm>

#include "roomwise/evaluation/drawing/framed_picture.h"
#include "roomwise/image/codec.h"

namespace roomwise::trials {
namespace {

using evaluation::FoundObject;
using evaluation::ObjectMatch;
using evaluation::ObjectReportContent;
using evaluation::PictureNote;
using evaluation::TrueObject;

constexpr int kPictureWidth_px = 320;

// `what`: "a true chair".
Expected<PictureNote> note_of(const home::Home& home, const ShownIn& shown, const std::string& kind,
                              const std::string& what, std::string text) {
  ROOMWISE_TRY(const home::KeyframeImages images, home.images(shown.keyframe));
  ROOMWISE_TRY(const image::ColorImage whole, image::decode_color(images.color));
  PictureNote note;
  note.heading = fmt::format("{}, key-frame {}", kind, shown.keyframe);
  Eigen::AlignedBox2f box;
  if (shown.box)
    box = {Eigen::Vector2f(shown.box->left, shown.box->top),
           Eigen::Vector2f(shown.box->right, shown.box->bottom)};
  note.picture = evaluation::framed_picture(whole, box, kPictureWidth_px);
  note.alt = fmt::format("Key-frame {}{} {}", shown.keyframe,
                         shown.box ? " with a frame about" : ", near", what);
  note.text = std::move(text);
  return note;
}

// "The nearest thing is a table, 0.12 m away".
std::string nearest_of(const ObjectEvaluation& evaluation, const FoundObject& found) {
  const auto distance_m = [&](const TrueObject& one) { return one.box.distance_m(found.position); };
  const auto nearest = std::ranges::min_element(evaluation.truth, {}, distance_m);
  if (nearest == evaluation.truth.end()) return "The walk showed nothing that the home can name.";
  return fmt::format("The nearest thing that the home has a word for: {}, {:.2f} m away.",
                     nearest->kind, distance_m(*nearest));
}

}  // namespace

Expected<ObjectReportContent> object_report(const home::Home& home, const std::string& title,
                                            const ObjectEvaluation& evaluation) {
  const FoundObjectErrors& things = evaluation.instances;
  ObjectReportContent content;
  content.title = title;
  content.notes = {
      fmt::format(
          "To be found is what the walk showed well: in four key-frames or more, from two metres "
          "or "
          "nearer, half a percent of the picture or more and 15 % of the rectangle about it. What "
          "was found beyond that counts neither way. A thing counts as found within {:g} m of its "
          "true box, by one of its names.",
          evaluation.max_distance_m),
      "Pictures are the key-frames that show a thing best; of what is missed, largest. The frame "
      "is "
      "what was found or, of what is missed, the true thing. Where there is none, a later visit "
      "saw "
      "the thing near that key-frame, or it lies in part behind the camera."};
  content.ways = {
      {"joined from regions", things.errors, things.without_place},
      {"naive clustering", evaluation.naive.errors, evaluation.naive.without_place},
      {"the paper's rules", evaluation.by_rules.errors, evaluation.by_rules.without_place}};
  content.shown_way = content.ways.front().name;
  content.reliability = evaluation::reliability_curve(evaluation.forecasts);
  const auto note_of_found = [&](std::size_t f, const std::string& what, std::string text) {
    return note_of(home, evaluation.instances_shown[f], things.found[f].kind, what,
                   std::move(text));
  };
  for (const std::size_t f : things.errors.wrong) {
    ROOMWISE_TRY(content.wrong.emplace_back(),
                 note_of_found(f, fmt::format("what was called {}", things.found[f].kind),
                               nearest_of(evaluation, things.found[f])));
  }
  for (const ObjectMatch& match : things.errors.duplicates) {
    ROOMWISE_TRY(
        content.duplicates.emplace_back(),
        note_of_found(match.found,
                      fmt::format("what was called {} once more", things.found[match.found].kind),
                      fmt::format("{:.2f} m from a {} that was found.", match.from_box_m,
                                  evaluation.truth[match.truth].kind)));
  }
  for (const std::size_t t : things.errors.missed) {
    if (!evaluation.truth_shown[t]) continue;  // what is expected is shown
    const std::string& kind = evaluation.truth[t].kind;
    ROOMWISE_TRY(content.missed.emplace_back(),
                 note_of(home, *evaluation.truth_shown[t], kind,
                         fmt::format("a {} that was missed", kind), "Not found."));
  }
  for (const ObjectMatch& match : things.errors.matches) {
    const TrueObject& truth = evaluation.truth[match.truth];
    ROOMWISE_TRY(content.found.emplace_back(),
                 note_of_found(match.found, fmt::format("the {}", things.found[match.found].kind),
                               fmt::format("{:.2f} m from the middle of the true {}{}.",
                                           match.from_center_m, truth.kind,
                                           truth.is_expected ? "" : ", which need not be found")));
  }
  return content;
}

}  // namespace roomwise::trials
