// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/tour/tsplib.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/error.h"

namespace arpent::tour {
namespace {

const std::string kHead =
    "NAME: three\nTYPE: ATSP\nCOMMENT: by hand: 3 nodes\nDIMENSION : 3\n"
    "EDGE_WEIGHT_TYPE: EXPLICIT\nEDGE_WEIGHT_FORMAT: FULL_MATRIX\n";

std::string fault(const std::string& text) {
  try {
    (void)parse_tsplib(text, "f.atsp");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Tsplib, ReadsAMatrixBrokenAnywhereWithItsForbiddenDiagonal) {
  const TsplibProblem p =
      parse_tsplib(kHead + "EDGE_WEIGHT_SECTION\r\n 9999 1 2 3\n\n9999 4 5\n6 9999\nEOF\n", "f.atsp");
  Matrix expected(3, 3);
  expected << 0, 1, 2, 3, 0, 4, 5, 6, 0;
  EXPECT_EQ(p.cost, expected);
  EXPECT_EQ(p.name, "three");
  EXPECT_TRUE(p.whole_numbers);
}

TEST(Tsplib, FaultsNameFileLineAndCause) {
  const std::string section = "EDGE_WEIGHT_SECTION\n";
  EXPECT_EQ(fault(kHead + section + "1 2 3\n4 x 6\n"), "f.atsp:9: 'x' is not a number");
  EXPECT_EQ(fault(kHead + section + "1 2 3\n4 5 6\n"), "f.atsp:9: the file ends after 6 of 9 weights");
  EXPECT_EQ(fault(kHead + section + "1 2 3\n4 5 6\n7 8 EOF\n"), "f.atsp:10: the file ends after 8 of 9 weights");
  EXPECT_THAT(fault(kHead + section + "1 2 3 4 5 6 7 8 9 10\n"), testing::HasSubstr("more than DIMENSION x DIMENSION"));
  EXPECT_THAT(fault(kHead + section + "1 2 3 4 5 6 7 8 9\n10\n"),
              testing::HasSubstr("more than DIMENSION x DIMENSION"));
  EXPECT_THAT(fault(kHead + section + "1 2 3 4 5 6 7 8 nan\n"), testing::HasSubstr("'nan' is not a number"));
  EXPECT_THAT(fault(kHead), testing::HasSubstr("no EDGE_WEIGHT_SECTION"));
  EXPECT_THAT(fault(""), testing::HasSubstr("no EDGE_WEIGHT_SECTION"));
  EXPECT_THAT(fault(section + "1"), testing::HasSubstr("DIMENSION must come before"));
  EXPECT_THAT(fault("DIMENSION: -3\n"), testing::HasSubstr("must be a whole number from 1"));
  EXPECT_THAT(fault("DIMENSION: 1e9\n"), testing::HasSubstr("must be a whole number from 1"));
  EXPECT_THAT(fault("TYPE: CVRP\n"), testing::HasSubstr("only ATSP and TSP"));
  EXPECT_THAT(fault("EDGE_WEIGHT_TYPE: EUC_2D\n"), testing::HasSubstr("only EXPLICIT"));
  EXPECT_THAT(fault("EDGE_WEIGHT_FORMAT: UPPER_ROW\n"), testing::HasSubstr("only FULL_MATRIX"));
  EXPECT_THAT(fault("hello\n"), testing::HasSubstr("neither"));
}

TEST(Tsplib, AFileThatIsNotThereIsRefused) {
  EXPECT_THROW((void)read_tsplib("no/such.atsp"), InputError);
}

}  // namespace
}  // namespace arpent::tour
