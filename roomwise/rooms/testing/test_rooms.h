#pragma once

#include <string>
#include <vector>

#include "roomwise/rooms/recognition/room_decision.h"

// A home of three rooms for tests of what is made of its pictures.
namespace roomwise::rooms {

inline const std::vector<std::string> kRooms = {"bath", "hall", "kitchen"};
inline const std::vector<std::string> kWalk = {"hall", "bath", "hall", "kitchen", "hall"};

// Names a room from 0.8 on, and none below log odds of -2.
inline RoomModel test_model() {
  RoomModel model;
  model.min_probability = 0.8;
  model.reject_log_odds = -2;
  return model;
}

inline PictureEvidence evidence(double bath, double hall, double kitchen, double familiarity = 20) {
  return {Eigen::Vector3d(bath, hall, kitchen), familiarity};
}

}  // namespace roomwise::rooms
