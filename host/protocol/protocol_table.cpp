// SPDX-License-Identifier: Apache-2.0
#include "host/protocol/protocol_table.hpp"

#include "shared/hash/crc.hpp"
#include "shared/hash/fnv.hpp"
#include "shared/link/schema.hpp"

namespace sc::host {
namespace {

struct FieldLister {
    std::vector<ProtocolField>& fields;
    template <class T>
    void operator()(std::string_view name, const T& /*value*/) {
        const link::FieldType type = link::FieldTypeOf<T>::value;
        fields.push_back({std::string(name), std::string(type.base), type.count});
    }
};

template <class List>
void add_messages(std::vector<ProtocolMessage>& all, bool to_controller) {
    link::for_each_message(List{}, [&all, to_controller]<class Message>(const Message& message) {
        ProtocolMessage& row = all.emplace_back();
        row.id = Message::kId;
        row.name = Message::kName;
        row.to_controller = to_controller;
        row.since = link::since<Message>();
        row.largest_payload = link::largest_payload<Message>();
        FieldLister lister{row.fields};
        Message::visit(lister, message);
    });
}

std::uint32_t crc_of(std::uint64_t data_id) {
    std::array<std::uint8_t, 8> bytes{};
    ByteWriter(bytes).put(data_id);
    return crc32(bytes);
}

}  // namespace

const std::vector<ProtocolMessage>& protocol_messages() {
    static const std::vector<ProtocolMessage> kAll = [] {
        std::vector<ProtocolMessage> all;
        add_messages<link::HostMessages>(all, true);
        add_messages<link::CellMessages>(all, false);
        return all;
    }();
    return kAll;
}

std::vector<ProtocolVersion> protocol_versions() {
    std::vector<ProtocolVersion> all;
    for (std::size_t minor = link::kSchemaHashes.size(); minor-- > 0;) {
        const std::uint64_t schema = link::kSchemaHashes.at(minor);
        all.push_back({static_cast<std::uint8_t>(minor), schema, crc_of(schema)});
    }
    return all;
}

std::uint32_t handshake_crc() { return crc_of(fnv1a64("scribecell handshake")); }

std::string protocol_version_text() {
    return std::to_string(link::kProtocolMajor) + "." + std::to_string(link::kProtocolMinor);
}

std::size_t largest_bytes() noexcept { return std::tuple_size_v<decltype(link::Bytes::data)>; }

}  // namespace sc::host
