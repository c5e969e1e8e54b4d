#pragma once

#include <string>
#include <vector>

#include "roomwise/rooms/recognition/room_decision.h"

// A home of three rooms for tests of what is made of its pictures.
namespace roomwise::rooms {

inline const std::vector<std::string> kRooms = {"bath", "hall", "kitchen"};
inline const std::vector<std::string> kWalk = {"hall", "bath", "hall", "kitchen", "hall"};

inline RoomCalibration calibration() {
  RoomCalibration calibration;
  calibration.confidence_threshold = 0.8;
  calibration.acceptance_threshold = -1;
  calibration.reject_threshold = -2;
  return calibration;
}

inline PictureEvidence evidence(double bath, double hall, double kitchen, double familiarity = 0) {
  return {Eigen::Vector3d(bath, hall, kitchen), familiarity};
}

}  // namespace roomwise::rooms
