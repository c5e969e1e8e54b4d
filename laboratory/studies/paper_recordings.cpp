#include "laboratory/studies/paper_recordings.h"

#include <fmt/format.h>

#include <array>

namespace roomwise::studies {
namespace {

constexpr const char* kTum =
    "the Computer Vision Group of TU Munich keeps it at "
    "https://cvg.cit.tum.de/data/datasets/rgbd-dataset/download";

const std::array<PaperRecording, 6>& all_recordings() {
  static const std::array<PaperRecording, 6> all{
      {{"rgbd_dataset_freiburg1_desk", "fr1/desk", "fr1", kTum, true},
       {"rgbd_dataset_freiburg1_xyz", "fr1/xyz", "fr1", kTum, true},
       {"rgbd_dataset_freiburg2_xyz", "fr2/xyz", "fr2", kTum, true},
       {"rgbd_dataset_freiburg3_long_office_household", "fr3/long", "fr3", kTum, true},
       {"rgbd_dataset_freiburg1_rpy", "fr1/rpy", "fr1", kTum, false},
       {"office_walk", "office_walk", "",
        "it is hololens-dataset/000 of https://github.com/ardaduz/deep-video-mvs in the layout of "
        "TUM RGB-D",
        false}}};
  return all;
}

}  // namespace

std::span<const PaperRecording> paper_recordings() {
  return all_recordings();
}

const PaperRecording& office_walk() {
  return all_recordings().back();
}

const PaperRecording& room_photos() {
  static const PaperRecording photos{
      "room_photos", "room_photos", "",
      "it is a folder train and a folder eval, each with one folder of photos a room, of "
      "http://places2.csail.mit.edu (Places365)",
      false};
  return photos;
}

std::string missing_text(const PaperRecording& recording) {
  const std::string name = recording.title == recording.folder
                               ? recording.title
                               : fmt::format("{} ({})", recording.title, recording.folder);
  return fmt::format("{} is not in the folder of recordings; {}.", name, recording.publisher);
}

}  // namespace roomwise::studies
