#pragma once

// What most tests include; see add_shared_headers in RoomwiseBuild.cmake.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "module_headers.h"
