// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/split.h"

#include <gmock/gmock.h>

namespace arpent {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(Split, PiecesStandAsTheyAreBetweenSeparators) {
  EXPECT_THAT(split("R1,R2, R3", ','), ElementsAre("R1", "R2", " R3"));
  EXPECT_THAT(split("a;b", ','), ElementsAre("a;b"));
  EXPECT_THAT(split(",a,,b", ','), ElementsAre("", "a", "", "b"));
}

TEST(Split, NothingGivesNothingAndALastSeparatorEndsTheListOnly) {
  EXPECT_THAT(split("", ','), IsEmpty());
  EXPECT_THAT(split("a,b,", ','), ElementsAre("a", "b"));
}

}  // namespace
}  // namespace arpent
