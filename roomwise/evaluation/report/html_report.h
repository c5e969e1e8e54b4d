#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "roomwise/evaluation/drawing/map_drawing.h"
#include "roomwise/evaluation/errors/trajectory_error.h"
#include "roomwise/evaluation/report/report_page.h"
#include "roomwise/evaluation/statistics/confusion_matrix.h"

namespace roomwise::evaluation {

// What a report says about a home, as plain values. A part that is empty or absent is left out of
// the page, or the page says that there is nothing.
struct ReportContent {
  struct Stage {
    std::string name;
    std::uint64_t calls = 0;
    double wall_s = 0;
    double cpu_s = 0;
  };
  struct Object {
    MapObject object;
    double score = 0;                // of the network, 0 to 1, in the picture below
    std::uint64_t observations = 0;  // key-frames in which it was recognised
    std::string room;                // on whose floor it stands; empty: not known
    std::string seen_from;           // the room from which it was seen best; empty: not known
    image::ColorImage picture;       // the key-frame with the highest score; empty: none
  };
  struct Room {
    std::string name;
    std::string type;  // "bedroom"; empty: not given
    std::uint64_t key_frames = 0;
    std::string recognition;  // how it is recognised; empty: not learned
  };
  struct Recognition {
    std::string rule;          // "one frame", "two frames"
    Proportion top1_correct;   // of all answers: the most probable room, said or not
    Interval top1_interval;    // 95 %
    Proportion named_correct;  // of the answers that named a room
    Interval named_interval;   // 95 %
    std::string resampled;     // what the intervals resample: "visits"
    double ms = 0;             // per answer
    ConfusionMatrix confusion;
  };

  std::string home;                   // its name, the page's title
  std::vector<std::string> warnings;  // what the reader must know before trusting the rest
  std::vector<NamedFigure> summary;
  std::optional<TopView> map;
  std::vector<MapKeyFrame> key_frames;  // in the order of the walk
  std::vector<Room> rooms;
  std::vector<Object> objects;
  std::vector<Recognition> recognition;
  std::optional<AbsoluteTrajectoryError> trajectory_error;
  std::optional<Eigen::Vector3d> truth_up;  // up in the frame of the true trajectory, for its plot
  std::vector<Stage> stages;
};

// One page of HTML that needs nothing else: no scripts, no requests, styles and pictures inside. It
// is written for everybody (WCAG 2.2 AA): headings in order, tables with captions, texts for
// pictures, light and dark by the reader's choice, and it fits a phone.
[[nodiscard]] std::string render_report(const ReportContent& content);

}  // namespace roomwise::evaluation
