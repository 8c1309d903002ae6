// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "host/cli/failure.hpp"
#include "host/cli/subcommands.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/protocol/capture_decoder.hpp"
#include "host/protocol/dbc_files.hpp"
#include "host/protocol/dissector.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kExamples = R"(Examples:
  scribecell protocol --write docs/protocol
      the link for other tools: scribecell.dbc, scribecell_messages.dbc and scribecell.lua
  scribecell scribe --face 0 --link 'sim:?carrier=can' --capture job.pcap
  scribecell protocol --decode job.pcap
      what passed between host and cell, one line a message
  scribecell protocol --decode job.pcap --json
  tshark -X lua_script:docs/protocol/scribecell.lua -r job.pcap
      the same by Wireshark's text program

docs/protocol.md tells how the files are used.)";

struct ProtocolOptions {
    std::optional<std::filesystem::path> write;
    std::optional<std::filesystem::path> decode;
    bool json = false;
};

void write_files(const std::filesystem::path& folder) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) {
        throw InputError({.file = folder.string(),
                          .problem = "cannot be made: " + error.message(),
                          .value = {},
                          .action = "name a folder that you may write to"});
    }
    write_text_file(folder / "scribecell.dbc", frames_dbc());
    write_text_file(folder / "scribecell_messages.dbc", messages_dbc());
    write_text_file(folder / "scribecell.lua", wireshark_dissector());
}

int run(const ProtocolOptions& options) {
    if (options.write.has_value() == options.decode.has_value()) {
        throw InputError({.file = {},
                          .problem = "there is either something to write or something to decode",
                          .value = {},
                          .action = "give --write DIR or --decode FILE"});
    }
    if (options.write) {
        write_files(*options.write);
        return 0;
    }
    const DecodedCapture capture = decode_capture(*options.decode);
    const std::string text = options.json ? to_json(capture).dump(1) + "\n" : text_of(capture);
    std::fputs(text.c_str(), stdout);
    return 0;
}

}  // namespace

void add_protocol(CLI::App& app, int& exit_code) {
    CLI::App* sub = app.add_subcommand("protocol", "The link for other tools: DBC, Wireshark dissector, captures.");
    sub->footer(kExamples);
    const auto options = std::make_shared<ProtocolOptions>();
    sub->add_option("--write", options->write, "write DBC files and Wireshark dissector to this folder")
        ->type_name("DIR");
    sub->add_option("--decode", options->decode,
                    "print the messages of a capture (--capture of other commands, or SocketCAN)")
        ->type_name("FILE.pcap");
    sub->add_flag("--json", options->json, "--decode: one JSON object");
    sub->callback([options, &exit_code] { exit_code = guarded(options->json, [&options] { return run(*options); }); });
}

}  // namespace sc::host::cli
