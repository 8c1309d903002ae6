// SPDX-License-Identifier: Apache-2.0
#include "host/cli/cad_input.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <sstream>
#include <string>

#include "host/bridge/errors.hpp"
#include "host/bridge/program.hpp"
#include "host/formats/error.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kProgram = "scribecell-step";
constexpr const char* kDeflectionMm = "0.01";

bool is_step(const std::filesystem::path& path) {
    std::array<char, 13> start{};
    std::ifstream(path, std::ios::binary).read(start.data(), 12);
    return std::string(start.data()) == "ISO-10303-21";
}

[[noreturn]] void refuse(const std::filesystem::path& path, const std::string& problem, const std::string& action) {
    throw InputError({.file = path.string(), .problem = problem, .action = action});
}

}  // namespace

MeshFile read_cad(const std::filesystem::path& path, const LengthUnit& unit) {
    if (!is_step(path)) {
        return read_mesh(path, unit);
    }
    std::filesystem::path program;
    try {
        program = required_program(kProgram);
    } catch (const CellError&) {
        refuse(path, "is a STEP file, and this scribecell was built without Open CASCADE",
               "install libocct-data-exchange-dev (tier step) and build again, as ./run does by itself; or export STL");
    }
    const ProgramOutput output = run_program(program, {path.string(), kDeflectionMm});
    if (output.exit_code != 0) {
        refuse(path, "cannot be read as STEP; the reason stands above", "export the part again, as one closed solid");
    }
    MeshFile out;
    out.unit = {.name = "mm", .metres = 1e-3};
    std::istringstream in(output.text);
    for (char kind = 0; in >> kind;) {
        if (kind == 'v') {
            Vec3 v;
            in >> v.x >> v.y >> v.z;
            out.mesh.vertices.push_back(1e-3 * v);
        } else {
            std::array<std::uint32_t, 4> t{};
            in >> t[0] >> t[1] >> t[2] >> t[3];
            ++out.read;
            if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) {
                out.mesh.triangles.push_back({t[0], t[1], t[2]});
                out.mesh.face.push_back(t[3]);
            }
        }
    }
    const bool whole = std::ranges::all_of(out.mesh.triangles, [&](const auto& t) {
        return std::ranges::all_of(t, [&](std::uint32_t i) { return i < out.mesh.vertices.size(); });
    });
    if (out.mesh.triangles.empty() || !whole || in.bad()) {
        refuse(path, "gave no triangles", "export the part again, as one closed solid");
    }
    out.dropped = out.read - out.mesh.triangles.size();
    return out;
}

}  // namespace sc::host::cli
