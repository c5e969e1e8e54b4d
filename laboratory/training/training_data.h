#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/image/image.h"

namespace roomwise::training {

// Pictures and the class that each shows. All functions may be called from several threads at once.
class TrainingData {
 public:
  virtual ~TrainingData() = default;
  [[nodiscard]] virtual std::size_t size() const = 0;
  // The names of the classes, in the order of their numbers.
  [[nodiscard]] virtual const std::vector<std::string>& classes() const = 0;
  // The class of picture i: a number below classes().size().
  [[nodiscard]] virtual std::size_t label(std::size_t i) const = 0;
  // What picture i is called: tells it from all others, wherever the data lies.
  [[nodiscard]] virtual std::string name(std::size_t i) const = 0;
  [[nodiscard]] virtual Expected<image::ColorImage> picture(std::size_t i) const = 0;
};

// A folder with one folder a class, named after it, with .jpg, .jpeg and .png files in it. Classes
// and files are in the order of their names; what is hidden (.thumbnails) is none. Pictures are
// read when they are asked for.
class PictureFolder final : public TrainingData {
 public:
  // Fails where the folder cannot be read, and where there are fewer than two classes with a
  // picture.
  [[nodiscard]] static Expected<PictureFolder> open(const std::filesystem::path& folder);

  // The same pictures, their classes numbered as these are, of which some may have no picture here.
  // Fails where it has a class that is none of them.
  [[nodiscard]] Expected<PictureFolder> with_classes(std::vector<std::string> classes) &&;

  [[nodiscard]] std::size_t size() const override { return files_.size(); }
  [[nodiscard]] const std::vector<std::string>& classes() const override { return classes_; }
  [[nodiscard]] std::size_t label(std::size_t i) const override { return files_[i].label; }
  // CLASS/FILE
  [[nodiscard]] std::string name(std::size_t i) const override;
  [[nodiscard]] Expected<image::ColorImage> picture(std::size_t i) const override;

 private:
  struct File {
    std::filesystem::path path;
    std::size_t label = 0;
  };
  std::vector<std::string> classes_;
  std::vector<File> files_;
};

// Some pictures of other data, which must outlive it.
class DataPart final : public TrainingData {
 public:
  DataPart(const TrainingData& whole, std::vector<std::size_t> kept)
      : whole_(&whole), kept_(std::move(kept)) {}

  [[nodiscard]] std::size_t size() const override { return kept_.size(); }
  [[nodiscard]] const std::vector<std::string>& classes() const override {
    return whole_->classes();
  }
  [[nodiscard]] std::size_t label(std::size_t i) const override { return whole_->label(kept_[i]); }
  [[nodiscard]] std::string name(std::size_t i) const override { return whole_->name(kept_[i]); }
  [[nodiscard]] Expected<image::ColorImage> picture(std::size_t i) const override {
    return whole_->picture(kept_[i]);
  }

 private:
  const TrainingData* whole_;
  std::vector<std::size_t> kept_;
};

struct DataSplit {
  DataPart training, held_out;
};
// Holds this share of the pictures of each class out, drawn by `seed`; where the share is
// above 0, at least one, but for the last one of a class, which stays to be trained on.
[[nodiscard]] DataSplit split_data(const TrainingData& data, double held_out_share,
                                   std::uint64_t seed);

}  // namespace roomwise::training
