// SPDX-License-Identifier: Apache-2.0
#include "host/formats/dxf.hpp"

#include <cctype>
#include <set>

#include "host/formats/file.hpp"
#include "host/formats/text.hpp"

namespace sc::host {

namespace {

std::string layer_name(const std::string& text) {
    std::string out;
    for (const char c : text) {
        out += std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_' ? c : '_';
    }
    return out.empty() ? "0" : out;
}

void add(std::string& out, int code, const std::string& value) { out += std::to_string(code) + "\n" + value + "\n"; }

void add_place(std::string& out, const Vec3& place) {
    add(out, 10, fixed(1e3 * place.x, 4));
    add(out, 20, fixed(1e3 * place.y, 4));
    add(out, 30, fixed(1e3 * place.z, 4));
}

}  // namespace

void write_dxf(const std::filesystem::path& path, const std::vector<DxfLine>& lines) {
    std::set<std::string> layers;
    for (const DxfLine& line : lines) {
        layers.insert(layer_name(line.layer));
    }
    std::string out;
    add(out, 0, "SECTION");
    add(out, 2, "HEADER");
    add(out, 9, "$ACADVER");
    add(out, 1, "AC1009");
    add(out, 0, "ENDSEC");
    add(out, 0, "SECTION");
    add(out, 2, "TABLES");
    add(out, 0, "TABLE");
    add(out, 2, "LAYER");
    add(out, 70, std::to_string(layers.size()));
    int colour = 1;
    for (const std::string& layer : layers) {
        add(out, 0, "LAYER");
        add(out, 2, layer);
        add(out, 70, "0");
        add(out, 62, std::to_string(colour % 6 + 1));
        add(out, 6, "CONTINUOUS");
        ++colour;
    }
    add(out, 0, "ENDTAB");
    add(out, 0, "ENDSEC");
    add(out, 0, "SECTION");
    add(out, 2, "ENTITIES");
    for (const DxfLine& line : lines) {
        const std::string layer = layer_name(line.layer);
        add(out, 0, "POLYLINE");
        add(out, 8, layer);
        add(out, 66, "1");
        add_place(out, {});
        add(out, 70, line.closed ? "9" : "8");  // 8: in space, 1: closed
        for (const Vec3& place : line.places) {
            add(out, 0, "VERTEX");
            add(out, 8, layer);
            add_place(out, place);
            add(out, 70, "32");
        }
        add(out, 0, "SEQEND");
        add(out, 8, layer);
    }
    add(out, 0, "ENDSEC");
    add(out, 0, "EOF");
    write_text_file(path, out);
}

}  // namespace sc::host
