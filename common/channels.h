// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The names of all channels; docs/MAP.md lists type, frame, rate and publisher of each, and a test keeps the two equal.
#pragma once

namespace arpent::channels {

inline constexpr char kConfig[] = "CONFIG";
inline constexpr char kStereoImages[] = "STEREO_IMAGES";
inline constexpr char kTruthPose[] = "TRUTH_POSE";
inline constexpr char kDisparity[] = "DISPARITY";
inline constexpr char kDisparityFilled[] = "DISPARITY_FILLED";
inline constexpr char kDepth[] = "DEPTH";
inline constexpr char kOdometry[] = "ODOMETRY";
inline constexpr char kMapStatus[] = "MAP_STATUS";
inline constexpr char kWheelCommand[] = "WHEEL_COMMAND";
inline constexpr char kWheelState[] = "WHEEL_STATE";
inline constexpr char kBaseRequest[] = "BASE_REQUEST";
inline constexpr char kEstop[] = "ESTOP";
inline constexpr char kCan[] = "CAN";
inline constexpr char kImu[] = "IMU";
inline constexpr char kTagObservation[] = "TAG_OBSERVATION";
inline constexpr char kFrameAlignment[] = "FRAME_ALIGNMENT";
inline constexpr char kPose[] = "POSE";
inline constexpr char kPairPose[] = "PAIR_POSE";
inline constexpr char kPath[] = "PATH";
inline constexpr char kTrackerStatus[] = "TRACKER_STATUS";
inline constexpr char kMissionCommand[] = "MISSION_COMMAND";
inline constexpr char kMissionState[] = "MISSION_STATE";
// A team. What a robot sends, and the same as others receive it over the radio.
inline constexpr char kMapPatch[] = "MAP_PATCH";
inline constexpr char kTeamPatch[] = "TEAM_PATCH";
inline constexpr char kRobotState[] = "ROBOT_STATE";
inline constexpr char kTeamState[] = "TEAM_STATE";
inline constexpr char kTourReport[] = "TOUR_REPORT";
inline constexpr char kTeamReport[] = "TEAM_REPORT";
inline constexpr char kTour[] = "TOUR";
inline constexpr char kTeamTour[] = "TEAM_TOUR";
inline constexpr char kHealth[] = "HEALTH";

}  // namespace arpent::channels
