// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// `./arpent camera`: which cameras are there; and two GigE Vision cameras served from this machine, to try the camera
// driver without any.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <csignal>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <thread>

#include "common/error.h"
#include "drivers/camera/aravis_source.h"
#include "drivers/camera/folder_source.h"
#include "drivers/camera/gray.h"
#include "drivers/camera/gv_server.h"
#include "drivers/camera/v4l2_source.h"

namespace {

using namespace arpent;
using namespace arpent::camera;

volatile std::sig_atomic_t g_stop = 0;

int list(bool with_fake) {
  const auto genicam = list_aravis(with_fake);
  const auto v4l2 = list_v4l2();
  for (const auto& c : genicam) fmt::print("{:12} {:40} {}\n", c.protocol, c.name, c.address);
  for (const auto& c : v4l2) fmt::print("{:12} {:40} {}\n", "V4L2", c.device, c.name);
  if (genicam.empty() && v4l2.empty()) {
    fmt::print(
        "no camera answers. USB3 Vision: is config/udev/60-arpent-cameras.rules installed? GigE Vision: is the "
        "camera's address in the network of one of this machine's cards? docs/cameras.md says more.\n");
  }
  return 0;
}

struct Mock {
  std::string left_address = "127.0.0.1";
  std::string right_address;
  std::string folder;
  double rate_hz = 5;
  double run_for_s = 0;
};

/// Random dots that move; the right camera sees them 20 px further left.
cv::Mat1b dots(const GvServer::Request& request, std::int64_t number, int disparity_px) {
  cv::Mat1b image(request.size_px);
  const int shift = static_cast<int>(number * 3 % 4096) + disparity_px;
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const auto cell = static_cast<std::uint32_t>((x + shift) / 4 * 7919 + y / 4 * 104729);
      image(y, x) = static_cast<std::uint8_t>(40 + (cell * 2654435761U >> 24) / 2);
    }
  }
  return image;
}

GvServer::Render render(const Mock& mock, const std::optional<FolderListing>& listing, bool left) {
  return [mock, listing, left](const GvServer::Request& request) {
    // Both cameras tick at multiples of the period, so that this number is the same for both.
    const auto number = static_cast<std::int64_t>(to_seconds(request.device_time.time_since_epoch()) * mock.rate_hz);
    if (!listing) return dots(request, number, left ? 0 : 20);
    const auto& files = left ? listing->left : listing->right;
    const auto& file = files[static_cast<std::size_t>(number) % files.size()];
    const auto image = to_gray8(cv::imread(file.string(), cv::IMREAD_UNCHANGED));
    return image ? cv::Mat1b(*image) : cv::Mat1b();
  };
}

int serve(const Mock& mock) {
  std::optional<FolderListing> listing;
  if (!mock.folder.empty()) {
    FolderParams params;
    params.path = mock.folder;
    listing = list_folder(params);
  }
  const GvServer left(mock.left_address, "L1", render(mock, listing, true));
  std::optional<GvServer> right;
  if (!mock.right_address.empty()) right.emplace(mock.right_address, "R1", render(mock, listing, false));
  fmt::print("serving GigE Vision cameras on {} {}; the client sets size and rate ({} Hz for matching pairs)\n",
             mock.left_address, mock.right_address, mock.rate_hz);
  std::fflush(stdout);
  std::signal(SIGINT, [](int) { g_stop = 1; });
  std::signal(SIGTERM, [](int) { g_stop = 1; });
  const auto end =
      std::chrono::steady_clock::now() + std::chrono::duration<double>(mock.run_for_s > 0 ? mock.run_for_s : 1e9);
  while (g_stop == 0 && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Finds cameras, and stands in for them."};
  app.name("arpent camera");
  bool with_fake = false;
  Mock mock;
  auto* list_command = app.add_subcommand("list", "the cameras that answer: name, address");
  list_command->add_flag("--fake", with_fake, "Aravis' built-in camera too");
  auto* mock_command = app.add_subcommand("mock", "serves GigE Vision cameras from this machine");
  mock_command->add_option("--left-address", mock.left_address, "an address of this machine")->capture_default_str();
  mock_command->add_option("--right-address", mock.right_address, "another one; none: one camera only");
  mock_command->add_option("--folder", mock.folder, "image files to serve (docs/cameras.md); none: moving dots");
  mock_command->add_option("--rate-hz", mock.rate_hz, "rate that the client will set")
      ->capture_default_str()
      ->check(CLI::Range(0.1, 1000.0));
  mock_command->add_option("--run-for-s", mock.run_for_s, "end by itself")->check(CLI::PositiveNumber);
  app.require_subcommand(1);
  try {
    app.parse(argc, argv);
    return *list_command ? list(with_fake) : serve(mock);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const InputError& error) {
    std::fprintf(stderr, "camera: %s\n", error.what());
    return 2;
  }
}
