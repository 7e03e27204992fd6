// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// `./arpent import`: public data sets, or the rendered sequence, to a log.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "common/error.h"
#include "tools/import/import.h"

int main(int argc, char** argv) {
  using namespace arpent::tools;
  CLI::App app{"Turns a stereo data set into an LCM log for `./arpent replay`."};
  app.name("arpent import");
  std::string folder;
  std::string log;
  double duration_s = 12;
  auto* kitti = app.add_subcommand("kitti", "KITTI odometry: image_0, image_1, calib.txt, poses.txt, times.txt");
  auto* euroc = app.add_subcommand("euroc", "EuRoC (ASL): mav0/cam0, mav0/cam1, state_groundtruth_estimate0");
  auto* rendered = app.add_subcommand("rendered", "the sequence that the project renders itself, with its truth");
  for (auto* set : {kitti, euroc}) set->add_option("DIR", folder, "folder of the data set")->required();
  for (auto* set : {kitti, euroc, rendered}) set->add_option("--out", log, "the log to write")->required();
  rendered->add_option("--duration-s", duration_s, "length of the drive [s]")->check(CLI::Range(0.2, 600.0));
  app.require_subcommand(1);
  try {
    app.parse(argc, argv);
    const ImportCounts counts = *kitti   ? import_kitti(folder, log)
                                : *euroc ? import_euroc(folder, log)
                                         : import_rendered(duration_s, log);
    std::printf("%s: %lld pairs, %lld true poses", log.c_str(), static_cast<long long>(counts.pairs),
                static_cast<long long>(counts.poses));
    if (counts.unpaired > 0)
      std::printf(", %lld images without a partner left out", static_cast<long long>(counts.unpaired));
    std::printf("\nnext: ./arpent replay %s --report DIR\n", log.c_str());
    return 0;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const arpent::InputError& error) {
    std::fprintf(stderr, "import: %s\n", error.what());
    return 2;
  }
}
