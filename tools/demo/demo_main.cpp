// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// `./arpent demo`: from stereo images to a mesh and a report, with nothing else needed. With ARPENT_DATA it shows a
// real sequence, otherwise one that the project renders itself.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <opencv2/core.hpp>

#include "common/error.h"
#include "tools/import/import.h"
#include "tools/replay/summary.h"

namespace fs = std::filesystem;

int main(int argc, char** argv) {
  using namespace arpent;
  CLI::App app{"Shows the chain from stereo images to a mesh, and writes a report."};
  app.name("arpent demo");
  std::string out = "out/demo";
  bool rendered = false;
  app.add_option("--out", out, "folder for the report")->capture_default_str();
  app.add_flag("--rendered", rendered, "the rendered sequence, even if real data is at hand");
  try {
    app.parse(argc, argv);
    cv::setNumThreads(1);
    fs::create_directories(out);
    const fs::path log = fs::path(out) / "demo.lcmlog";
    const char* data = std::getenv("ARPENT_DATA");
    const fs::path real = data != nullptr ? fs::path(data) / "vo" / "kitti06_0000-0039" : fs::path();
    if (!rendered && data != nullptr && fs::is_directory(real)) {
      std::printf("1/2 a real drive: 40 stereo pairs of KITTI\n");
      tools::import_kitti(real, log);
    } else {
      std::printf("1/2 rendering a drive through the test arena: 61 stereo pairs\n");
      tools::import_rendered(12.0, log);
    }
    std::printf("2/2 depth, odometry, map\n");
    const tools::ReplayInput input = tools::open_log(log, out, "", {});
    const tools::ReplayResult result = tools::run_lockstep(input, {});
    const tools::Summary summary = tools::summarise(input, result, nullptr);
    tools::write_replay_report(out, input, result, summary);
    tools::print(summary);
    std::printf("report: %s\n", (fs::absolute(out) / "report.html").c_str());
    return 0;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "demo: %s\n", error.what());
    return 2;
  }
}
