#pragma once

#include <functional>

#include "laboratory/training/training_data.h"
#include "roomwise/home/home.h"

namespace roomwise::app {

// A home's key-frames in named ranges, by room. Holds their encoded pictures in memory.
class HomePictures final : public training::TrainingData {
 public:
  using Selects = std::function<bool(const recording::RoomRange&)>;
  // Of the home's last recording; classes are all its rooms, whatever is selected. Fails where
  // fewer than two rooms are named.
  [[nodiscard]] static Expected<HomePictures> read(const home::Home& home, const Selects& selects);

  [[nodiscard]] std::size_t size() const override { return pictures_.size(); }
  [[nodiscard]] const std::vector<std::string>& classes() const override { return rooms_; }
  [[nodiscard]] std::size_t label(std::size_t i) const override { return pictures_[i].room; }
  [[nodiscard]] std::string name(std::size_t i) const override;
  [[nodiscard]] Expected<image::ColorImage> picture(std::size_t i) const override;

 private:
  struct Picture {
    home::KeyframeId keyframe = 0;
    std::size_t room = 0;
    Bytes color;
  };
  std::string file_;
  std::vector<std::string> rooms_;
  std::vector<Picture> pictures_;
};

}  // namespace roomwise::app
