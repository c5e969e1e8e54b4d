#include "roomwise/network/vision/detector.h"

#include "roomwise/network/formats/network_file.h"
#include "roomwise/network/vision/picture_input.h"

namespace roomwise::network {

Expected<std::unique_ptr<Detector>> Detector::load(
    const std::filesystem::path& weights, const std::optional<std::filesystem::path>& labels) {
  const auto in_file = [&](Error error) { return std::move(error).with_context(weights.string()); };
  ROOMWISE_TRY(NetworkFile file, read_network_in_floats(weights, labels));
  if (!finds_things(file.card.task)) {
    return fail(
        "{}: its card does not say that it finds things (\"task\": \"nanodet-plus\", \"yolox\", "
        "\"yolov5\" or \"yolov8\")",
        weights.string());
  }
  if (file.labels.empty()) return fail("{}: a detector needs labels", weights.string());
  std::unique_ptr<Detector> detector(new Detector());
  ROOMWISE_TRY(detector->executor_, Executor::create(std::move(file.graph)).map_error(in_file));
  detector->card_ = std::move(file.card);
  detector->labels_ = std::move(file.labels);
  detector->fingerprint_ = std::move(file.fingerprint);
  const image::ColorImage black(detector->card().input_width_px, detector->card().input_height_px);
  ROOMWISE_RETURN_IF_ERROR(detector->detect(black, 1).map_error(in_file));
  return detector;
}

Expected<std::vector<Detection>> Detector::detect(const image::ColorImage& image,
                                                  float min_score) const {
  if (image.empty()) return fail("the picture has no pixels");
  const Tensor input = picture_input(image, card_);
  ROOMWISE_TRY(const std::vector<Tensor> outputs, executor_->run({&input, 1}));
  const std::vector<float>& values = outputs.front().values;
  const std::size_t expected = detector_output_size(card_, labels_.size());
  if (outputs.size() != 1 || values.size() != expected) {
    return fail("is no {} of {} labels: gives {} values, not {}", name_of(card_.task),
                labels_.size(), values.size(), expected);
  }
  std::vector<Detection> found = decode_detections(values, card_, labels_.size(), min_score);
  const PixelBox picture{0, 0, static_cast<float>(image.width()),
                         static_cast<float>(image.height())};
  const PictureScale scale = picture_scale(image, card_);
  for (Detection& detection : found) {
    const PixelBox& box = detection.box;
    detection.box = intersection({box.left / scale.across, box.top / scale.down,
                                  box.right / scale.across, box.bottom / scale.down},
                                 picture);
  }
  std::erase_if(found, [](const Detection& one) { return !(one.box.area() > 0); });
  return found;
}

}  // namespace roomwise::network
