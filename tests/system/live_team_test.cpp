// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// `arpent mission --live --robots 2` as a user starts it: two robots and a centre as processes in networks of their
// own, real links between them over a hub that loses and delays frames, in real time. What must come across comes
// across, and the mission's own limit and Ctrl-C both end it in order.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <arpent/pose_t.hpp>
#include <arpent/tour_t.hpp>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/log/event_log.h"
#include "common/net/tap_hub.h"
#include "drivers/base/wire.h"
#include "tests/system/live_program.h"

namespace arpent {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::HasSubstr;

template <class Message>
Message decoded(BytesView bytes) {
  Message message;
  std::string fault;
  EXPECT_TRUE(decode_guarded(bytes, message, fault)) << fault;
  return message;
}

class LiveTeam : public testing::Test {
 protected:
  void SetUp() override {
    // Asked in a process of its own: the question moves who asks into another network.
    const pid_t asker = fork();
    if (asker == 0) _exit(radio_network_refused().empty() ? 0 : 1);
    int status = 0;
    waitpid(asker, &status, 0);
    if (status != 0) GTEST_SKIP() << "no network namespaces with a TAP interface here";
    fs::create_directories(out_);
  }
  ~LiveTeam() override {
    mission_.end();
    fs::remove_all(out_);
  }

  void start(const std::vector<std::string>& arguments, int robots = 2) {
    std::vector<std::string> words{ARPENT_BIN_DIR "/arpent-mission",
                                   ARPENT_SOURCE_DIR "/config/missions/test_arena.yaml",
                                   "--live",
                                   "--robots",
                                   std::to_string(robots),
                                   "--sensing",
                                   "depth",
                                   "--out",
                                   out_.string()};
    words.insert(words.end(), arguments.begin(), arguments.end());
    mission_.start(words);
  }
  [[nodiscard]] std::string text_of(const char* file) const {
    std::stringstream text;
    text << std::ifstream(out_ / file).rdbuf();
    return text.str();
  }

  /// What a station's log says.
  struct Heard {
    std::map<std::string, int> count;
    std::set<std::string> tours_for;  ///< names on TEAM_TOUR
    double moved_m = 0, turned_rad = 0;
    base::WheelState last_wheels;
  };
  [[nodiscard]] Heard log_of(const std::string& station) const {
    Heard heard;
    std::optional<pose_t> before;
    LogReader log(out_ / station / "mission.lcmlog");
    while (const auto event = log.next()) {
      ++heard.count[event->channel];
      if (event->channel == channels::kTeamTour) {
        heard.tours_for.insert(decoded<tour_t>(event->data).robot);
      } else if (event->channel == channels::kWheelState) {
        heard.last_wheels = *base::from_wire(decoded<wheel_state_t>(event->data));
      } else if (event->channel == channels::kTruthPose) {
        const auto now = decoded<pose_t>(event->data);
        if (before) {
          heard.moved_m +=
              std::hypot(now.position_m[0] - before->position_m[0], now.position_m[1] - before->position_m[1]);
          heard.turned_rad += 2 * std::abs(now.orientation_wxyz[3] * before->orientation_wxyz[0] -
                                           now.orientation_wxyz[0] * before->orientation_wxyz[3]);
        }
        before = now;
      }
    }
    EXPECT_EQ(log.damage().bytes, 0) << station;
    return heard;
  }
  void expect_at_rest(const Heard& robot) const {
    EXPECT_EQ(robot.last_wheels.gate, base::GateState::kDisarmed);
    EXPECT_EQ(robot.last_wheels.status.commanded, Twist2{});
  }
  [[nodiscard]] double figure(const std::string& name) const {
    for (const auto& row : nlohmann::json::parse(text_of("mission.json"))) {
      if (row.at("name") == "test_arena." + name) return row.at("value").get<double>();
    }
    ADD_FAILURE() << "no figure " << name;
    return 0;
  }

  fs::path out_ = fs::path(testing::TempDir()) /
                  (std::string("live_team_") + testing::UnitTest::GetInstance()->current_test_info()->name());
  LiveProgram mission_{out_ / "said"};
};

TEST_F(LiveTeam, TwoRobotsExploreUnderOnePlan) {
  // From the outer two of the arena's starts: neither has to wait for the other before it can turn.
  start({"--set", "mission.max_time_s=20", "--set", "start=1"});
  EXPECT_EQ(mission_.exit_code(170s), 1) << mission_.said();
  for (const std::string name : {"R1", "R2"}) {
    const Heard robot = log_of(name);
    EXPECT_THAT(robot.tours_for, testing::Contains(name)) << "a tour came over the link";
    EXPECT_GT(robot.moved_m + robot.turned_rad, 0.3) << name;
    for (const char* channel : {channels::kConfig, channels::kMapPatch, channels::kTeamPatch, channels::kTeamState,
                                channels::kRobotState, channels::kPose, channels::kMissionState}) {
      EXPECT_GT(robot.count.at(channel), 0) << name << " " << channel;
    }
    expect_at_rest(robot);
    EXPECT_FALSE(fs::exists(out_ / name / "live.lcmlog")) << "the raw log has become mission.lcmlog";
  }
  const Heard centre = log_of("centre");
  EXPECT_GT(centre.count.at(channels::kTeamPatch), 5);
  EXPECT_GT(fs::file_size(out_ / "mesh.ply"), 10000U);
  EXPECT_GT(fs::file_size(out_ / "report.html"), 1000U);
  EXPECT_GT(figure("coverage_percent"), 20);
  EXPECT_EQ(figure("overlaps"), 0);
  EXPECT_LT(figure("least_gap_m"), 3);
  EXPECT_GT(figure("team_mb_TEAM_PATCH"), 0.05);
  EXPECT_GT(figure("team_mb"), figure("team_mb_TEAM_PATCH") + figure("team_mb_TEAM_STATE"));
}

TEST_F(LiveTeam, CtrlCEndsItInOrderAndADeadRobotHoldsNothingUp) {
  start({"--kill", "R2@1"});
  ASSERT_TRUE(wait_until(
      [this] { return text_of("launch.log").find("R2/mission_process ended with code 137") != std::string::npos; },
      120s))
      << mission_.said();
  mission_.interrupt();
  EXPECT_EQ(mission_.exit_code(90s), 1) << mission_.said();
  expect_at_rest(log_of("R1"));
  EXPECT_GT(log_of("R2").count.at(channels::kTruthPose), 0);
  EXPECT_GT(log_of("centre").count.at(channels::kTeamState), 0);
  EXPECT_THAT(mission_.said(), HasSubstr("report"));
}

TEST_F(LiveTeam, MoreRobotsThanStartsIsOneErrorBeforeAnythingStarts) {
  start({}, 4);
  EXPECT_EQ(mission_.exit_code(60s), 2);
  EXPECT_THAT(mission_.said(), HasSubstr("start 3"));
  EXPECT_FALSE(fs::exists(out_ / "launch.log"));
}

}  // namespace
}  // namespace arpent
