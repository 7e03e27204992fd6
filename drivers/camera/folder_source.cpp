// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/camera/folder_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "common/error.h"
#include "drivers/camera/gray.h"

namespace arpent::camera {
namespace {

namespace fs = std::filesystem;

const std::set<std::string> kExtensions = {".png", ".pgm", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff"};
constexpr std::pair<const char*, const char*> kFolders[] = {
    {"left", "right"}, {"cam0/data", "cam1/data"}, {"cam0", "cam1"}, {"image_0", "image_1"}};
/// A name of so many digits is a time in nanoseconds since 1970, not a number.
constexpr std::size_t kNanosecondDigits = 16;

std::vector<fs::path> images(const fs::path& folder, const std::string& prefix) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const fs::path& file = entry.path();
    if (entry.is_regular_file() && kExtensions.count(file.extension().string()) > 0 &&
        file.filename().string().rfind(prefix, 0) == 0) {
      files.push_back(file);
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

FolderListing list_images(const fs::path& folder) {
  for (const auto& [left, right] : kFolders) {
    if (fs::is_directory(folder / left) && fs::is_directory(folder / right)) {
      return {images(folder / left, ""), images(folder / right, ""), {}};
    }
  }
  return {images(folder, "left"), images(folder, "right"), {}};
}

std::vector<double> read_seconds(const fs::path& file) {
  std::ifstream in(file);
  std::vector<double> seconds;
  std::string line;
  while (std::getline(in, line)) {
    if (line.empty() || line[0] == '#') continue;
    char* end = nullptr;
    seconds.push_back(std::strtod(line.c_str(), &end));
    if (end == line.c_str()) throw InputError(fmt::format("{}: '{}' is no time in seconds", file.string(), line));
  }
  return seconds;
}

bool is_nanoseconds(const fs::path& file) {
  const std::string stem = file.stem().string();
  return stem.size() >= kNanosecondDigits && stem.size() <= 19 &&
         std::all_of(stem.begin(), stem.end(), [](char c) { return c >= '0' && c <= '9'; });
}

std::vector<Duration> times(const FolderListing& listing, const FolderParams& params) {
  const std::size_t count = listing.left.size();
  std::vector<Duration> time;
  const fs::path file = params.path / "timestamps.txt";
  if (fs::exists(file)) {
    const std::vector<double> seconds = read_seconds(file);
    if (seconds.size() != count) {
      throw InputError(fmt::format("{}: {} times for {} pairs", file.string(), seconds.size(), count));
    }
    for (const double s : seconds) time.push_back(from_seconds(s - seconds.front()));
  } else if (std::all_of(listing.left.begin(), listing.left.end(), is_nanoseconds)) {
    const auto ns = [&](std::size_t i) { return std::stoll(listing.left[i].stem().string()); };
    for (std::size_t i = 0; i < count; ++i) time.emplace_back((ns(i) - ns(0)) / 1000);
  } else {
    for (std::size_t i = 0; i < count; ++i) time.push_back(from_seconds(static_cast<double>(i) / params.rate_hz));
  }
  const auto stuck = std::adjacent_find(time.begin(), time.end(), std::greater_equal<>());
  if (stuck != time.end()) {
    throw InputError(fmt::format("{}: the time of pair {} does not lie after the one before", params.path.string(),
                                 stuck - time.begin() + 1));
  }
  return time;
}

/// One side of the folder.
class FolderSource : public FrameSource {
 public:
  FolderSource(const FolderParams& params, std::vector<fs::path> files, std::vector<Duration> time,
               std::function<Time()> now, Time start)
      : params_(params), files_(std::move(files)), time_(std::move(time)), now_(std::move(now)), start_(start) {}

  std::optional<Frame> next(Duration /*wait*/) override {
    while (const auto due = next_due()) {
      if (*due > now_()) return std::nullopt;
      const std::int64_t number = number_++;
      auto image = to_gray8(cv::imread(files_[index(number)].string(), cv::IMREAD_UNCHANGED));
      if (image) return Frame{*image, number, 0, 0, *due, *due, 0, 0};
      ++incomplete_;
    }
    return std::nullopt;
  }
  std::int64_t incomplete() const override { return incomplete_; }

 private:
  std::size_t index(std::int64_t number) const { return static_cast<std::size_t>(number) % files_.size(); }

  std::optional<Time> next_due() const {
    const auto count = static_cast<std::int64_t>(files_.size());
    if (!params_.repeat && number_ >= count) return std::nullopt;
    // Played again, the first pair follows the last by one mean period.
    const double last_s = to_seconds(time_.back());
    const double round_s =
        count > 1 ? last_s * static_cast<double>(count) / static_cast<double>(count - 1) : 1 / params_.rate_hz;
    const double since_s = static_cast<double>(number_ / count) * round_s + to_seconds(time_[index(number_)]);
    return start_ + from_seconds(since_s / params_.speed);
  }

  FolderParams params_;
  std::vector<fs::path> files_;
  std::vector<Duration> time_;
  std::function<Time()> now_;
  Time start_;
  std::int64_t number_ = 0;
  std::int64_t incomplete_ = 0;
};

}  // namespace

FolderListing list_folder(const FolderParams& params) {
  if (!fs::is_directory(params.path)) throw InputError(params.path.string() + ": is no folder");
  FolderListing listing = list_images(params.path);
  if (listing.left.empty() || listing.left.size() != listing.right.size()) {
    throw InputError(
        fmt::format("{}: {} left and {} right images; looked for left/ and right/, cam0/ and cam1/, image_0/ "
                    "and image_1/, left* and right*",
                    params.path.string(), listing.left.size(), listing.right.size()));
  }
  listing.time = times(listing, params);
  return listing;
}

std::pair<std::unique_ptr<FrameSource>, std::unique_ptr<FrameSource>> open_folder(const FolderParams& params,
                                                                                  const std::function<Time()>& now) {
  FolderListing listing = list_folder(params);
  const Time start = now();
  return {std::make_unique<FolderSource>(params, std::move(listing.left), listing.time, now, start),
          std::make_unique<FolderSource>(params, std::move(listing.right), listing.time, now, start)};
}

}  // namespace arpent::camera
