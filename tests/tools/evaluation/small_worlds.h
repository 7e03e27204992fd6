// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Small worlds for tests of what can be seen, and the robot in them.
#pragma once

#include <numbers>
#include <string>

#include "sim/world/world.h"
#include "tools/evaluation/legal_views.h"

namespace arpent::evaluation {

/// A room of 5 x 4 x 1.5 m without a ceiling, with what `more` adds; the robot starts at (1, 2).
inline sim::World room_with(const std::string& more) {
  return sim::parse_world(R"(
name: room
region: {min_m: [0, 0, 0], max_m: [5, 4, 1.5]}
textures: {plain: {kind: plain}}
surfaces:
  - plane: {corner_m: [0, 0, 0], u_m: [5, 0, 0], v_m: [0, 4, 0], texture: plain}
  - plane: {corner_m: [5, 0, 0], u_m: [-5, 0, 0], v_m: [0, 0, 1.5], texture: plain}
  - plane: {corner_m: [5, 4, 0], u_m: [0, -4, 0], v_m: [0, 0, 1.5], texture: plain}
  - plane: {corner_m: [0, 4, 0], u_m: [5, 0, 0], v_m: [0, 0, 1.5], texture: plain}
  - plane: {corner_m: [0, 0, 0], u_m: [0, 4, 0], v_m: [0, 0, 1.5], texture: plain}
)" + more + R"(lighting: {lamps: [{position_m: [2, 2, 3]}]}
starts: [{x_m: 1.0, y_m: 2.0, yaw_rad: 0}]
)",
                          "room");
}

/// Slopes of 377 px and 640 x 512 px, in round numbers; 0.40 m above ground.
inline LegalViewParams small_robot() {
  LegalViewParams params;
  params.camera = {.left_slope = 0.85,
                   .right_slope = 0.85,
                   .up_slope = 0.68,
                   .down_slope = 0.68,
                   .baseline_m = 0.26,
                   .p_body_m = {0.20, 0.13, 0.40}};
  return params;
}

}  // namespace arpent::evaluation
