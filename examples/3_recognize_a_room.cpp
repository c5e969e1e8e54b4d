// Which room of a home do two pictures show?
//   3_recognize_a_room HOME NETWORK FIRST SECOND

#include <fmt/format.h>

#include "roomwise/image/codec.h"
#include "roomwise/network/vision/onnx_classifier.h"
#include "roomwise/pipeline/rooms/room_recognizer.h"

using namespace roomwise;

static Expected<rooms::RoomDecision> recognize(char** arguments) {
  ROOMWISE_TRY(const home::Home home, home::Home::open_read_only(arguments[0]));
  pipeline::Networks networks;
  ROOMWISE_TRY(auto network, network::OnnxClassifier::load(arguments[1]));
  networks.push_back(std::move(network));
  ROOMWISE_TRY(const auto recognizer, pipeline::RoomRecognizer::create(home, networks));
  ROOMWISE_TRY(const image::ColorImage first, image::read_color(arguments[2]));
  ROOMWISE_TRY(const image::ColorImage second, image::read_color(arguments[3]));
  return recognizer.recognize(std::vector{first, second});
}

int main(int argc, char** argv) {
  if (argc != 5) {
    fmt::print(stderr, "usage: {} HOME NETWORK FIRST SECOND\n", argv[0]);
    return 2;
  }
  const auto answer = recognize(argv + 1);
  if (!answer) {
    fmt::print(stderr, "{}\n", answer.error().message);
    return 1;
  }
  fmt::print("{}: {}\n", answer->room().value_or(std::string(to_string(answer->verdict))),
             answer->why);
  return 0;
}
