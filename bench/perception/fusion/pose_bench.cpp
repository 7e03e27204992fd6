// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// bench `pose`: the fused pose over simulated drives with drawn scale, bias and noise
// (tests/perception/fusion/drive.h): its error beside those of its inputs alone, whether its covariance is honest, and
// CPU time per message.
#include <cmath>

#include "bench/harness.h"
#include "perception/fusion/continuous_pose.h"
#include "tests/perception/fusion/drive.h"

namespace arpent {
namespace {

using fusion::Drive;

constexpr int kSeeds = 50;

/// All messages in, a continuous pose out for each wheel state and a best one for each odometry, as pose_process does.
/// Returns how many messages.
std::size_t process(const Drive& drive) {
  fusion::PoseFusion fusion({});
  fusion::ContinuousPose continuous({});
  const auto all = fusion::deliveries(drive);
  std::size_t wheel = 0, pair = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    (void)all[i].add(fusion);
    const bool last_of_moment = i + 1 == all.size() || all[i + 1].at > all[i].at;
    if (!last_of_moment) continue;
    if (pair < drive.odometry.size() && drive.odometry[pair].stamp + std::chrono::milliseconds(130) == all[i].at) {
      (void)fusion.at(drive.odometry[pair++].stamp);
    }
    if (wheel < drive.wheels.size() && drive.wheels[wheel].stamp == all[i].at) {
      const auto before = continuous.last_stamp();
      (void)continuous.next(*fusion.at(drive.wheels[wheel++].stamp), before ? fusion.at(*before) : std::nullopt);
    }
  }
  return all.size();
}

void body(bench::Report& report) {
  double nees = 0, fused_m = 0, odometry_m = 0, wheels_m = 0, outage_m = 0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const Drive drive = fusion::make_drive(fusion::drawn(seed));
    fusion::PoseFusion fusion({}), dead_reckoning({}), outage({});
    const auto poses = fusion::run(fusion, drive);
    nees += fusion::planar_nees(poses.back(), drive) / kSeeds;
    fused_m += fusion::rms_m(poses, drive) / kSeeds;
    odometry_m += fusion::rms_m(fusion::odometry_alone(drive), drive) / kSeeds;
    Drive blind = drive, gap = drive;
    for (auto& o : blind.odometry) o.usable = o.anchored = o.sequence == 0;
    wheels_m += fusion::rms_m(fusion::run(dead_reckoning, blind), drive) / kSeeds;
    for (std::size_t i = 151; i < 176; ++i) gap.odometry[i].usable = gap.odometry[i].anchored = false;
    const auto gap_poses = fusion::run(outage, gap);
    const Vector6d added = local(gap_poses[150].T_frame_body.inverse() * gap_poses[175].T_frame_body,
                                 drive.truth.at(gap_poses[150].stamp).inverse() * drive.truth.at(gap_poses[175].stamp));
    outage_m += added.head<2>().norm() / kSeeds;
  }
  report.add("pose.ate_fused_mm", 1e3 * fused_m, "mm", "mean over 50 drives of 40 s");
  report.add("pose.ate_odometry_alone_mm", 1e3 * odometry_m, "mm");
  report.add("pose.ate_wheels_and_gyro_mm", 1e3 * wheels_m, "mm");
  report.add("pose.nees_planar", nees, "1", "honest: 3, bar 2 to 4");
  report.add("pose.outage_5s_mm", 1e3 * outage_m, "mm", "what 5 s without odometry add");
  const Drive drive = fusion::make_drive(fusion::drawn(1));
  std::vector<double> us, reference_ms;
  for (int i = 0; i < 7; ++i) {
    std::size_t messages = 0;
    const double ms = bench::cpu_ms([&] { messages = process(drive); });
    us.push_back(1e3 * ms / static_cast<double>(messages));
    reference_ms.push_back(bench::time_reference_once());
  }
  report.add("pose.us_per_message", bench::median(us), "us", "bar <= 50");
  report.add("pose.message_over_ref", bench::median(us) / 1e3 / bench::median(reference_ms), "1");
}

}  // namespace
}  // namespace arpent

int main(int argc, char** argv) {
  return arpent::bench::run(argc, argv, "The fused pose", arpent::body);
}
