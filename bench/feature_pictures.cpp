#include "feature_pictures.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "roomwise/image/codec.h"
#include "roomwise/image/resample.h"

namespace roomwise::bench {

namespace fs = std::filesystem;

Expected<std::vector<image::GrayImage>> load_feature_pictures(int a_recording) {
  const char* data = std::getenv("ROOMWISE_DATA");
  if (data == nullptr) return fail("set ROOMWISE_DATA to the folder of the recordings");
  std::vector<image::GrayImage> pictures;
  for (const char* recording : {"rgbd_dataset_freiburg1_rpy", "office_walk"}) {
    const fs::path folder = fs::path(data) / recording / "rgb";
    if (!fs::is_directory(folder)) return fail("there is no folder {}", folder.string());
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
    if (files.empty()) return fail("{} holds no picture", folder.string());
    std::ranges::sort(files);
    for (int i = 0; i < a_recording; ++i) {
      const auto place = static_cast<std::size_t>(2 * i + 1) * files.size() /
                         static_cast<std::size_t>(2 * a_recording);
      ROOMWISE_TRY(const image::ColorImage picture, image::read_color(files[place]));
      pictures.push_back(image::to_gray(picture));
    }
  }
  return pictures;
}

}  // namespace roomwise::bench
