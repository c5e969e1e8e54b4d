#pragma once

#include "roomwise/geometry/pinhole_camera.h"
#include "roomwise/recording/messages/messages.h"

namespace roomwise::recording {

// The camera that a message describes: of the image as it is, or, where `is_rectified`, of the
// rectified one. Brown's lens model is taken as it is (plumb_bob); what differs from it (rational
// polynomial, RealSense's inverse and modified models) is fitted by it over the picture. Fails
// where the camera is impossible, the fit is off by more than a pixel somewhere, or the lens is a
// fish-eye.
[[nodiscard]] Expected<geometry::PinholeCamera> camera_of(const CameraInfoMessage& info,
                                                          bool is_rectified);

}  // namespace roomwise::recording
