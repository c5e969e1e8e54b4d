#include "laboratory/training/training_data.h"

#include <algorithm>
#include <cmath>

#include "roomwise/base/random.h"
#include "roomwise/image/codec.h"
#include "roomwise/image/picture_files.h"

namespace roomwise::training {
namespace {

namespace fs = std::filesystem;

// What stands in a folder, by name, but for what is hidden.
Expected<std::vector<fs::path>> entries_of(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> entries;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    if (!entry->path().filename().string().starts_with('.')) entries.push_back(entry->path());
  }
  if (error) return fail("{}: cannot be read: {}", folder.string(), error.message());
  std::ranges::sort(entries);
  return entries;
}

}  // namespace

Expected<PictureFolder> PictureFolder::open(const fs::path& folder) {
  PictureFolder data;
  ROOMWISE_TRY(const auto folders, entries_of(folder));
  for (const fs::path& of_class : folders) {
    std::error_code ignored;
    if (!fs::is_directory(of_class, ignored)) continue;
    ROOMWISE_TRY(const auto files, entries_of(of_class));
    const std::size_t before = data.files_.size();
    for (const fs::path& file : files) {
      if (image::has_ending_of_picture(file)) data.files_.push_back({file, data.classes_.size()});
    }
    if (data.files_.size() > before) data.classes_.push_back(of_class.filename().string());
  }
  if (data.classes_.size() < 2) {
    return fail(
        "{}: has pictures of {} classes; expected one folder a class, two at least, with .jpg or "
        ".png files in it",
        folder.string(), data.classes_.size());
  }
  return data;
}

Expected<PictureFolder> PictureFolder::with_classes(std::vector<std::string> classes) && {
  std::vector<std::size_t> numbers;
  for (const std::string& name : classes_) {
    const auto found = std::ranges::find(classes, name);
    if (found == classes.end())
      return fail("has the class \"{}\", which is none of {}", name, fmt::join(classes, ", "));
    numbers.push_back(static_cast<std::size_t>(found - classes.begin()));
  }
  for (File& file : files_) file.label = numbers[file.label];
  classes_ = std::move(classes);
  return std::move(*this);
}

std::string PictureFolder::name(std::size_t i) const {
  return fmt::format("{}/{}", classes_[files_[i].label], files_[i].path.filename().string());
}

Expected<image::ColorImage> PictureFolder::picture(std::size_t i) const {
  return image::read_color(files_[i].path);
}

DataSplit split_data(const TrainingData& data, double held_out_share, std::uint64_t seed) {
  std::vector<std::size_t> training, held_out;
  for (std::size_t label = 0; label < data.classes().size(); ++label) {
    std::vector<std::size_t> of_class;
    for (std::size_t i = 0; i < data.size(); ++i) {
      if (data.label(i) == label) of_class.push_back(i);
    }
    RandomStream random(seed, {label});
    for (std::size_t i = of_class.size(); i > 1; --i)
      std::swap(of_class[i - 1], of_class[random.index(i)]);
    const double wanted = held_out_share * static_cast<double>(of_class.size());
    auto count = static_cast<std::size_t>(std::lround(wanted));
    if (held_out_share > 0) count = std::max<std::size_t>(count, 1);
    count = std::min(count, std::max<std::size_t>(of_class.size(), 1) - 1);
    const auto end = of_class.begin() + static_cast<std::ptrdiff_t>(count);
    held_out.insert(held_out.end(), of_class.begin(), end);
    training.insert(training.end(), end, of_class.end());
  }
  std::ranges::sort(training);
  std::ranges::sort(held_out);
  return {DataPart(data, std::move(training)), DataPart(data, std::move(held_out))};
}

}  // namespace roomwise::training
