// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "link/dds_entities.h"

#include <net/if.h>

#include <memory>

#include "common/error.h"
#include "link/dds_settings.h"
#include "link_messages.h"

namespace arpent::link {
namespace {

/// Commands that may be on their way to somebody who is cut off; older ones make room.
constexpr int kCommandHistory = 256;

using Qos = std::unique_ptr<dds_qos_t, decltype(&dds_delete_qos)>;

Qos make_qos(bool reliable, int history, bool keep_for_late_comers) {
  Qos qos(dds_create_qos(), &dds_delete_qos);
  dds_qset_reliability(qos.get(), reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT, DDS_MSECS(10));
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, history);
  dds_qset_durability(qos.get(), keep_for_late_comers ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_durability_service(qos.get(), 0, DDS_HISTORY_KEEP_LAST, history, DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED,
                              DDS_LENGTH_UNLIMITED);
  dds_qset_writer_data_lifecycle(qos.get(), false);
  dds_qset_ignorelocal(qos.get(), DDS_IGNORELOCAL_PROCESS);
  return qos;
}

dds_entity_t checked(dds_entity_t entity, const char* what) {
  if (entity < 0)
    throw InputError(std::string("the radio link cannot make its ") + what + ": " + dds_strretcode(entity));
  return entity;
}

}  // namespace

Entities::Entities(const LinkParams& params) {
  if (if_nametoindex(params.interface.c_str()) == 0) {
    throw InputError("there is no network interface " + params.interface + " (link.interface); `ip link` lists them");
  }
  try {
    create(params);
  } catch (...) {
    if (domain_ > 0) dds_delete(domain_);
    throw;
  }
}

Entities::~Entities() {
  dds_delete(domain_);
}

void Entities::create(const LinkParams& params) {
  const auto id = static_cast<dds_domainid_t>(params.domain);
  domain_ = checked(dds_create_domain(id, cyclone_config(params).c_str()), "domain");
  const Qos qos(dds_create_qos(), &dds_delete_qos);
  for (const auto& [name, value] : security_properties(params)) dds_qset_prop(qos.get(), name.c_str(), value.c_str());
  participant_ = checked(dds_create_participant(id, qos.get(), nullptr),
                         "participant (is the interface up, with an address? do the keys fit, is the date right?)");
  control_waitset = checked(dds_create_waitset(participant_), "waitset");
  bulk_waitset = checked(dds_create_waitset(participant_), "waitset");
  beats = open(arpent_link_BeatSample_desc, "arpent_beats", make_qos(false, 1, false).get(), control_waitset);
  commands = open(arpent_link_CommandSample_desc, "arpent_commands", make_qos(true, kCommandHistory, false).get(),
                  control_waitset);
  parts =
      open(arpent_link_PartSample_desc, "arpent_parts", make_qos(true, params.patch_history, true).get(), bulk_waitset);
}

Entities::Ends Entities::open(const dds_topic_descriptor_t& type, const char* name, dds_qos_t* qos,
                              dds_entity_t waitset) const {
  const dds_entity_t topic = checked(dds_create_topic(participant_, &type, name, nullptr, nullptr), "topic");
  Ends ends;
  ends.reader = checked(dds_create_reader(participant_, topic, qos, nullptr), "reader");
  ends.writer = checked(dds_create_writer(participant_, topic, qos, nullptr), "writer");
  const dds_entity_t any = checked(dds_create_readcondition(ends.reader, DDS_ANY_STATE), "read condition");
  dds_waitset_attach(waitset, any, ends.reader);
  return ends;
}

}  // namespace arpent::link
