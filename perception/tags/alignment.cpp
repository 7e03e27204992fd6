// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/tags/alignment.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "common/config/config.h"
#include "common/error.h"

namespace arpent::tags {
namespace {

/// 99.9 % of 6 degrees of freedom.
constexpr double kAgreementGate = 22.46;
constexpr int kAveragePasses = 4;

bool agree(const AlignmentView& a, const AlignmentView& b) {
  const Vector6d d = local(a.T_world_odom, b.T_world_odom);
  return d.dot((a.covariance + b.covariance).ldlt().solve(d)) < kAgreementGate;
}

}  // namespace

AlignmentView make_view(Time stamp, const Pose& T_world_body, const Matrix6d& covariance_body, const Pose& T_odom_body,
                        const Matrix6d& covariance_odom_body) {
  // T_world_body exp(d) T_odom_body^-1 = T_world_odom exp(Ad(T_odom_body) d), and the same for an error of the
  // odometry.
  const Matrix6d Ad = adjoint(T_odom_body);
  return {stamp, T_world_body * T_odom_body.inverse(), Ad * (covariance_body + covariance_odom_body) * Ad.transpose()};
}

FrameAligner::FrameAligner(const AlignmentParams& params, const GroundParams& ground)
    : params_(params), ground_(ground) {
  config::check(params, "alignment");
  config::check(ground, "ground");
  if (params.max_views < params.views) throw InputError("alignment: max_views must be >= views");
}

void FrameAligner::forget(Time stamp) {
  views_.clear();
  alignment_.reset();
  forgotten_ = stamp;
}

/// The most views that agree with one of them.
std::deque<AlignmentView> FrameAligner::largest_agreement() const {
  std::deque<AlignmentView> largest;
  for (const AlignmentView& reference : views_) {
    std::deque<AlignmentView> agreeing;
    std::copy_if(views_.begin(), views_.end(), std::back_inserter(agreeing),
                 [&](const AlignmentView& v) { return agree(reference, v); });
    if (agreeing.size() > largest.size()) largest = std::move(agreeing);
  }
  return largest;
}

Alignment FrameAligner::average(const std::deque<AlignmentView>& views) const {
  Alignment result;
  result.T_world_odom = views.back().T_world_odom;
  Matrix6d information;
  for (int pass = 0; pass < kAveragePasses; ++pass) {
    information.setZero();
    Vector6d weighted = Vector6d::Zero();
    for (const AlignmentView& view : views) {
      const Matrix6d W = view.covariance.ldlt().solve(Matrix6d::Identity());
      information += W;
      weighted += W * local(result.T_world_odom, view.T_world_odom);
    }
    result.T_world_odom = retract(result.T_world_odom, information.ldlt().solve(weighted));
  }
  const auto n = static_cast<double>(views.size());
  const Matrix6d independent = information.ldlt().solve(Matrix6d::Identity());
  const Matrix6d covariance = independent * (1 + params_.shared * (n - 1));
  const GroundedPose grounded = put_on_ground(result.T_world_odom, covariance, ground_);
  result.stamp = views.back().stamp;
  result.T_world_odom = grounded.T_world_body;
  result.covariance = grounded.covariance;
  result.views = static_cast<int>(views.size());
  result.ground_chi2 = grounded.chi2;
  return result;
}

std::optional<Alignment> FrameAligner::add(const AlignmentView& view) {
  if (is_final() || (forgotten_ && view.stamp <= *forgotten_)) return std::nullopt;
  ARPENT_ASSERT(views_.empty() || view.stamp > views_.back().stamp);
  views_.push_back(view);
  if (static_cast<int>(views_.size()) > 2 * params_.max_views) views_.pop_front();
  const std::deque<AlignmentView> agreeing = largest_agreement();
  if (agreeing.back().stamp != view.stamp && agreeing.size() > 1) {
    ++disagreeing_;
    return std::nullopt;
  }
  const int count = static_cast<int>(agreeing.size());
  const int wanted = alignment_ ? std::min(2 * alignment_->views, params_.max_views) : params_.views;
  if (count < wanted) return std::nullopt;
  alignment_ = average(agreeing);
  return alignment_;
}

}  // namespace arpent::tags
