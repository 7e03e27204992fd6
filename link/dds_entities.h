// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The DDS side of one station: domain, participant, and a writer and a reader for each of the three envelopes.
#pragma once

#include <dds/dds.h>

#include <string>

#include "link/params.h"

namespace arpent::link {

class Entities {
 public:
  /// Throws InputError, saying what is missing, if there is no way to connect now.
  explicit Entities(const LinkParams& params);
  ~Entities();
  Entities(const Entities&) = delete;
  Entities& operator=(const Entities&) = delete;

  struct Ends {
    dds_entity_t writer = 0;
    dds_entity_t reader = 0;
  };
  Ends beats, commands, parts;
  dds_entity_t control_waitset = 0;  ///< triggered by beats and commands that wait to be taken
  dds_entity_t bulk_waitset = 0;     ///< by parts

 private:
  void create(const LinkParams& params);
  Ends open(const dds_topic_descriptor_t& type, const char* name, dds_qos_t* qos, dds_entity_t waitset) const;

  dds_entity_t domain_ = 0;
  dds_entity_t participant_ = 0;
};

}  // namespace arpent::link
