// SPDX-License-Identifier: Apache-2.0
#include "host/formats/cameras.hpp"

#include <algorithm>
#include <cmath>

#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/formats/toml_reader.hpp"
#include "host/formats/toml_writer.hpp"

namespace sc::host {
namespace {

constexpr std::string_view kFormat = "scribecell-cameras";
constexpr Limits kFocal{1.0, 1e6};
constexpr Limits kMiddle{-1e5, 1e5};
constexpr Limits kNoise{0.0, 1e3};
constexpr std::int64_t kLargestSide = 100'000;

std::string order_of(std::size_t cameras) {
    std::string out;
    for (std::size_t i = 0; i < cameras; ++i) {
        for (const std::string_view name : kCameraParameters) {
            out += (out.empty() ? "" : ",") + std::string(name) + (cameras > 1 ? (i == 0 ? "_l" : "_r") : "");
        }
    }
    return out + (cameras > 1 ? ",rx,ry,rz,tx,ty,tz" : "");
}

std::size_t size_of(std::size_t cameras) { return cameras * CameraModel::kParameters + (cameras > 1 ? 6 : 0); }

CameraRecord read_camera(TomlReader& table) {
    CameraRecord out;
    out.id = table.text("id");
    out.width = static_cast<int>(table.integer("width_px", 1, kLargestSide));
    out.height = static_cast<int>(table.integer("height_px", 1, kLargestSide));
    out.model.focal_x = table.number("fx_px", kFocal);
    out.model.focal_y = table.number("fy_px", kFocal);
    out.model.middle_x = table.number("cx_px", kMiddle);
    out.model.middle_y = table.number("cy_px", kMiddle);
    const auto distortion = table.numbers("k1_k2_p1_p2_k3", 5);
    std::ranges::copy(distortion, out.model.distortion.begin());
    if (table.has("fixed")) {
        out.fixed = table.texts("fixed");
    }
    for (const std::string& name : out.fixed) {
        if (std::ranges::find(kCameraParameters, name) == kCameraParameters.end()) {
            table.fail("fixed", "is no parameter of a camera", name, "use fx, fy, cx, cy, k1, k2, p1, p2, k3");
        }
    }
    out.rms = table.number_or("rms_px", 0.0, kNoise);
    out.reach = table.number_or("reach", 0.0, {0.0, 100.0});
    table.finish();
    return out;
}

CameraSet parse_cameras(const std::filesystem::path& path, std::string_view text) {
    TomlDocument document(path, text, kFormat);
    TomlReader& root = document.root();
    CameraSet out;
    out.id = root.text("id");
    out.time = root.time("time");
    out.parents = root.texts("parents");
    out.noise = root.number("noise_px", kNoise);
    for (TomlReader& table : root.tables("camera")) {
        out.cameras.push_back(read_camera(table));
    }
    if (out.cameras.empty() || out.cameras.size() > 2) {
        throw InputError({.file = path.string(),
                          .problem = "a set has one camera, or two of a pair",
                          .value = std::to_string(out.cameras.size()),
                          .action = "give [[camera]] once, or first the left and then the right one"});
    }
    if (out.cameras.size() == 2) {
        TomlReader pair = root.table("right_from_left");
        out.right_from_left =
            CameraSet::Pose{.rotation = pair.rotation("rotation"), .translation = pair.vector_mm("translation_mm")};
        if (!(norm(out.right_from_left->translation) > 0.0)) {
            pair.fail("translation_mm", "both cameras stand at one place", "0",
                      "give the place of the left camera in "
                      "the frame of the right one");
        }
        pair.finish();
    }
    if (const auto table = root.table_if("covariance")) {
        TomlReader covariance = *table;
        const std::size_t size = size_of(out.cameras.size());
        const std::string order = covariance.text("order");
        if (order != order_of(out.cameras.size())) {
            covariance.fail("order", "is not the order of this format", order,
                            "write the rows as " + order_of(out.cameras.size()));
        }
        out.covariance = covariance.matrix("rows", size, size);
        for (std::size_t i = 0; i < size; ++i) {
            if (!(out.covariance[i][i] >= 0.0)) {
                covariance.fail("rows", "a variance is below zero", std::to_string(out.covariance[i][i]),
                                "calibrate again");
            }
        }
        covariance.finish();
    }
    root.finish();
    return out;
}

}  // namespace

CameraSet read_cameras(const std::filesystem::path& path) { return parse_cameras(path, read_text_file(path)); }

void write_cameras(const std::filesystem::path& path, const CameraSet& set) {
    TomlWriter out(kFormat);
    out.text("id", set.id);
    out.text("time", set.time);
    out.texts("parents", set.parents);
    out.number("noise_px", set.noise);
    for (const CameraRecord& camera : set.cameras) {
        out.item("camera");
        out.text("id", camera.id);
        out.integer("width_px", camera.width);
        out.integer("height_px", camera.height);
        out.number("fx_px", camera.model.focal_x);
        out.number("fy_px", camera.model.focal_y);
        out.number("cx_px", camera.model.middle_x);
        out.number("cy_px", camera.model.middle_y);
        out.numbers("k1_k2_p1_p2_k3", {camera.model.distortion.begin(), camera.model.distortion.end()});
        if (!camera.fixed.empty()) {
            out.texts("fixed", camera.fixed);
        }
        out.number("rms_px", camera.rms);
        out.number("reach", camera.reach);
    }
    if (set.right_from_left) {
        out.table("right_from_left");
        out.rotation("rotation", set.right_from_left->rotation);
        out.vector("translation_mm", set.right_from_left->translation, 1e3);
    }
    if (!set.covariance.empty()) {
        out.table("covariance");
        out.text("order", order_of(set.cameras.size()));
        out.matrix("rows", set.covariance);
    }
    static_cast<void>(parse_cameras(path, out.str()));  // what would be refused is not written
    write_text_file(path, out.str());
}

}  // namespace sc::host
