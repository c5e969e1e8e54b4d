#pragma once

#include <string>
#include <vector>

#include "roomwise/rooms/room_decision.h"

// A home of three rooms for tests of what is made of its pictures.
namespace roomwise::rooms {

inline const std::vector<std::string> kRooms = {"bath", "hall", "kitchen"};
inline const std::vector<std::string> kWalk = {"hall", "bath", "hall", "kitchen", "hall"};

inline RoomCalibration calibration() {
  RoomCalibration calibration;
  calibration.sure_from = 0.8;
  calibration.known_from = -1;
  calibration.none_below = -2;
  return calibration;
}

inline PictureEvidence evidence(double bath, double hall, double kitchen, double known = 0) {
  return {Eigen::Vector3d(bath, hall, kitchen), known};
}

}  // namespace roomwise::rooms
